"""A base that is a table of predictions: exact at its set-points, smooth between them."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.interpolate import CubicSpline

from labrig import LabrigError
from labrig.diagnosis import diagnose
from labrig.effects import rows_of
from labrig.model import Model
from tests.conftest import Lab
from tests.laws import power_law
from tests.naming import verdict_of


def with_table(lab: Lab, u: np.ndarray, more: str = "") -> Model:
    """A model that knows what the laboratory's own function says at set-points (n, C)."""
    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    table = pd.DataFrame(np.column_stack([u, lab.predict(u)]), columns=[*rows.chambers, *rows.observables])
    table.to_csv(lab.folder / "predicted.csv", index=False)
    path = lab.folder / "table.yaml"
    path.write_text(f"base: {{kind: table, file: predicted.csv{more}}}\n")
    return Model.load(path)


def test_a_table_says_what_it_holds_and_is_smooth_between(make_lab) -> None:
    """At its set-points it is the table; slopes are those of the function that it came from, nearly."""
    lab = make_lab(chambers=2, markers=4, captures=60)
    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    of_table, of_function = (m.context(rows) for m in (with_table(lab, lab.commanded), lab.model()))
    assert of_table.base == pytest.approx(of_function.base, abs=1e-6)
    scale = np.abs(of_function.jacobian).max()
    assert np.sqrt(np.mean((of_table.jacobian - of_function.jacobian) ** 2)) < 0.1 * scale


def test_a_table_of_one_chamber_bends_least(make_lab) -> None:
    """Between twenty set-points of a muscle that hardens it errs as a natural cubic spline does, and not as a
    surface of two dimensions would; beyond the last one it goes on straight.
    """
    lab = make_lab(chambers=1, markers=2, captures=60)
    top = float(lab.u.max())

    def law(u: np.ndarray) -> np.ndarray:
        return 20 * np.exp(-4 * u / top) + 8 * np.tanh(5 * (u / top - 0.4))

    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    known = np.linspace(0.0, 0.8 * top, 20)[:, None]
    table = pd.DataFrame(known, columns=list(rows.chambers)).assign(
        **dict.fromkeys(rows.observables, law(known)[:, 0])
    )
    table.to_csv(lab.folder / "predicted.csv", index=False)
    (path := lab.folder / "table.yaml").write_text("base: {kind: table, file: predicted.csv}\n")
    context = Model.load(path).context(rows)
    p, said = rows.actuation[:, 0], context.base[:, 0]
    natural = CubicSpline(known[:, 0], law(known)[:, 0], bc_type="natural")
    within = p <= 0.8 * top
    assert said[within] == pytest.approx(natural(p[within]), abs=1e-6)
    assert np.abs(said - law(p))[within].max() < 0.05
    beyond = context.base[~within, 0] - natural(0.8 * top) - natural(0.8 * top, 1) * (p[~within] - 0.8 * top)
    assert (~within).sum() > 5
    assert np.abs(beyond).max() < 1e-3


def test_a_table_says_where_it_ends(make_lab) -> None:
    """A run that goes farther than its set-points has a line that names the chamber; one within them has none."""
    lab = make_lab(chambers=2, markers=4, captures=20)
    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    half = lab.commanded * [1.0, 0.5]
    far, near = (with_table(lab, u).context(rows).rows.warnings for u in (half, lab.commanded))
    assert not near
    assert [line.split(" to ")[0] for line in far] == [
        f"base (table): it is known from c2 {half[:, 1].min():.3g}"
    ]


def test_an_effect_is_named_beside_a_table(make_lab) -> None:
    """Creep acts through the slopes of the table."""
    lab = make_lab(chambers=2, markers=8, captures=80, rows_s=(1.0, 3.0, 8.0))
    model = with_table(lab, lab.commanded)
    found = verdict_of(lab.dataset(lab.predict(power_law(lab)) + lab.noise()), model)
    assert found.effects == ("creep",)


