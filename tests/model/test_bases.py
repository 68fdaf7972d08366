"""Bases: a user's function, a fitted map, the simulator; their derivatives; and effects on top of them."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig._errors import LabrigError
from labrig.diagnosis import diagnose, improve
from labrig.effects import get, rows_of
from labrig.effects._fields import contribution
from labrig.model import EffectEntry, Model, Value, base_context, build_base, evaluate, find_variant, jacobian
from labrig.model._bases import solo_deflection

OLDER = "an entry of an older labrig has to be fitted again: remove it, then labrig improve"


@pytest.fixture
def bench(make_lab, monkeypatch: pytest.MonkeyPatch):
    """A small laboratory with one force, in the current folder."""
    lab = make_lab(chambers=2, force=True, captures=20, bent=0.0)
    monkeypatch.chdir(lab.folder)
    return lab


def predicted_by(code: str, rows) -> np.ndarray:
    """What a base of this code says of the rows."""
    Path("own.py").write_text(code)
    Path("own.yaml").write_text("base: {kind: python, file: own.py}\n")
    model = Model.load("own.yaml")
    return build_base(model.file, model.folder, rows).predict(rows.actuation)


@pytest.mark.parametrize(
    ("code", "complaint"),
    [
        (
            "def predict(u):\n    return u\n",
            "own.py:predict returned shape (60, 2) for actuation (60, 2); the run needs (60, 1), a column for each of "
            "force",
        ),
        (
            "def predict(u):\n    return u.sum()\n",
            "own.py:predict returned shape () for actuation (60, 2); the run needs (60, 1), a column for each of force",
        ),
        (
            "def predict(u):\n    return 0 * u[:, :1] + float('nan')\n",
            "own.py:predict returned NaN or infinite values, at 38.2, 16.2: it is asked for pressures between the "
            "limits, a little beside the set-points too",
        ),
        (
            "def predict(u):\n    raise ValueError('no')\n",
            "own.py:predict failed on 60 rows of 2 chambers: ValueError: no",
        ),
        (
            "def predict(u):\n    return 'much'\n",
            "own.py:predict failed on 60 rows of 2 chambers: ValueError: could not convert string to float: 'much'",
        ),
        (
            "def predict(u):\n    return u[:, 5]\n",
            "own.py:predict failed on 60 rows of 2 chambers: IndexError: index 5 is out of bounds for axis 1 with size "
            "2; was it made for a rig with another number of chambers?",
        ),
        ("def other(u):\n    return u\n", "own.py: has no function 'predict'"),
        ("predict = 3\n", "own.py: has no function 'predict'"),
        (
            "import missing_module\n",
            "own.py, line 1: ModuleNotFoundError: No module named 'missing_module'",
        ),
    ],
)
def test_a_function_that_is_wrong(bench, code: str, complaint: str) -> None:
    """What the function did, and what the run needs, in one line."""
    rows = rows_of(bench.dataset(bench.predict(bench.u)))
    with pytest.raises(LabrigError) as error:
        predicted_by(code, rows)
    assert str(error.value) == complaint


def test_a_function_that_is_not_there(bench) -> None:
    """A file that is missing, or that is not Python, is named."""
    rows = rows_of(bench.dataset(bench.predict(bench.u)))
    Path("own.yaml").write_text("base: {kind: python, file: none.py}\n")
    model = Model.load("own.yaml")
    with pytest.raises(LabrigError) as error:
        build_base(model.file, model.folder, rows)
    assert str(error.value) == "none.py: the model's Python file does not exist"
    Path("none.txt").write_text("")
    Path("own.yaml").write_text("base: {kind: python, file: none.txt}\n")
    model = Model.load("own.yaml")
    with pytest.raises(LabrigError) as error:
        build_base(model.file, model.folder, rows)
    assert str(error.value) == "none.txt: is not a Python file; its name ends in .py"


def test_a_function_may_give_one_number_a_row_and_use_files_beside_it(bench) -> None:
    """For one observable (F,) will do; modules beside the file can be imported; the input is the function's own."""
    rows = rows_of(bench.dataset(bench.predict(bench.u)))
    Path("helper_of_mine.py").write_text("FACTOR = 2.0\n")
    before = rows.actuation.copy()
    code = "from helper_of_mine import FACTOR\n\ndef predict(u):\n    u *= FACTOR\n    return u.sum(axis=1)\n"
    assert predicted_by(code, rows)[:, 0] == pytest.approx(2 * before.sum(axis=1))
    assert rows.actuation == pytest.approx(before)


