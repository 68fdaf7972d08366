"""Frame: the measuring frame is not where the model thinks it is."""

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Feature, Space, acting, field, motion_scale
from labrig.effects._fields import (
    STRAINS,
    aslant_modes,
    frame_modes,
    in_a_plane,
    orientation_modes,
    scale_mode,
)
from labrig.effects._in_parts import affine, another_in_each, orientations
from labrig.effects._kicked import kick, since_a_kick
from labrig.effects._sessions import IN_EACH, in_sessions, labels
from labrig.effects._sign import Part, Sign, by_capture
from labrig.effects._slips import moment
from labrig.effects._turn import carried, turn_of, turned

SMALL_RAD = 0.05
"""Up to here a rotation is taken as small: what that leaves is half its square, a thousandth of the body's size."""


class Frame(Effect):
    name = "frame"
    meaning = (
        "The measuring frame is shifted and turned against the model's (a moved camera, a bad\n"
        "registration, a bad wand): one rigid motion, and scale, of all markers, always or since it moved."
    )
    acts_on = "observation"
    parameters = (
        Parameter("shift", "place", meaning="translation along x, y, z"),
        Parameter(
            "turn",
            "rad",
            -0.5,
            0.5,
            meaning="rotation about x, y, z through the centre of the markers at rest; and by which quaternions are "
            "seen turned, always or from one moment on",
        ),
        *(
            Parameter(
                f"about_{a}", "rad", -np.pi, np.pi, meaning=f"{a} of the turn's rotation vector", given=True
            )
            for a in "xyz"
        ),
        Parameter(
            "shift_in_session",
            "place, rad",
            per="session",
            meaning="translation along x, y, z and rotation about them, another in each session",
        ),
        Parameter(
            "shift_since",
            "place, rad",
            meaning="translation along x, y, z and rotation about them, from one moment on",
        ),
        Parameter("since_s", "s", meaning="when it was moved, since the run began", given=True),
        Parameter("until_s", "s", meaning="when it was back, since the run began", given=True),
        Parameter("turned", "1", 0.9, 1.1, meaning="how much of that turn there is"),
        Parameter("scale", "1", -0.1, 0.1, meaning="surplus of the frame's scale (a bad calibration wand)"),
        Parameter(
            "aslant",
            "1, 1/place",
            meaning="of a camera that looks aslant: one axis against the other, a shear, and how much larger what lies "
            "along either axis is seen",
        ),
    )
    reference = "K. S. Arun, T. S. Huang, S. D. Blostein, IEEE Trans. PAMI 9 (1987) 698-700"
    signature = "the same rigid motion of all markers in every capture, at every pressure and time"
    experiment = "the vented surface, registered again by three fixed markers"
    needs = "three coordinates of markers"
    ruled_out_by = "register the measuring frame by three fixed markers right before"
    by_hand = "register the measuring frame again by three fixed markers, then run one capture at rest"

    def variants(self, context: Context) -> Iterator[Variant]:
        turn = _large_turn(context)
        rigid = Term("shift", "frame", np.ones(len(context.base)))
        if (context.rows.axis >= 0).sum() >= 3:
            if turn is None or context.saved:  # a large turn is no small rotation, however well that fits
                yield from _small(context, rigid)
            if (each := in_sessions(context)) is not None:
                modes = frame_modes(context)[..., None, :] * each[:, None, :, None]
                change = modes.reshape(*context.base.shape, -1)
                names = labels(context, ("x", "y", "z", "about x", "about y", "about z"))
                yield Variant(
                    f"rigid{IN_EACH}", (Term.field("shift_in_session", change, names),), centred=True
                )
            yield from _since(context)
        if turn is not None:
            shape = {
                f"about_{a}": context.grid(f"about_{a}", (t,))[0] for a, t in zip("xyz", turn, strict=True)
            }
            solved = Term.field("turned", turned(context, np.array(list(shape.values()))))
            yield Variant("turned", (rigid, solved), shape)

    def carried(self, context: Context, form: str, values: Mapping[str, float]) -> Context:
        """A frame that is turned by more than a little turns all motions."""
        if form != "turned":
            return context
        return carried(context, np.array([values[f"about_{a}"] for a in "xyz"]))

    def family(self, context: Context) -> Iterator[Space]:
        """A rigid motion and a scale of the measuring frame; constant, or different in each session.

        What a lens makes is no motion of the frame, and has no name; but what one camera sees of a plane is skewed and
        nearer on one side where it was turned.
        """
        rows = context.rows
        if (rows.axis >= 0).sum() < 3:
            return
        scale, whole = motion_scale(context), [f for f in affine(context) if f.name not in STRAINS]
        whole += orientations(context)
        yield Space("always", "frame", acting(whole))
        # the plainest motions, beside what is as narrow: a sag of a body that gives way alike, an offset of one marker
        yield Space("shifted", "frame shifted", acting(whole[:3]))
        yield Space("of another scale", "frame scaled", acting([f for f in whole if f.name == "scale"]))
        if axes := in_a_plane(rows):
            yield Space("seen aslant", "frame aslant", acting([*affine(context), *_nearer(context, axes)]))
        if (turn := _large_turn(context)) is not None:
            motion = turned(context, turn)
            for a in range(3):
                own = rows.axis == a
                motion[:, own] += np.nanmean((context.residual - motion)[:, own])
            solved = field("turn", motion / np.sqrt((motion**2).mean(axis=0).mean()) * scale)
            yield Space("turned", "frame turned", acting([solved, *whole]), absolute=False)
        if 1 < len(rows.sessions) < len(np.unique(rows.capture)):
            yield another_in_each(context, rows.session)
        if (moved := since_a_kick(context)) is not None:
            yield moved

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        missing = "since_s" in parameters and not np.isfinite(context.rows.time_s).all()
        return "the moments of its rows" if missing else ""

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("capture", "1", context.rows.capture.astype(float))

    def sign(self, context: Context, part: Part) -> Sign:
        """Each coordinate's mean over the captures against what one motion of the frame does to it."""
        rows, one = context.rows, by_capture(context, part)
        known = np.isfinite(one.left).any(axis=0) & (rows.axis >= 0)
        motion, left = one.change[:, known].mean(axis=0), np.nanmean(one.left[:, known], axis=0)
        axis = np.array([f"along {'xyz'[a]}" for a in rows.axis[known]])
        unit = rows.unit[int(np.flatnonzero(known)[0])]
        return Sign(
            "what the frame does to a coordinate",
            unit,
            "mean error of the coordinate",
            unit,
            motion,
            motion + left,
            motion,
            1 / part.noise[known] ** 2,
            axis,
        )


