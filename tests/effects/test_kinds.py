"""Families are as wide as their kind: laws that no form of the library has lie in a space of their effect."""

from collections.abc import Callable

import numpy as np
import pytest

from labrig.effects import Context
from labrig.effects._obstacles import by_marker, to_rows
from labrig.effects._registry import shipped
from labrig.effects.coupling import nearest
from tests.effects.test_family import LONG_S, context_of, followed

Change = Callable[[Context], np.ndarray]


def best(make_lab, effect: str, change: Change, **extra) -> dict[str, float]:
    """How much of a hidden change, written by a law of the test's own, each space of an effect holds, by its key."""
    lab = make_lab(captures=40, markers=12, long_s=LONG_S)
    clean = context_of(lab, lab.predict(lab.u), **extra)
    hidden = change(clean)
    values = lab.predict(lab.u) + 0.1 * lab.noise()
    values[np.isfinite(lab.dataset(values, **extra)["hold_s"].values)] += hidden
    context = context_of(lab, values, **extra)
    return {s.key: followed(context, s, hidden) for s in shipped()[effect].family(context)}


def behind_a_plane(context: Context) -> np.ndarray:
    """Markers are pushed back to a plane that is tilted against all axes (projection on a half space)."""
    normal = np.array([0.5, 0.3, 0.8])
    normal /= np.linalg.norm(normal)
    assert context.rows.rest_mm is not None
    here = by_marker(context, context.displacement) + context.rows.rest_mm
    height = here @ normal
    past = np.maximum(height - np.quantile(height, 0.85), 0.0)
    return to_rows(context, -past[..., None] * normal)


def on_one_plate(context: Context) -> np.ndarray:
    """Four neighbouring markers are turned about their middle, once, by a knock."""
    rest = context.rows.rest_mm
    assert rest is not None
    near = np.argsort(np.linalg.norm(rest - rest[0], axis=1))[:4]
    arm = np.zeros_like(rest)
    about = rest[near] - rest[near].mean(axis=0)
    arm[near] = np.cross([0.02, -0.03, 0.05], about) + np.array([0.5, 0.0, 0.3])
    return to_rows(context, (context.rows.capture >= 22)[:, None, None] * arm)


def into_a_pocket(context: Context) -> np.ndarray:
    """Air seeps into a closed pocket until it is as full: dp/dt = (q - p) r / tau, dq/dt = (p - q) / tau, by steps."""
    rows, tau_s, volume = context.rows, 40.0, 0.3
    inside, lost = np.zeros(rows.actuation.shape[1]), np.zeros_like(rows.actuation)
    for e, command in enumerate(rows.event_actuation):
        own = np.flatnonzero(rows.event == e)
        end = rows.event_time_s[e + 1] if e + 1 < len(rows.event_time_s) else rows.event_time_s[e] + 60.0
        p, q, t = command.copy(), inside.copy(), 0.0
        for wanted, row in [*((context.elapsed_s[r], r) for r in own), (end - rows.event_time_s[e], -1)]:
            while t < wanted:
                dt = min(0.2, wanted - t)
                p, q, t = p + dt * (q - p) * volume / tau_s, q + dt * (p - q) / tau_s, t + dt
            if row >= 0:
                lost[row] = p - command
        inside = q
    return np.einsum("fkc,fc->fk", context.jacobian, lost)


def from_heavy_markers(context: Context) -> np.ndarray:
    """Each marker hangs down by its own weight, along the vertical in the frame of the tilted base."""
    tilt = np.deg2rad(context.rows.covariates["tilt"].values)
    down = np.stack([np.sin(tilt), np.zeros_like(tilt), -np.cos(tilt)], axis=1)
    sag_mm = np.random.default_rng(3).uniform(0.1, 0.9, len(context.rows.markers))
    return to_rows(context, down[:, None] * sag_mm[None, :, None])