def test_a_file_of_a_base_is_a_module(bench) -> None:
    """What looks its own module up, as a dataclass with written types does, works in it."""
    rows = rows_of(bench.dataset(bench.predict(bench.u)))
    code = (
        "from __future__ import annotations\nfrom dataclasses import dataclass\n\n"
        "@dataclass\nclass Bellows:\n    gain: float = 2.0\n\n"
        "def predict(u):\n    return Bellows().gain * u.sum(axis=1)\n"
    )
    assert predicted_by(code, rows)[:, 0] == pytest.approx(2 * rows.actuation.sum(axis=1))


def static(rows, degree: int):
    """A static map fitted to the rows."""
    Path("static.yaml").write_text(f"base: {{kind: static, degree: {degree}}}\n")
    model = Model.load("static.yaml")
    return build_base(model.file, model.folder, rows)


def test_a_static_map_finds_its_coefficients(bench) -> None:
    """A straight line through straight data is exact everywhere; outliers and gaps do not bend it."""
    values = bench.predict(bench.u)
    values[3] += 500.0
    values[5] = np.nan
    rows = rows_of(bench.dataset(values))
    u = np.array([[0.0, 0.0], [60.0, 10.0], [13.0, 55.0]])
    assert static(rows, 1).predict(u) == pytest.approx(bench.predict(u), abs=0.5)
    assert static(rows, 0).predict(u) == pytest.approx(np.full((3, 1), static(rows, 0).predict(u)[0, 0]))


@pytest.mark.parametrize(("degree", "columns"), [(0, 1), (1, 3), (2, 6), (3, 10)])
def test_a_static_map_declares_its_monomials(bench, degree: int, columns: int) -> None:
    """All products of the pressures up to the degree are the base's own; a plain function has none."""
    rows = rows_of(bench.dataset(bench.predict(bench.u)))
    declared = static(rows, degree).declared(rows.actuation)
    assert declared is not None
    assert declared.shape == (60, columns)
    assert np.linalg.matrix_rank(declared) == columns
    assert bench.model().declared(rows) is None


def test_the_jacobian_is_the_derivative(make_lab, monkeypatch: pytest.MonkeyPatch) -> None:
    """Central differences agree with the derivative of a saturating response, at each row."""
    lab = make_lab(captures=20, bent=1.5)
    monkeypatch.chdir(lab.folder)
    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    model = lab.model()
    J = jacobian(build_base(model.file, model.folder, rows), rows.actuation, rows.low, rows.high)
    x = rows.actuation / 60.0
    exact = lab.reach[None] * ((1 + lab.bent) / (1 + lab.bent * x) ** 2 / 60.0)[:, None]
    assert J.shape == (60, 18, 3)
    assert pytest.approx(exact, rel=1e-5, abs=1e-9) == J


class Clipped:
    """A base of two chambers that knows no pressure below zero or above 60."""

    kind = "python"
    calls = 0

    def predict(self, actuation: np.ndarray) -> np.ndarray:
        """Two observables, curved within the limits and constant beyond."""
        self.calls += 1
        u = np.clip(actuation, 0.0, 60.0)
        return np.stack([u[:, 0] + 0.01 * u[:, 0] ** 2 + 0.5 * u[:, 1], u[:, 0] - 2.0 * u[:, 1]], axis=1)

    def declared(self, actuation: np.ndarray) -> None:
        """Nothing."""


def test_the_slope_at_a_limit_is_that_just_inside() -> None:
    """A base that clips at its limits has its whole slope there, not half of it; one call finds all slopes."""
    base, low, high = Clipped(), np.zeros(2), np.full(2, 60.0)
    u = np.array(
        [[0.0, 0.0], [1e-4, 60.0], [0.5, 59.0], [60.0, 0.0], [60.0, 60.0], [-0.01, 60.01], [-5.0, 70.0]]
    )
    J = jacobian(base, u, low, high)
    x = np.clip(u[:, 0], 0.0, 60.0)
    exact = np.stack([np.stack([1 + 0.02 * x, np.ones(7)], axis=1), np.tile([0.5, -2.0], (7, 1))], axis=2)
    exact[-1] = 0.0
    assert pytest.approx(exact, abs=1e-6) == J
    assert base.calls == 1
    alone = solo_deflection(base, low, high)
    assert alone.reach == pytest.approx(np.array([[1.6, 0.5], [1.0, 2.0]]))


