"""Creep that is over within seconds, and a valve that is slow: one function nearly, whose size says which it is."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.diagnosis import _diagnose, diagnose, prepared, rows_from
from labrig.diagnosis._diagnose import laid_out, result_of, verdict_on
from labrig.diagnosis._formula import forms_of
from labrig.diagnosis._out_of_bounds import in_place_of
from labrig.effects import get
from labrig.model import Model

STEP_S = 0.02
ROWS_S = (0.5, 1.5, 3.0, 5.0, 7.5, 10.0)


def stretched(drive: np.ndarray, tau_s: float, power: float) -> np.ndarray:
    """What follows each step of a drive by a stretched exponential (Kohlrausch 1854), all steps superposed."""
    t = STEP_S * np.arange(len(drive))
    out = np.zeros(len(drive))
    for at in np.flatnonzero(np.diff(drive, prepend=0.0)):
        change = drive[at] - (drive[at - 1] if at else 0.0)
        out[at:] += change * -np.expm1(-((t[: len(t) - at] / tau_s) ** power))
    return out


def filled(drive: np.ndarray, tau_s: float) -> np.ndarray:
    """A chamber behind a porous plug: the flow goes with the power 0.8 of the difference, step by step."""
    out, last = np.empty_like(drive), 0.0
    for i, now in enumerate(drive):
        left = (now - last) / 60
        last += 60 * STEP_S / tau_s * np.sign(left) * np.abs(left) ** 0.8
        out[i] = last
    return out


def named(make_lab: Any, folder: Path, answer: Callable[[np.ndarray], np.ndarray]) -> dict[str, Any]:
    """What is said of one chamber that is held for ten seconds each, before a line that was fitted; it answers a
    history of pressures by another.
    """
    lab = make_lab(chambers=1, force=True, bent=0.0, captures=40, rows_s=ROWS_S, repeats=False)
    clock = np.arange(0.0, lab.time_s.max() + 1.0, STEP_S)
    event = np.searchsorted(lab.event_s, clock, side="right") - 1
    seen = answer(lab.commanded[event, 0])[np.searchsorted(clock, lab.time_s)]
    (folder / "model.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    data = lab.dataset(lab.predict(seen[:, :, None]) + lab.noise())
    return dict(diagnose(data, Model.load(folder / "model.yaml")).summary)


@pytest.mark.parametrize("tau_s", [1.5, 3.0])
def test_creep_within_seconds_is_no_delay(make_lab: Any, tmp_path: Path, tau_s: float) -> None:
    """What yields by an eighth more within seconds is never a delay, surely: such a lag has no share in the change that
    a delay has. Why it is in doubt is said.
    """
    found = named(make_lab, tmp_path, lambda p: p + 0.12 * stretched(p, tau_s, 0.9))
    assert "delay" not in found["effects"]
    assert "creep" in {*found["effects"], *found["rivals"]}
    said = [
        line
        for line in found["warnings"]
        if line.startswith("delay fits only by values outside what is physical")
    ]
    assert len(said) == ("delay" in found["rivals"])


def test_beside_a_partner_bounds_say_nothing(make_lab: Any) -> None:
    """A fit of one effect alone takes what its partner explains, too: its values are then no reason to doubt it."""
    lab = make_lab(chambers=1, force=True, bent=0.0, captures=40, rows_s=ROWS_S, repeats=False)
    clock = np.arange(0.0, lab.time_s.max() + 1.0, STEP_S)
    pressure_kpa = lab.commanded[np.searchsorted(lab.event_s, clock, side="right") - 1, 0]
    seen = pressure_kpa + 0.15 * stretched(pressure_kpa, 2.4, 0.9)
    seen = seen[np.searchsorted(clock, lab.time_s)][:, :, None]
    ready = prepared(rows_from(lab.dataset(lab.predict(seen) + lab.noise())), lab.model())
    found = {name: forms_of(ready.regression, ready.context, get(name)) for name in ("delay", "creep")}
    assert in_place_of(found, ["delay"]) == {"creep"}
    assert in_place_of(found, ["delay"], together=["delay", "leak"]) == set()


def test_partners_are_known_where_bounds_are_asked(make_lab: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A verdict whose names act together says so to who asks whether values are physical."""
    lab = make_lab(chambers=1, force=True, bent=0.0, captures=30, rows_s=ROWS_S, repeats=False)
    model = lab.model()
    run = lab.dataset(lab.predict(lab.u * (1 + 0.1 * np.log1p(lab.hold_s))[:, :, None]) + lab.noise())
    ready, observations, design = laid_out(prepared(rows_from(run), model), model.library())
    verdict = verdict_on(ready, observations, design, model.library())
    asked: list[tuple[str, ...]] = []
    monkeypatch.setattr(
        _diagnose, "in_place_of", lambda *_, together=(): asked.append(together) or frozenset()
    )
    for together in ((), ("creep", "leak")):
        told = replace(verdict, verdict="confounded", effects=("creep",), rivals=("leak",), together=together)
        result_of(ready, observations, told, model, model.library())
    assert asked == [(), ("creep", "leak")]


def test_a_chamber_that_fills_slowly_does_not_creep(make_lab: Any, tmp_path: Path) -> None:
    """All of the change comes late, within seconds: no rubber yields by so much."""
    found = named(make_lab, tmp_path, lambda p: filled(p, 4.0))
    assert (found["effects"], found["rivals"]) == (["delay"], [])


def test_what_relaxes_within_seconds_may_be_creep(tmp_path: Path) -> None:
    """A stretched rubber whose force falls in each hold is no lag of what is ahead: that is taken back, and creep, of
    which a formula fits as well, is possible in its place.
    """
    random = np.random.default_rng(4)
    stage_mm = np.repeat(random.permutation(np.repeat(np.arange(0.0, 11.0, 2.0), 5)), round(10.0 / STEP_S))
    yields = 0.18 * (stage_mm - stretched(stage_mm, 2.4, 0.9))
    every = slice(None, None, 25)
    frame = pd.DataFrame(
        {
            "t [s]": (STEP_S * np.arange(len(stage_mm)))[every],
            "stage [mm]": stage_mm[every],
            "force [N]": (stage_mm + yields)[every] + random.normal(0, 0.1, len(stage_mm[every])),
        }
    )
    run = labrig.import_table(frame, tmp_path / "run")
    (tmp_path / "model.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    found = labrig.diagnose(run, tmp_path / "model.yaml")
    assert "creep" in {*found.sure, *found.possible}
    assert "delay" not in {*found.sure, *found.possible}