def held_back_as_a_whole(context: Context) -> np.ndarray:
    """The body is held back along one way by a Bouc-Wen force, dz = dx (1 - |z|^2 (0.6 + 0.4 sign(dx z))), by steps."""
    _, _, ways = np.linalg.svd(context.displacement, full_matrices=False)
    along = context.displacement @ ways[0] / np.linalg.norm(context.displacement @ ways[0]) * np.sqrt(40 * 3)
    first = np.searchsorted(context.rows.event, np.arange(len(context.rows.event_actuation)))
    drive = along[first]
    z, last, force = 0.0, 0.0, np.empty(len(drive))
    for e, now in enumerate(drive):
        for dx in np.full(200, (now - last) / 200 / 0.3):
            z += dx * (1 - z**2 * (0.6 + 0.4 * np.sign(dx * z)))
        force[e], last = z, now
    return -2.0 * force[context.rows.event][:, None] * ways[0]


def loops_at_medium_loads(context: Context) -> np.ndarray:
    """A crowd of relays (Preisach) whose thresholds lie between a third and two thirds of the range."""
    random = np.random.default_rng(5)
    on, wide = random.uniform(0.45, 0.67, 300), random.uniform(0.03, 0.12, 300)
    state, u = np.zeros((300, len(context.rows.chambers))), context.rows.event_actuation / context.span
    out = np.empty_like(u)
    for e, x in enumerate(u):
        state = np.where(x > on[:, None], 1.0, np.where(x < (on - wide)[:, None], 0.0, state))
        out[e] = state.mean(axis=0)
    static = np.clip((u - 0.42) / 0.22, 0, 1)
    lost = (out - static)[context.rows.event] * context.span
    return np.einsum("fkc,fc->fk", context.jacobian, lost)


def through_a_narrow_hole(context: Context) -> np.ndarray:
    """Chambers fill through a hole, dp/dt = sign(u - p) sqrt(|u - p|) c, by steps."""
    rows, c = context.rows, 2.0
    p, late = np.zeros(rows.actuation.shape[1]), np.zeros_like(rows.actuation)
    for e, command in enumerate(rows.event_actuation):
        own = np.flatnonzero(rows.event == e)
        end = rows.event_time_s[e + 1] if e + 1 < len(rows.event_time_s) else rows.event_time_s[e] + 60.0
        t = 0.0
        for wanted, row in [*((context.elapsed_s[r], r) for r in own), (end - rows.event_time_s[e], -1)]:
            while t < wanted:
                dt = min(0.02, wanted - t)
                left = command - p
                p, t = p + np.sign(left) * np.minimum(np.sqrt(np.abs(left)) * c * dt, np.abs(left)), t + dt
            if row >= 0:
                late[row] = p - command
    return np.einsum("fkc,fc->fk", context.jacobian, late)


def by_two_at_once(context: Context) -> np.ndarray:
    """A place between chambers is lifted, in a way of its own, by the least of three pressures."""
    x = context.rows.fraction
    way = np.random.default_rng(7).normal(size=context.displacement.shape[1])
    return 2.0 * x[:, :3].min(axis=1)[:, None] * way


def back_to_the_other_branch(context: Context) -> np.ndarray:
    """After each turn the pressure nears the other of two parallel branches by a hyperbola of the way, by steps."""
    u = context.rows.event_actuation / context.span
    z, last = np.zeros(u.shape[1]), np.zeros(u.shape[1])
    behind = np.empty_like(u)
    for e, now in enumerate(u):
        for step in np.repeat([(now - last) / 400], 400, axis=0):
            z = z + np.abs(step) / 0.08 * (np.sign(step) - z) ** 2 * np.sign(np.sign(step) - z)
        behind[e], last = z, now
    return np.einsum("fkc,fc->fk", context.jacobian, -0.06 * (behind * context.span)[context.rows.event])


def let_go_at_once(context: Context) -> np.ndarray:
    """What held back until now lets go, by a tenth of the range, where a chamber that went up comes down by a sixth."""
    u = context.rows.event_actuation / context.span
    top, held = np.zeros(u.shape[1]), np.ones(u.shape[1])
    out = np.empty_like(u)
    for e, now in enumerate(u):
        top = np.maximum(top, now)
        held = np.where(now < top - 1 / 6, 0.0, held)
        over = now >= top
        held, top = np.where(over, 1.0, held), np.where(held == 0, now, top)
        out[e] = held
    return np.einsum("fkc,fc->fk", context.jacobian, -0.1 * (out * context.span)[context.rows.event])


