"""Gravity: the body sags under its own weight and under what hangs on it."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import Body


def _down(path: Path) -> Floats:
    """The direction of gravity in the frame of a base turned about x, (T, 3)."""
    tilt = np.radians(path.tilt_deg)
    return np.column_stack([np.zeros_like(tilt), -np.sin(tilt), -np.cos(tilt)])


def _turned(arm: Floats, moment: Floats, share: Floats) -> Floats:
    """How far points (T, M, 3), from the clamp, go by turns (T, 3) in radians of which each takes a share (M,)."""
    angle = moment[:, None, :] * share[:, None]
    first = np.cross(angle, arm)
    return first + np.cross(angle, first) / 2


class LargeSag(Law):
    """Own weight on a cantilever that sags far: its moment turns with tilt and shape, and a full body is softer.

    K. E. Bisshopp and D. C. Drucker, Quarterly of Applied Mathematics, 1945.
    """

    effect: ClassVar[str] = "gravity"
    needs: ClassVar[frozenset[str]] = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._body = body = Body(setting.rig)
        self._sag_rad = setting.random.uniform(0.08, 0.2)
        self._soft = setting.random.uniform(0.3, 0.9)
        self._share = body.lever ** setting.random.uniform(1.0, 1.8)
        self._reach = float(np.linalg.norm(body.rest - body.clamp, axis=1).max()) or 1.0

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The markers, each turned about the clamp by its share of the sag, and lowered by it."""
        body, down = self._body, _down(path)
        arm = body.points(values) - body.clamp
        moment = np.cross((self._share[:, None] * arm).mean(axis=1), down) / self._reach
        still = (
            np.cross((self._share[:, None] * (body.rest - body.clamp)).mean(axis=0), [0.0, 0.0, -1.0])
            / self._reach
        )
        soft = 1 + self._soft * deflection.mean(axis=1, keepdims=True)
        bend = strength * self._sag_rad * (soft * moment - still)
        bend = bend / np.sqrt(1 + (bend**2).sum(axis=1, keepdims=True))
        lower = strength * self._sag_rad * 0.15 * self._reach * (soft * down - [0.0, 0.0, -1.0])
        return body.shifted(
            values, _turned(arm, bend, self._share) + self._share[:, None] * lower[:, None, :]
        )


class TipLoad(Law):
    """A payload at the end of a cantilever: a bend by its moment, a cubic line along the body, and a stretch.

    D. C. Rucker and R. J. Webster, IEEE Transactions on Robotics, 2011 (continuum robots under external loads).
    """

    effect: ClassVar[str] = "gravity"
    needs: ClassVar[frozenset[str]] = frozenset({"markers", "payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._body = body = Body(setting.rig)
        self._most_kg = float(setting.path.payload_kg.max()) or 1.0
        self._bend_rad = setting.random.uniform(0.05, 0.15)
        self._stretch = setting.random.uniform(0.005, 0.03)
        self._share = (3 * body.lever**2 - body.lever**3) / 2
        self._tip = int(np.argmax(body.lever))
        self._reach = float(np.linalg.norm(body.rest - body.clamp, axis=1).max()) or 1.0

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The markers, moved by the payload's moment about the clamp and by its pull."""
        body, down = self._body, _down(path)
        weight = strength * (path.payload_kg / self._most_kg)[:, None]
        arm = body.points(values) - body.clamp
        bend = self._bend_rad * weight * np.cross(arm[:, self._tip], down) / self._reach
        bend = bend / np.sqrt(1 + (bend**2).sum(axis=1, keepdims=True))
        pull = self._stretch * self._reach * weight * down
        return body.shifted(values, _turned(arm, bend, self._share) + self._share[:, None] * pull[:, None, :])
