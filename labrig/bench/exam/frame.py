"""Frame: the measuring frame is not where, or not as square as, it is believed to be."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import Body, turn, unit


class AffineSkew(Law):
    """Axes that are not at right angles, all the time: each coordinate takes some of the next.

    R. Hartley and A. Zisserman, Multiple View Geometry in Computer Vision, Cambridge University Press, 2003.
    """

    effect: ClassVar[str] = "frame"
    needs: ClassVar[frozenset[str]] = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._body = Body(setting.rig)
        skew = np.triu(setting.random.standard_normal((3, 3)), 1)
        self._skew = skew[np.ix_(*[setting.random.permutation(3)] * 2)] * setting.random.uniform(0.01, 0.03)
        if not self._body.rest[:, 2].any():
            self._skew[0, 1] += setting.random.choice([-0.02, 0.02])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The markers in the skewed frame."""
        arm = self._body.points(values) - self._body.centre
        return self._body.shifted(values, strength * arm @ self._skew.T)


class FarRotation(Law):
    """The frame turns a little about a point far from the body, at a moment or from the start of a session on.

    I. Soederkvist and P.-A. Wedin, Journal of Biomechanics, 1993 (motion of a body from markers).
    """

    effect: ClassVar[str] = "frame"
    needs: ClassVar[frozenset[str]] = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._body = body = Body(setting.rig)
        self._far = body.centre + random.uniform(4, 15) * body.size * unit(random)
        axis = unit(random)
        if not body.rest[:, 2].any():
            axis, self._far[2] = np.array([0.0, 0.0, 1.0]), 0.0
        self._angle = axis * random.uniform(0.002, 0.006)
        sessions = np.unique(path.session)
        start = (
            path.session == random.choice(sessions[1:])
            if len(sessions) > 1
            else path.time_s > path.time_s.mean()
        )
        self._from_s = float(path.time_s[np.argmax(start)])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The markers in the turned frame, from its moment on."""
        arm = self._body.points(values) - self._far
        moved = arm @ (turn(strength * self._angle) - np.eye(3)).T
        return self._body.shifted(values, moved * (path.time_s >= self._from_s)[:, None, None])


class Reregistered(Law):
    """A frame that is fitted anew to the body at each session, each time a little off, in place and in angle.

    B. K. P. Horn, Journal of the Optical Society of America A, 1987 (absolute orientation).
    """

    effect: ClassVar[str] = "frame"
    needs: ClassVar[frozenset[str]] = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._body = body = Body(setting.rig)
        self._first = int(setting.path.session.min())
        count = int(setting.path.session.max()) - self._first + 1
        self._angle = setting.random.normal(0, setting.random.uniform(0.005, 0.015), (count, 3))
        self._shift = setting.random.normal(0, setting.random.uniform(0.005, 0.015), (count, 3)) * body.size

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The markers in the frame of their session."""
        arm = self._body.points(values) - self._body.centre
        moved = np.zeros_like(arm)
        for number in np.unique(path.session):
            own, which = path.session == number, (number - self._first) % len(self._angle)
            moved[own] = arm[own] @ (turn(strength * self._angle[which]) - np.eye(3)).T
            moved[own] += strength * self._shift[which]
        return self._body.shifted(values, moved)
