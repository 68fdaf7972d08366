"""Records without holds: what they hide is named by laws that the library does not have, and its formula is fitted."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from labrig.age._known import Known
from labrig.diagnosis import diagnose, forms_of, prepared
from labrig.diagnosis._candidates import plausible
from labrig.diagnosis._unnamed import unnamed
from labrig.effects import get, is_family, rows_of
from labrig.model import Model, base_context, build_base

DT_S, ROWS = 0.2, 700


def swept(seed: int) -> np.ndarray:
    """An input from 0 to 1 that goes up and down all the time, in sines of unlike periods, (ROWS,)."""
    t, random = np.arange(ROWS) * DT_S, np.random.default_rng(seed)
    u = sum(np.sin(2 * np.pi * t / p + random.uniform(0, 6)) * p**0.3 for p in (31.0, 17.0, 9.0, 5.0))
    return (u - u.min()) / np.ptp(u)


def record(u: np.ndarray, y: np.ndarray, input_unit: str, output_unit: str) -> xr.Dataset:
    """One input and one output, a row a sample, as an import without `capture` lays them out."""
    n, t = len(u), np.arange(len(u)) * DT_S
    return xr.Dataset(
        {
            "commanded": (("capture", "chamber"), u[:, None], {"units": input_unit}),
            "hold_s": (("capture", "time"), np.zeros((n, 1))),
            "time_s": (("capture", "time"), t[:, None]),
            "event_time_s": ("event", t),
            "event_commanded": (("event", "chamber"), u[:, None]),
            "observed": (("capture", "time", "observable"), y[:, None, None]),
        },
        coords={
            "chamber": ["u"],
            "chamber_min": ("chamber", [0.0]),
            "chamber_max": ("chamber", [float(u.max())]),
            "session": ("capture", ["s"] * n),
            "event_session": ("event", ["s"] * n),
            "event_of": ("capture", np.arange(n)),
            "repeat": ("capture", [""] * n),
            "observable": ["y"],
            "unit": ("observable", [output_unit]),
            "marker_of": ("observable", [""]),
            "axis_of": ("observable", [""]),
        },
    )


def model_of(tmp_path: Any, degree: int = 1) -> Model:
    """A static curve that is fitted to the record."""
    path = tmp_path / "model.yaml"
    path.write_text(f"base: {{kind: static, degree: {degree}}}\n", encoding="utf-8")
    return Model.load(path)


def relaxed(x: np.ndarray) -> np.ndarray:
    """Stress of a fractional solid under strain: each step decays as a Mittag-Leffler tail, here 1 / (1 + (t / 6)^0.7).

    A. Bonfanti et al., Fractional viscoelastic models for power-law materials, Soft Matter 16 (2020) 6002.
    """
    t = np.arange(len(x)) * DT_S
    kernel = 0.55 + 0.45 / (1 + (t / 6.0) ** 0.7)
    return np.convolve(np.diff(x, prepend=0.0), kernel)[: len(x)]


def test_a_rubber_relaxes(tmp_path: Any) -> None:
    """Strain commanded and force measured: creep is named, its shares are negative, and the error falls to a fifth."""
    x = 5.0 * swept(1)
    y = 12.0 * relaxed(x) + 0.1 * np.random.default_rng(2).normal(size=ROWS)
    found = diagnose(record(x, y, "mm", "N"), model_of(tmp_path)).summary
    assert "creep" in found["effects"]
    assert found["error"]["model"] < 0.2 * found["error"]["base"]
    formula = next(r for r in found["ranking"] if r["effect"] == "creep")
    values = formula["parameters"].get("spectrum") or formula["parameters"].get("amplitude")
    values = values or formula["parameters"]["pattern"]
    assert float(np.sum(values["value"])) < 0


@pytest.mark.parametrize(("units", "physical"), [(("mm", "N"), True), (("kPa", "mm"), False)])
def test_only_a_stretch_relaxes(tmp_path: Any, units: tuple[str, str], physical: bool) -> None:
    """A response that shrinks with time is physical where a displacement is commanded and a force measured."""
    x = 5.0 * swept(1)
    y = 12.0 * relaxed(x) + 0.1 * np.random.default_rng(2).normal(size=ROWS)
    ready = prepared(rows_of(record(x, y, *units)), model_of(tmp_path))
    creep = get("creep")
    formulas = [c for c in forms_of(ready.regression, ready.context, creep) if not is_family(c.variant.form)]
    assert len(formulas) >= 3
    for one in formulas[:3]:
        assert plausible(creep, one.variant, one.columns, one.score) is physical


@pytest.mark.parametrize("seed", range(3))
def test_the_plainest_formula_that_is_good_enough_stands_first(tmp_path: Any, seed: int) -> None:
    """One exponential is written as one lag, although a chain of seven lags follows its noise as well or better."""
    x, t = 5.0 * swept(seed), np.arange(ROWS) * DT_S
    y = 12.0 * np.convolve(np.diff(x, prepend=0.0), 0.6 + 0.4 * np.exp(-t / 5.0))[:ROWS]
    y = y + 0.3 * np.random.default_rng(seed).normal(size=ROWS)
    ready = prepared(rows_of(record(x, y, "mm", "N")), model_of(tmp_path))
    first, *others = forms_of(ready.regression, ready.context, get("creep"))
    assert first.variant.shape["tau_s"] == pytest.approx(5.0, rel=0.2)
    assert first.columns.width == min(c.columns.width for c in (first, *others))
    assert any(c.columns.width > first.columns.width for c in others)


def test_a_long_hose_answers_late(tmp_path: Any) -> None:
    """A dead time in a record: delay, with the time itself, and nothing of it is left."""
    dead_s, u = 2.2, 40.0 * swept(7)
    late = np.concatenate([np.zeros(round(dead_s / DT_S)), u])[:ROWS]
    y = 0.3 * late + 0.02 * np.random.default_rng(8).normal(size=ROWS)
    found = diagnose(record(u, y, "kPa", "mm"), model_of(tmp_path))
    assert found.summary["effects"] == ["delay"]
    assert found.improved is not None
    (entry,) = found.improved.file.effects
    assert entry.parameters["dead_s"].value == pytest.approx(dead_s, rel=0.1)
    assert found.summary["error"]["model"] < 0.06 * found.summary["error"]["base"]
    rows = rows_of(record(u, y, "kPa", "mm"))
    left = found.improved.context(rows).residual
    assert np.sqrt(np.mean(left**2)) < 0.06 * found.summary["error"]["base"]
    assert Known(found.improved).beside(rows).context.base == pytest.approx(rows.values - left)


def slipped(pull: np.ndarray) -> np.ndarray:
    """A tendon in a sheath: ten elements, each of which follows only outside the wedge of capstan friction.

    V. Agrawal et al., IEEE Trans. Robotics 26 (2010) 206.
    """
    tension, out = np.zeros(11), np.empty(len(pull))
    for i, value in enumerate(pull):
        tension[0] = value
        for e in range(1, 11):
            tension[e] = np.clip(tension[e], tension[e - 1] * np.exp(-0.05), tension[e - 1] * np.exp(0.05))
        out[i] = tension[-1]
    return out


def test_a_tendon_rubs(tmp_path: Any) -> None:
    """What follows only after a slack is a loop, whatever it is called: hysteresis or friction, and nothing else."""
    pull = 40.0 * swept(3)
    y = slipped(pull) + 0.1 * np.random.default_rng(4).normal(size=ROWS)
    found = diagnose(record(pull, y, "N", "N"), model_of(tmp_path)).summary
    assert {*found["effects"], *found["rivals"]} <= {"hysteresis", "friction"}
    assert found["effects"] or found["rivals"]


@pytest.mark.parametrize("rows", [700, 350])
def test_time_is_told_from_the_input_by_strokes(tmp_path: Any, rows: int) -> None:
    """A record sampled twice as densely has no more slow functions of time: its strokes are as many."""
    u = swept(5)[:: ROWS // rows]
    data = record(u, u + 0.01 * np.random.default_rng(6).normal(size=rows), "kPa", "mm")
    model = model_of(tmp_path)
    read = rows_of(data)
    context = base_context(build_base(model.file, model.folder, read), read)
    (time,) = [space for space in unnamed(context) if space.key == "time"]
    strokes = np.abs(np.diff(u)).sum() / np.ptp(u)
    slow = [f for f in time.features if f.name.startswith("cosine") and "load" not in f.name]
    assert len(slow) == int(strokes) - 1
