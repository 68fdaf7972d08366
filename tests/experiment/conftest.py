"""Rigs that hide something, by formulas of the tests' own, and campaigns that leave a doubt about it."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from labrig.experiment import Experiment
from tests.conftest import Lab

ROWS_S = (1.2, 2.0, 3.0, 4.0)
Values = Callable[[Any], np.ndarray]


def leaking(lab: Any) -> np.ndarray:
    """An orifice: the root of the pressure falls in a straight line."""
    return lab.predict(np.maximum(np.sqrt(lab.u) - 0.0035 * lab.hold_s[:, :, None], 0.0) ** 2)


def looped(lab: Any) -> np.ndarray:
    """A Bouc-Wen loop on every pressure."""
    return lab.predict(lab.looped(4.0, width=0.2))


def one_level(make_lab: Any, **settings: Any) -> Any:
    """One set of pressures, on and off: two states in all."""
    lab = make_lab(chambers=2, markers=4, captures=40, rows_s=ROWS_S, repeats=False, **settings)
    lab.commanded[:] = np.where(np.arange(40)[:, None] % 2 == 0, [42.0, 36.0], 0.0)
    lab.label[:] = ["on" if i % 2 == 0 else "off" for i in range(40)]
    return lab


def measured(lab: Any, experiment: Experiment, values: Values, seed: int = 5) -> Any:
    """What the same rig shows under the proposed programme, as another run."""
    points = experiment.points
    holds = [tuple(h for h in np.geomspace(1.2, p.hold_s, 4 if p.hold_s < 8 else 8)) for p in points]
    other = replace(lab, captures=len(points), rows_s=ROWS_S, long_s=(), seed=seed, repeats=False)
    other.commanded = np.array([experiment.limits.actuation(p.share) for p in points])
    other.label = list(experiment.repeats)
    other.session = np.zeros(len(points), dtype=int)
    other.hold_s = np.full((len(points), max(map(len, holds))), np.nan)
    for i, rows in enumerate(holds):
        other.hold_s[i, : len(rows)] = rows
    other.event_s = np.concatenate([[0.0], np.cumsum([p.hold_s + 0.6 for p in points])[:-1]])
    other.time_s = other.hold_s + other.event_s[:, None]
    return other.dataset(values(other) + other.noise(0.05, 0.1))


def open_between(*names: str, **more: Any) -> dict[str, Any]:
    """A diagnosis that leaves open which of these acts, each as likely."""
    return {"verdict": "confounded", "effects": [], "rivals": list(names), "effects_considered": [], **more}


def probabilities(summary: dict[str, Any]) -> dict[str, float]:
    """What a diagnosis thinks of each effect."""
    return {c["effect"]: c["probability"] for c in summary["effects_considered"]}


def long_holds(make_lab: Any) -> Any:
    """The same of one force, each level held for half a minute."""
    rows = tuple(np.geomspace(1.2, 30.0, 8))
    lab = make_lab(chambers=1, force=True, captures=16, rows_s=rows, repeats=False)
    lab.commanded[:] = np.where(np.arange(16)[:, None] % 2 == 0, 45.0, 0.0)
    return lab


@pytest.fixture(scope="module")
def doubt(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Any, dict[str, Any]]:
    """A run of two chambers, its model, and a diagnosis that leaves three explanations open."""
    lab = Lab(tmp_path_factory.mktemp("doubt"), chambers=2, markers=4, captures=24, rows_s=ROWS_S)
    model, run = lab.model(), lab.dataset(looped(lab) + lab.noise())
    return run, model, open_between("hysteresis", "creep", "friction")