def test_a_function_that_looks_up_the_nearest_is_asked_about(make_lab) -> None:
    """A model without slopes says nothing of what acts through them: nothing is named, and one line says what to do."""
    lab = make_lab(chambers=2, markers=4, captures=60)
    np.save(lab.folder / "known.npy", np.column_stack([lab.commanded, lab.predict(lab.commanded)]))
    (lab.folder / "nearest.py").write_text(
        "from pathlib import Path\n\nimport numpy as np\n\nknown = np.load(Path(__file__).with_name('known.npy'))\n\n\n"
        "def predict(u):\n    away = ((u[:, None] - known[None, :, :2]) ** 2).sum(axis=2)\n"
        "    return known[away.argmin(axis=1), 2:]\n"
    )
    path = lab.folder / "nearest.yaml"
    path.write_text("base: {kind: python, file: nearest.py}\n")
    with pytest.raises(LabrigError) as error:
        diagnose(lab.dataset(lab.predict(lab.u) + lab.noise()), Model.load(path))
    assert str(error.value) == (
        "nothing can be diagnosed: the model says the same at pressures a little beside each set-point, and another "
        "thing at the next one, as a table that is looked up: no slopes can be read off it, so let it interpolate, or "
        "give its predictions as base: {kind: table, file: ...}"
    )


LINES = {
    "column": (
        "has no column 'm1.z' (an observable of the run); it has c1, c2, m0.x",
        lambda t: t.drop(columns="m1.z"),
    ),
    "chamber": (
        "do not change every chamber by itself (c1, c2): no slopes can be read off them",
        lambda t: t.assign(c2=5.0),
    ),
    "gap": (
        "column 'c1' (a chamber of the run) is empty or NaN; every row needs it",
        lambda t: t.replace(t["c1"][3], np.nan),
    ),
    "word": (
        "column 'c1' (a chamber of the run) holds 'no', not a number",
        lambda t: t.astype(object).replace(t["c1"][3], "no"),
    ),
    "file": ("the model's table does not exist", None),
}


@pytest.mark.parametrize("what", LINES)
def test_a_table_that_will_not_do(make_lab, what: str) -> None:
    """What is lacking, and where, in one line."""
    complaint, change = LINES[what]
    lab = make_lab(chambers=2, markers=4, captures=20)
    model, path = with_table(lab, lab.commanded), lab.folder / "predicted.csv"
    if change is None:
        path.unlink()
    else:
        change(pd.read_csv(path)).to_csv(path, index=False)
    with pytest.raises(LabrigError) as error:
        model.context(rows_of(lab.dataset(lab.predict(lab.u))))
    assert str(error.value).startswith(str(path))
    assert complaint in str(error.value)
    assert "\n" not in str(error.value)


def test_a_table_as_spreadsheets_write_it(make_lab) -> None:
    """Semicolons and decimal commas, or a workbook: it is read as the tables of runs are."""
    lab = make_lab(chambers=2, markers=4, captures=20)
    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    expected = with_table(lab, lab.commanded).context(rows).base
    table = pd.read_csv(lab.folder / "predicted.csv")
    table.to_csv(lab.folder / "predicted.csv", index=False, sep=";", decimal=",")
    assert Model.load(lab.folder / "table.yaml").context(rows).base == pytest.approx(expected)
    table.to_excel(lab.folder / "predicted.xlsx", index=False)
    path = lab.folder / "sheet.yaml"
    path.write_text("base: {kind: table, file: predicted.xlsx}\n")
    assert Model.load(path).context(rows).base == pytest.approx(expected)


def test_a_table_moves_with_its_model_file(make_lab, tmp_path: Path) -> None:
    """A model that is saved elsewhere finds its table."""
    lab = make_lab(chambers=2, markers=4, captures=20)
    other = tmp_path / "elsewhere"
    other.mkdir()
    with_table(lab, lab.commanded).save(other / "model.yaml")
    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    assert np.isfinite(Model.load(other / "model.yaml").context(rows).base).all()


def test_a_table_in_its_own_units(make_lab) -> None:
    """A table whose row of units says others than the run's is converted; what is of another kind is refused."""
    lab = make_lab(chambers=2, markers=4, captures=60)
    rows = rows_of(lab.dataset(lab.predict(lab.u)))
    model = with_table(lab, lab.commanded)
    exact = model.context(rows).base
    path = lab.folder / "predicted.csv"
    table = pd.read_csv(path) * ([0.01] * 2 + [0.1] * len(rows.observables))
    names, body = table.to_csv(index=False).split("\n", 1)
    for units, ok in (("bar", True), ("N", False)):
        row = ",".join([units] * 2 + ["cm"] * len(rows.observables))
        path.write_text(f"{names}\n{row}\n{body}")
        if ok:
            assert model.context(rows).base == pytest.approx(exact, abs=1e-6)
        else:
            with pytest.raises(LabrigError, match=r"column 'c1': unit 'N' can't be converted to kPa"):
                model.context(rows)
