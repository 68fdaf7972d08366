"""The programme procedure: a list of set-points becomes steps, and takes as long as the proposal says."""

from pathlib import Path

import numpy as np
import pytest

from labrig.campaign import Actuate, Note, Record, dry_run, rig_info
from labrig.experiment import Limits
from labrig.experiment._plan import Point, Probe
from labrig.rig import parse_rig
from labrig_procedures import Programme

RIG = parse_rig(
    {
        "name": "made",
        "chambers": [
            {"name": "c1", "max_kpa": 60, "slew_kpa_s": 30},
            {"name": "c2", "max_kpa": 40, "slew_kpa_s": 100},
        ],
        "pressure": {"kind": "openpneu"},
    },
    "rig.yaml",
    Path(),
)


def test_points_become_steps() -> None:
    """Chambers by name, the rest vented; what is not to be recorded is held; labels and notes arrive."""
    points = [
        {"pressure_kpa": {"c2": 20}, "hold_s": 5, "settle_s": 2, "repeat": "a", "label": "up"},
        {"hold_s": 3, "record": False, "note": "look"},
    ]
    steps = list(Programme.model_validate({"points": points, "rounds": 2}).steps(rig_info(RIG)))
    assert [tuple(s.pressure_kpa) for s in steps if isinstance(s, Actuate)] == [(0, 20), (0, 0)] * 2
    assert [(s.duration_s, s.repeat, s.label) for s in steps if isinstance(s, Record)] == [(3, "a", "up")] * 2
    assert [s.text for s in steps if isinstance(s, Note)] == ["look"] * 2


def test_a_short_hold_is_recorded_all_the_same() -> None:
    """Settling takes half of it at most."""
    steps = list(Programme.model_validate({"points": [{"hold_s": 0.6}]}).steps(rig_info(RIG)))
    assert [s.duration_s for s in steps if isinstance(s, Record)] == [0.3]


def test_the_estimate_is_that_of_the_dry_run() -> None:
    """Ways at each chamber's slew and holds: the proposal's minutes are the runner's, ticks and first vent apart."""
    limits = Limits(np.zeros(2), np.array([60.0, 40.0]), np.array([30.0, 100.0]))
    probe = Probe("p", "s", tuple(Point((a, b), 4.0) for a, b in [(0.9, 0.1), (0.2, 0.9), (0.0, 0.0)] * 4))
    points = [
        {
            "pressure_kpa": dict(zip(("c1", "c2"), limits.actuation(p.share).tolist(), strict=True)),
            "hold_s": p.hold_s,
        }
        for p in probe.points
    ]
    plan = dry_run(Programme.model_validate({"points": points}), RIG)
    assert plan.broken == []
    assert probe.seconds(limits) == pytest.approx(plan.duration_s, rel=0.05)