def around_a_bar(context: Context) -> np.ndarray:
    """Markers that would be inside a round bar lie on it, on the side that is nearer (projection on a cylinder)."""
    assert context.rows.rest_mm is not None
    here = by_marker(context, context.displacement) + context.rows.rest_mm
    far = np.unravel_index(np.argmax(np.linalg.norm(here - context.rows.rest_mm, axis=2)), here.shape[:2])
    way = here[far] - context.rows.rest_mm[far[1]]
    along = np.cross(way, [0.3, 0.5, -0.2])
    along /= np.linalg.norm(along)
    middle, radius = here[far] - 0.2 * way, 0.35 * np.linalg.norm(way)
    across = (here - middle) - ((here - middle) @ along)[..., None] * along
    length = np.linalg.norm(across, axis=2)
    return to_rows(context, (np.maximum(radius - length, 0.0) / np.maximum(length, 1e-9))[..., None] * across)


def twisted_by_each_two(context: Context) -> np.ndarray:
    """The body turns about an axis through its middle by an angle of all pairs' products, some one way, some back."""
    assert context.rows.rest_mm is not None
    x, about = context.rows.fraction, context.rows.rest_mm - context.rows.rest_mm.mean(axis=0)
    signs = np.triu(np.random.default_rng(8).choice([-1.0, 1.0], (x.shape[1], x.shape[1])), 1)
    angle = 0.03 * np.einsum("fi,ij,fj->f", x, signs, x)
    axis = np.array([0.6, 0.0, 0.8])
    along, aside = np.outer(about @ axis, axis), np.cross(axis, about)
    turned = along + np.cos(angle)[:, None, None] * (about - along) + np.sin(angle)[:, None, None] * aside
    return to_rows(context, turned - about)


def shifted_by_what_others_draw(context: Context) -> np.ndarray:
    """Each open chamber's reading is shifted by the others' currents in a common wire, however full it is itself."""
    x = context.rows.fraction
    ohms = np.random.default_rng(9).uniform(0.02, 0.08, (x.shape[1], x.shape[1]))
    np.fill_diagonal(ohms, 0.0)
    shift = np.where(x > 0.02, x @ ohms.T, 0.0) * context.span
    return np.einsum("fkc,fc->fk", context.jacobian, shift)


def drained_by_the_emptier(context: Context) -> np.ndarray:
    """Open chambers exchange air through one rail: each loses as the root of how much it is above each other one."""
    x = context.rows.fraction
    above = np.maximum(x[:, :, None] - x[:, None], 0.0) * (x > 0.03)[:, None]
    lost = -0.08 * (np.sqrt(above + 0.04) - 0.2).sum(axis=2) * context.span
    return np.einsum("fkc,fc->fk", context.jacobian, lost)


def amplified_by_its_weight(context: Context) -> np.ndarray:
    """A column's own thrust along its axis, by the tilt, makes each deflection larger by 1 / (1 - P / P_critical)."""
    thrust = 0.35 * np.cos(np.deg2rad(context.rows.covariates["tilt"].values))
    return context.displacement * (1 / (1 - thrust) - 1)[:, None]


def lifted_by_a_growing_arm(context: Context) -> np.ndarray:
    """Each wall lifts a weight by an arm that is longer the fuller it is, once it is off its seat."""
    x, tilt = context.rows.fraction, np.deg2rad(context.rows.covariates["tilt"].values)
    looks = np.random.default_rng(10).uniform(0, 2 * np.pi, x.shape[1])
    arm = np.where(x > 0.03, (1 + 0.4 * x) ** 2.5, 0.0) * np.cos(tilt[:, None] + looks)
    return np.einsum("fkc,fc->fk", context.jacobian, -0.05 * arm * context.span)


def peels_off(context: Context) -> np.ndarray:
    """A marker's tape lets go along a logistic curve, and the looser it is the less of the motion below it it shows."""
    late = np.ptp(context.rows.capture) * 0.4
    loose = 1 / (1 + np.exp(-(context.rows.capture - late) / 5.0))
    arm = np.zeros((len(loose), len(context.rows.markers), 3))
    below = by_marker(context, context.displacement)[:, 4]
    arm[:, 4] = loose[:, None] * (np.array([0.8, -0.3, 0.4]) - 0.3 * (loose[:, None] > 0.5) * below)
    return to_rows(context, arm)


