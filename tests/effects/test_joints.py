"""What acts in a joint that one of few sensors follows: a stop at the end of its way, friction where it turns."""

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.diagnosis import rows_from
from labrig.effects import Fitted, Part, get
from labrig.model import Model
from tests.effects.test_family import followed
from tests.naming import calls_of, verdict_of

P_BAR = 3.0


def elbow(u: np.ndarray) -> np.ndarray:
    """Two muscles pull an elbow, deg, against each other; the first one's tendon, N, slackens as it turns."""
    turn = 24.0 * (u[:, 0] - u[:, 1]) / (1 + 0.08 * (u[:, 0] + u[:, 1]))
    return np.stack([turn, tendon(u, turn)], axis=1)


def tendon(u: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """What the first muscle pulls at an angle."""
    return u[:, 0] * (14.0 - 0.12 * turn) + 1.5


def buffer(turn: np.ndarray) -> np.ndarray:
    """A rubber buffer from 31 deg on, whose force goes with the power 3/2 of how far it is pressed (H. Hertz, 1882)."""
    pressed = np.zeros_like(turn)
    for _ in range(60):  # as much as the spring of the muscles pushes: 0.35 pressed^1.5 = free way - pressed
        free = np.maximum(turn - 31.0, 0.0)
        pressed -= (0.35 * pressed**1.5 + pressed - free) / (0.525 * np.sqrt(pressed) + 1)
        pressed = np.maximum(pressed, 0.0)
    return np.minimum(turn, 31.0) + pressed


def bearing(turn: np.ndarray) -> np.ndarray:
    """A worn bearing: dz = (1 - z sign(dx)) dx / 1.6 deg along the way (P. R. Dahl, 1968), which holds back 0.7 deg."""
    z, last, out = 0.0, 0.0, []
    for now in turn:
        for step in np.diff(np.linspace(last, now, 80)):
            z += (1 - z * np.sign(step)) * step / 1.6
        last = now
        out.append(now - 0.7 * z)
    return np.array(out)


def campaign(law, seed: int, name: str = "run"):
    """70 set-points anywhere and a stretch of them again, two rows each, as a run."""
    random = np.random.default_rng(seed)
    u = random.uniform(0, P_BAR, (60, 2))
    u = np.concatenate([u, u[20:30]])
    turn = law(elbow(u)[:, 0])
    rows = np.repeat(np.arange(len(u)), 2)
    columns = {
        "t (s)": 8.0 * rows + np.tile([3, 6], len(u)),
        "p1 (bar)": u[rows, 0],
        "p2 (bar)": u[rows, 1],
        "angle (deg)": turn[rows] + random.normal(0, 0.08, len(rows)),
        "tendon (N)": tendon(u, turn)[rows] + random.normal(0, 0.08, len(rows)),
    }
    return labrig.import_table(pd.DataFrame(columns), name)


@pytest.fixture(autouse=True)
def _there(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_a_joint_that_meets_a_buffer_is_in_contact() -> None:
    """An angle is stopped though no pressure and no sum of them says where: contact is what is possible, alone."""
    calls = calls_of(campaign(buffer, 1), Model.of(elbow))
    assert {effect for effect, call in calls.items() if call != "not it"} == {"contact"}


def test_a_bearing_that_rubs_is_friction() -> None:
    """It holds an angle back where that turns, whichever of two chambers turned: friction, not a loop of the walls."""
    assert verdict_of(campaign(bearing, 2), Model.of(elbow)).effects == ("friction",)


def test_a_bearing_takes_few_functions_of_friction() -> None:
    """Three ways after a turn, which the sensors share: what rubs there needs no memory of each chamber."""
    context = Model.of(elbow).context(rows_from(campaign(bearing, 2)))
    u = context.rows.actuation
    turn = bearing(elbow(u)[:, 0])
    change = np.stack([turn, tendon(u, turn)], axis=1) - elbow(u)
    (space,) = (s for s in get("friction").family(context) if s.key == "of angle")
    assert len(space.features) == 3
    assert followed(context, space, change) > 0.95


@pytest.mark.parametrize(
    ("law", "effect", "parameter", "value"),
    [(buffer, "contact", "distance", 32.5), (bearing, "friction", "presliding", 1.6)],
)
def test_their_formulas_hold_on_another_run(law, effect: str, parameter: str, value: float) -> None:
    """Where a joint is stopped, and its way after a turn until it slides, are in its own unit: they take as much off a
    run of other set-points.
    """
    better = labrig.improve(campaign(law, 3), elbow, effect, force=True).model
    entry = better.file.effects[0]
    assert entry.form.startswith(("stop of angle, +", "of angle"))
    assert entry.parameters[parameter].value == pytest.approx(value, rel=0.05)
    assert entry.parameters[parameter].unit == "deg"
    error = labrig.compare(campaign(law, 4, "again"), [elbow, better]).error
    assert error["second"] - error["floor"] < 0.1 * (error["first"] - error["floor"])


def test_where_a_joint_is_stopped_is_said_in_its_unit() -> None:
    """In words: which sensor, and how far from where it is vented."""
    found = Fitted("contact", "stop of angle, -, felt", {"distance": {"value": 31.2}}, units={"angle": "deg"})
    assert get("contact").in_words(found) == "angle is stopped -31.2\u00a0deg from where it is vented."


def sign_of(law, effect: str, form: str):
    """What the report draws of such a part, for a law that is followed exactly."""
    context = Model.of(elbow).context(rows_from(campaign(law, 7, effect)))
    own = np.array([1.0, 0.0])
    change = (law(context.base[:, 0]) - context.base[:, 0])[:, None] * own
    return get(effect).sign(context, Part(form, change, 0.0 * change, np.array([0.08, 0.08])))


def test_what_a_joint_does_is_drawn_against_where_it_is() -> None:
    """No pressure orders it: against the angle friction is two levels, by where it came from, and a stop is a kink."""
    rubs, stops = sign_of(bearing, "friction", "of angle"), sign_of(buffer, "contact", "stop of angle, +")
    assert (rubs.x_name, rubs.x_unit) == ("angle, by the model", "deg") == (stops.x_name, stops.x_unit)
    levels = [np.median(rubs.fitted[rubs.group == came]) for came in ("from above", "from below")]
    assert abs(levels[1] - levels[0]) > 1.0
    assert np.abs(stops.fitted[stops.x < 30.0]).max() < 1e-6 < np.abs(stops.fitted[stops.x > 33.0]).min()


def test_the_elbow_alone_misses_nothing() -> None:
    """The same rig with nothing hidden."""
    assert verdict_of(campaign(lambda turn: turn, 6), Model.of(elbow)).verdict == "nothing_missing"