def test_deflections_are_shares_of_the_whole_way(make_lab) -> None:
    """Each chamber alone: zero when vented, one at full range, and in between as the base says."""
    lab = make_lab(captures=20, bent=1.5)
    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    model = lab.model()
    alone = solo_deflection(build_base(model.file, model.folder, rows), rows.low, rows.high)
    x = np.linspace(0, 1, 9)[:, None].repeat(3, axis=1)
    exact = x * 2.5 / (1 + 1.5 * x)
    assert alone.at(60 * x) == pytest.approx(exact, abs=2e-3)
    assert alone.slope(60 * x) == pytest.approx(2.5 / (1 + 1.5 * x) ** 2, rel=0.01)


RIG = {
    "name": "mannequin",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 10)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated"},
    "simulated": {"surface": "mannequin", "seed": 0},
}


def simulated(tmp_path: Path):
    """A simulator base, and rows of four of its markers."""
    import xarray as xr

    from labrig.physics import load_surface

    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(RIG))
    (tmp_path / "sim.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
    surface = load_surface(RIG)
    rng = np.random.default_rng(0)
    u = rng.uniform(0, 60, (8, 9))
    chosen = [30, 2, 17, 8]
    data = xr.Dataset(
        {
            "commanded": (("capture", "chamber"), u, {"units": "kPa"}),
            "hold_s": (("capture", "time"), np.full((8, 1), 3.0)),
            "time_s": (("capture", "time"), 10.0 * np.arange(8)[:, None] + 3.0),
            "event_time_s": ("event", 10.0 * np.arange(8)),
            "event_commanded": (("event", "chamber"), u),
            "position_mm": (("capture", "time", "marker", "axis"), surface.predict(u)[:, None, chosen]),
        },
        coords={
            "chamber": list(surface.chamber_names),
            "chamber_min": ("chamber", np.zeros(9)),
            "chamber_max": ("chamber", np.full(9, 60.0)),
            "session": ("capture", ["s"] * 8),
            "event_session": ("event", ["s"] * 8),
            "event_of": ("capture", np.arange(8)),
            "repeat": ("capture", [""] * 8),
            "marker": [surface.marker_names[m] for m in chosen],
            "axis": list("xyz"),
        },
    )
    return Model.load(tmp_path / "sim.yaml"), data


def test_the_simulator_finds_its_markers_and_chambers(tmp_path: Path) -> None:
    """Both are matched by name, in whatever order the run has them, with the simulator's own derivative."""
    from labrig.physics import load_surface

    model, data = simulated(tmp_path)
    rows, order = rows_of(data), [3, 0, 8, 1, 2, 7, 4, 5, 6]
    exact = load_surface(RIG).jacobian(rows.actuation)[:, [30, 2, 17, 8]].reshape(8, 12, 9)
    for chambers in (list(range(9)), order):
        context = model.context(rows_of(data.isel(chamber=chambers)))
        assert context.base == pytest.approx(rows.values)
        assert context.jacobian == pytest.approx(exact[..., chambers], rel=1e-3, abs=1e-5)


def test_the_simulator_says_what_it_does_not_know(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another marker, another chamber, a missing or broken rig file: each is named."""
    monkeypatch.chdir(tmp_path)
    _, data = simulated(tmp_path)
    model = Model.load("sim.yaml")

    def complaint(bad) -> str:
        with pytest.raises(LabrigError) as error:
            model.context(rows_of(bad))
        return str(error.value)

    assert (
        complaint(data.assign_coords(marker=["m31", "m03", "nose", "m09"]))
        == "rig.yaml: the simulator knows nothing of marker 'nose', which the run has"
    )
    names = [f"p{n}" for n in range(9)]
    assert (
        complaint(data.assign_coords(chamber=names))
        == f"rig.yaml: its chambers ({', '.join(data['chamber'].values)}) are not the run's ({', '.join(names)})"
    )
    Path("rig.yaml").write_text("a: [")
    assert complaint(data) == (
        "rig.yaml, line 1: is not YAML (expected the node content, but found '<stream end>')"
    )
    Path("rig.yaml").unlink()
    assert complaint(data) == "cannot read the rig of the simulator rig.yaml: No such file or directory"


@pytest.fixture
def leaking(make_lab, monkeypatch: pytest.MonkeyPatch):
    """A laboratory whose chambers leak, and what it measured."""
    lab = make_lab(captures=30, long_s=(3.0, 6.0, 12.0, 25.0))
    monkeypatch.chdir(lab.folder)
    u = lab.u * np.exp(-lab.hold_s / 60.0)[:, :, None]
    return lab, lab.dataset(lab.predict(u) + lab.noise())


def test_an_entry_says_what_the_fit_said(leaking) -> None:
    """The values of a model file give the prediction that the fit made, through the file and back."""
    lab, data = leaking
    better = improve(data, lab.model(), ["leak"])
    assert better.improved is not None
    better.improved.save("better.yaml")
    model = Model.load("better.yaml")
    rows = rows_of(data)
    base = base_context(build_base(model.file, model.folder, rows), rows)
    entry = model.file.effects[0]
    change = evaluate(base, get("leak"), entry)
    assert base.base + change == pytest.approx(model.context(rows).base)
    shown = better.fields["model_everywhere"].values - better.fields["base_everywhere"].values
    per_capture = np.array([change[rows.capture == c].mean(axis=0) for c in range(30)])
    assert per_capture == pytest.approx(shown, abs=2e-3 * np.abs(shown).max())
    left = diagnose(data, model).summary
    assert left["verdict"] == "nothing_missing"
    assert left["error"]["base"] == pytest.approx(better.summary["error"]["model"], rel=0.1)


def test_a_person_may_leave_the_form_out(leaking) -> None:
    """An entry without `form` means the first form with just these parameters; one value serves all chambers."""
    lab, data = leaking
    rows = rows_of(data)
    values = {"loss": Value(value=1.0), "tau_s": Value(value=60.0, unit="s")}
    plain = EffectEntry(name="leak", parameters=values)
    base = base_context(build_base(lab.model().file, lab.folder, rows), rows)
    variant = find_variant(base, get("leak"), plain)
    assert (variant.form, variant.shape) == ("exponential", {"tau_s": 60.0})
    exact = np.einsum("fkc,fc->fk", base.jacobian, -rows.actuation * -np.expm1(-rows.hold_s / 60.0)[:, None])
    assert evaluate(base, get("leak"), plain) == pytest.approx(exact)
    each = plain.model_copy(update={"form": "per chamber"})
    assert evaluate(base, get("leak"), each) == pytest.approx(exact)
    named = EffectEntry(name="leak", form="exponential", parameters=values)
    assert contribution(base, find_variant(base, get("leak"), named), [np.array([1.0])]) == pytest.approx(
        exact
    )


@pytest.mark.parametrize(
    ("entry", "complaint"),
    [
        (
            {"name": "leak", "form": "linear"},
            "effect 'leak' can't act on this run in form 'linear'; see: labrig effects show leak",
        ),
        (
            {"name": "leak"},
            "effect 'leak' can't act on this run in parameters none; see: labrig effects show leak",
        ),
        (
            {"name": "leak", "parameters": {"loss": {"value": 1.0}}},
            "effect 'leak' can't act on this run in parameters loss; see: labrig effects show leak",
        ),
        (
            {"name": "leak", "form": "exponential", "parameters": {"tau_s": {"value": 60.0}}},
            f"effect 'leak': the model gives no value for 'loss'; {OLDER}",
        ),
        (
            {"name": "tension", "form": "fading", "parameters": {"fades_at": {"value": 0.2}}},
            f"effect 'tension': has no parameter 'fades_at'; {OLDER}",
        ),
        (
            {
                "name": "contact",
                "form": "travel",
                "parameters": {"stopped": {"value": 1.0}, "limit": {"value": 0.5}},
            },
            f"effect 'contact': the model gives no value for 'distance'; {OLDER}",
        ),
        (
            {
                "name": "marker_slip",
                "form": "step",
                "parameters": {
                    "slip": {"value": 1.0},
                    "marker": {"value": 0.0},
                    "since": {"value": 3.0},
                },
            },
            f"effect 'marker_slip': the model gives no value for 'since_s'; {OLDER}",
        ),
        (
            {
                "name": "leak",
                "form": "per chamber",
                "parameters": {"loss": {"value": [1.0, 0.5]}, "tau_s": {"value": 60.0}},
            },
            "effect 'leak': 'loss' has 2 values, this run needs 3",
        ),
    ],
)
def test_an_entry_that_does_not_fit_the_run(leaking, entry: dict, complaint: str) -> None:
    """What is missing, or how many values it should be."""
    lab, data = leaking
    lab.model()
    Path("bad.yaml").write_text(
        yaml.safe_dump({"base": {"kind": "python", "file": "base.py"}, "effects": [entry]})
    )
    with pytest.raises(LabrigError) as error:
        Model.load("bad.yaml").context(rows_of(data))
    assert str(error.value) == complaint