def knocked_by_a_hand(context: Context) -> np.ndarray:
    """Three markers that are no neighbours are shifted at one moment, each its own way."""
    arm = np.zeros((len(context.rows.markers), 3))
    arm[[1, 6, 10]] = [[0.6, 0.1, 0.0], [-0.2, 0.5, 0.3], [0.0, -0.6, 0.4]]
    return to_rows(context, (context.rows.capture >= 17)[:, None, None] * arm)


def dragged_by_threads(context: Context) -> np.ndarray:
    """Each marker's ground follows it by a thread in space, in steps of a thousandth of the way."""
    first = np.searchsorted(context.rows.event, np.arange(len(context.rows.event_actuation)))
    way = by_marker(context, context.displacement)[first]
    ground, last, out = np.zeros_like(way[0]), np.zeros_like(way[0]), np.empty_like(way)
    for e, now in enumerate(way):
        for step in np.linspace(last, now, 1000):
            behind = step - ground
            length = np.linalg.norm(behind, axis=1, keepdims=True)
            ground = step - behind * np.minimum(1.0, 0.4 / np.maximum(length, 1e-12))
        out[e], last = ground - now, now
    return to_rows(context, out[context.rows.event])


def in_a_sheath_that_rubs(context: Context) -> np.ndarray:
    """What all chambers bend together rubs in one sheath (P. R. Dahl, AIAA J. 14 (1976) 1675, as vectors), by steps."""
    rows, rub = context.rows, 0.03
    reached = (rows.event_actuation - context.vented) / context.span
    force, last, out = np.zeros(reached.shape[1]), np.zeros(reached.shape[1]), np.empty_like(reached)
    for e, now in enumerate(reached):
        step = (now - last) / 2000
        for _ in range(2000):
            force = force + 60.0 * (step - force * np.linalg.norm(step) / (rub * (1 + now.mean())))
        out[e], last = -force / 60.0, now
    return np.einsum("fkc,fc->fk", context.jacobian, out[rows.event] * context.span)


def through_a_hole_in_the_wall(context: Context) -> np.ndarray:
    """Air goes through an orifice from the fuller of two neighbours to the emptier, by the root of the difference."""
    x = context.rows.fraction
    flow = np.sign(np.diff(x, axis=1)) * np.sqrt(np.abs(np.diff(x, axis=1))) * [0.06, 0.03]
    given = np.pad(flow, ((0, 0), (0, 1))) - np.pad(flow, ((0, 0), (1, 0)))
    return np.einsum("fkc,fc->fk", context.jacobian, given * context.span)


def lifted_by_the_next(context: Context) -> np.ndarray:
    """A chamber's top is lifted by that of the next one, by a tangent that levels off, vented as it may be itself."""
    lifted = 0.1 * np.tanh(1.3 * np.roll(context.rows.fraction, 1, axis=1))
    return np.einsum("fkc,fc->fk", context.jacobian, lifted * context.span)


def elsewhere(context: Context) -> np.ndarray:
    """What cameras that stand elsewhere see, turned exactly (Rodrigues) about a foot beside the rig, (F, M, 3)."""
    assert context.rows.rest_mm is not None
    axis, turn = np.array([0.0, 0.6, 0.8]), 0.01
    arm = by_marker(context, context.displacement) + context.rows.rest_mm - [300.0, -100.0, 40.0]
    along = (arm @ axis)[..., None] * axis
    turned = along + np.cos(turn) * (arm - along) + np.sin(turn) * np.cross(axis, arm)
    return turned - arm + [0.4, 0.0, -0.7]


def cameras_pushed(context: Context) -> np.ndarray:
    """From one capture on the cameras stand elsewhere."""
    return to_rows(context, (context.rows.capture >= 22)[:, None, None] * elsewhere(context))


def cameras_pushed_and_back(context: Context) -> np.ndarray:
    """Somebody leans against the cameras for some captures, and they spring back."""
    capture = context.rows.capture
    return to_rows(context, ((capture >= 13) & (capture < 27))[:, None, None] * elsewhere(context))