def _nearer(context: Context, axes: tuple[int, ...]) -> Iterator[Feature]:
    """Perspective (F, K) along each axis of the plane that is seen, of the size of the rig's motion."""
    _, near = aslant_modes(context)
    size = context.yardstick("perspective", lambda: np.sqrt((near**2).mean(axis=(0, 1))))
    near = near / np.where(size > 0, size, 1.0) * motion_scale(context)[None, :, None]
    for j, axis in enumerate(axes):
        yield field(f"nearer along {'xyz'[axis]}", near[:, :, j], 0.3)


def _small(context: Context, rigid: Term) -> Iterator[Variant]:
    """A small rigid motion, always; a scale; both; and what one camera sees of a plane."""
    yield from _moved(context, "rigid", rigid)
    scale = Term.field("scale", scale_mode(context))
    yield Variant("of another scale", (scale,), centred=True)
    yield Variant("rigid, and of another scale", (rigid, scale))
    if axes := in_a_plane(context.rows):
        a, b = ("xyz"[axis] for axis in axes)
        skew, near = aslant_modes(context)
        names = (f"{a} against {b}", "shear", f"along {a}", f"along {b}")
        aslant = Term.field("aslant", np.concatenate([skew, near], axis=2), names)
        yield Variant("seen aslant", (rigid, scale, aslant))


def _moved(
    context: Context, form: str, motion: Term, when: dict[str, float] | None = None
) -> Iterator[Variant]:
    """A rigid motion of the markers, and where there are quaternions, by how much these are seen turned; a saved one as
    it is saved.
    """
    modes = orientation_modes(context)
    if context.saved or not modes.any():
        yield Variant(form, (motion,), when or {})
    if modes.any():
        seen = Term.field("turn", modes * motion.feature[:, None, None], tuple("xyz"))
        yield Variant(f"{form}, quaternions too", (motion, seen), when or {})


def _since(context: Context) -> Iterator[Variant]:
    """One rigid motion from a moment on, or between two, where the residuals say; a saved one as it is saved."""
    rows = context.rows
    if not np.isfinite(rows.time_s).all():
        return
    if "since_s" in context.pinned:
        when = {name: context.pinned[name] for name in ("since_s", "until_s") if name in context.pinned}
    elif context.saved or (found := kick(context)) is None:
        return
    else:
        when = {"since_s": moment(rows, found.first)}
        if found.end is not None:
            when["until_s"] = moment(rows, found.end)
    t = context.run_time_s
    then = ((t >= when["since_s"]) & (t < when.get("until_s", np.inf))).astype(float)
    form = "rigid, between two moments" if "until_s" in when else "rigid, since a moment"
    yield from _moved(context, form, Term("shift_since", "frame", then), when)


def _large_turn(context: Context) -> Floats | None:
    """The turn that fits best, rad (3,), where it is too large for a small rotation; a saved one as it is saved."""
    if "about_x" in context.pinned:
        return np.array([context.pinned[f"about_{a}"] for a in "xyz"])
    turn = turn_of(context)
    return turn if turn is not None and np.linalg.norm(turn) > SMALL_RAD else None