def shrunk_in_its_mould(context: Context) -> np.ndarray:
    """Cured rubber is smaller than its mould: lengths are less by an exponential, most along a slant way."""
    rest = context.rows.rest_mm
    assert rest is not None
    slant = np.linalg.qr(np.array([[1.0, 0.4, 0.2], [0.0, 1.0, 0.3], [0.2, 0.0, 1.0]]))[0]
    smaller = slant @ np.diag(np.expm1([-0.03, -0.012, -0.02])) @ slant.T
    return to_rows(context, np.tile((rest - rest.mean(axis=0)) @ smaller, (len(context.base), 1, 1)))


TILT = {"covariates": {"tilt": ("deg", np.linspace(0, 60, 40))}}


@pytest.mark.parametrize(
    ("effect", "change", "kind", "least", "extra"),
    [
        ("coupling", by_two_at_once, "some at once", 0.9, {}),
        ("coupling", twisted_by_each_two, "all pairs, one way", 0.95, {}),
        ("coupling", shifted_by_what_others_draw, "once open", 0.95, {}),
        ("coupling", drained_by_the_emptier, "the fuller", 0.95, {}),
        ("coupling", through_a_hole_in_the_wall, "evened out", 0.97, {}),
        ("coupling", lifted_by_the_next, "reached", 0.97, {}),
        ("frame", cameras_pushed, "moved before capture 22", 0.99, {}),
        ("frame", cameras_pushed_and_back, "moved from capture 13 to 26", 0.99, {}),
        ("rest_shape", shrunk_in_its_mould, "strained about its middle", 0.97, {}),
        ("gravity", amplified_by_its_weight, "the whole way", 0.98, TILT),
        ("gravity", lifted_by_a_growing_arm, "what each wall lifts", 0.98, TILT),
        ("marker_slip", peels_off, "marker 4 loose", 0.95, {}),
        ("marker_slip", knocked_by_a_hand, "markers", 0.95, {}),
        ("friction", dragged_by_threads, "under the markers", 0.95, {}),
        ("friction", in_a_sheath_that_rubs, "dragged along", 0.95, {}),
        ("contact", behind_a_plane, "plane", 0.9, {}),
        ("contact", around_a_bar, "pushes", 0.8, {}),
        ("marker_slip", on_one_plate, "markers", 0.95, {}),
        ("leak", into_a_pocket, "lost", 0.97, {}),
        ("gravity", from_heavy_markers, "anywhere", 0.99, TILT),
        ("hysteresis", held_back_as_a_whole, "in the skin", 0.9, {}),
        ("hysteresis", loops_at_medium_loads, "play", 0.9, {}),
        ("friction", back_to_the_other_branch, "sliding", 0.997, {}),
        ("friction", let_go_at_once, "sliding", 0.995, {}),
        ("delay", through_a_narrow_hole, "late", 0.99, {}),
    ],
)
def test_a_law_of_the_kind_lies_in_a_space(make_lab, effect, change, kind, least, extra) -> None:
    """What a law written here changes lies in the space that is meant for its kind, whatever the law."""
    held = best(make_lab, effect, change, **extra)
    assert max((share for key, share in held.items() if key.startswith(kind)), default=0.0) > least, held


def test_no_chamber_is_its_own_neighbour() -> None:
    """Where chambers reach nothing in common, each of the others stands once in the order of a chamber, it never."""
    x = np.arange(5.0)[None]
    order = np.concatenate(nearest(np.zeros((5, 5)), x))
    assert [sorted(order[:, c]) for c in range(5)] == [[k for k in range(5) if k != c] for c in range(5)]


def test_chambers_that_are_no_neighbours_are_a_pair_too(make_lab) -> None:
    """Two chambers, once past half of their range, hold two far ones back by an arctangent: each pair for itself."""
    lab = make_lab(captures=60, markers=12, chambers=7)
    context = context_of(lab, lab.predict(lab.u))
    x = context.rows.fraction
    lost = np.zeros_like(x)
    lost[:, :2] = -0.3 * x[:, :2] * (np.arctan(12 * (x[:, :-3:-1] - 0.5)) / np.pi + 0.5)
    hidden = np.einsum("fkc,fc->fk", context.jacobian, lost * context.span)
    held = {s.key: followed(context, s, hidden) for s in shipped()["coupling"].family(context)}
    assert held["pair by pair"] > 0.98
