"""What a model says that other set-points would show."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig import LabrigError
from labrig.model import EffectEntry, Value


def test_what_was_measured_is_predicted_as_it_is_compared(lab: Path) -> None:
    """At a run's own set-points a model without memory says what a comparison has of it, capture by capture."""
    run = labrig.open_run(lab / "first")
    shown = labrig.predict(run, lab / "model.yaml", run["commanded"].values)
    fields = labrig.compare(run, lab / "model.yaml").fields
    seen = np.isfinite(fields["model"].values)
    assert seen.mean() > 0.9
    np.testing.assert_allclose(shown["predicted"].values[seen], fields["model"].values[seen], atol=1e-9)
    assert shown["observable"].values.tolist() == fields["observable"].values.tolist()
    assert shown["unit"].values.tolist() == ["mm"] * shown.sizes["observable"]


def test_effects_act_with_their_history(lab: Path) -> None:
    """What creeps has crept further in a longer hold, and what was before counts."""
    model = labrig.improve(lab / "first", lab / "model.yaml", "creep").model
    names = labrig.open_run(lab / "first")["chamber"].values.tolist()
    full = [30.0] * len(names)
    moved = {
        hold_s: np.linalg.norm(
            labrig.predict(lab / "first", model, [full], hold_s=hold_s)["predicted"].values
            - labrig.predict(lab / "first", lab / "model.yaml", [full])["predicted"].values
        )
        for hold_s in (4.0, 100.0)
    }
    assert 0 < moved[4.0] < 0.8 * moved[100.0]


@pytest.mark.parametrize("hold_s", [4.0, 60.0, 300.0])
@pytest.mark.parametrize(("unit", "each"), [("kPa", 1.0), ("Pa", 1000.0)])
def test_what_creeps_is_a_mean_over_time(lab: Path, hold_s: float, unit: str, each: float) -> None:
    """In each hold the mean of 1 - exp(-t / tau) from its first second to its end, whatever the unit of the run."""
    run = labrig.open_run(lab / "first").copy()
    for name in ("commanded", "event_commanded", "chamber_min", "chamber_max"):
        run[name] = run[name] * each
    run["commanded"].attrs["units"] = unit
    n = len(labrig.compare(lab / "first", lab / "model.yaml").fields["observable"])
    model = labrig.Model.of(lambda u: 0.1 / each * np.outer(u.sum(axis=1), np.ones(n)))
    creep = EffectEntry(
        name="creep",
        form="Kelvin-Voigt",
        parameters={
            "amplitude": Value(value=0.3),
            "tau_s": Value(value=30.0),
            "known": Value(value=0.0),
        },
    )
    u = [[40.0 * each] * 4]
    plain, crept = (
        labrig.predict(run, m, u, hold_s=hold_s)["predicted"].values
        for m in (model, model.with_effect(creep))
    )
    mean = 1 - 30 * (np.exp(-1 / 30) - np.exp(-hold_s / 30)) / (hold_s - 1)
    np.testing.assert_allclose(crept - plain, 0.3 * 16 * mean, rtol=2e-3)


def test_what_is_read_off_measured_pressures_is_said_to_be_unknown(lab: Path) -> None:
    """A leak that follows the measured pressures cannot be predicted before a run: that it changes nothing is said."""
    leak = EffectEntry(name="leak", form="as measured", parameters={"sensor": Value(value=1.0)})
    base = labrig.Model.load(lab / "model.yaml")
    u = labrig.open_run(lab / "first")["commanded"].values[:3]
    shown, plain = (labrig.predict(lab / "first", m, u) for m in (base.with_effect(leak), base))
    np.testing.assert_allclose(shown["predicted"].values, plain["predicted"].values)
    assert plain.attrs["warnings"] == []
    assert shown.attrs["warnings"] == [
        "leak is read off the measured pressures, which nobody knows before: it changes nothing here"
    ]


def test_set_points_of_a_table_go_by_the_names_of_its_columns(lab: Path) -> None:
    """Columns in another order mean the same; pressures beyond the run's are predicted as they are given."""
    names = labrig.open_run(lab / "first")["chamber"].values.tolist()
    u = np.arange(2.0 * len(names)).reshape(2, -1) * 10 + 0.123456
    frame = pd.DataFrame(u, columns=names)[names[::-1]]
    one, two = (labrig.predict(lab / "first", lab / "model.yaml", given) for given in (u, frame))
    np.testing.assert_array_equal(one["commanded"].values, u)
    assert one.identical(two)


@pytest.mark.parametrize(
    ("given", "more", "said"),
    [
        ([[1.0]], {}, "set_points: 1 x 1 given; "),
        ([], {}, "set_points: 0 given; "),
        ("ten", {}, "set_points: a table of numbers is needed; "),
        (pd.DataFrame({"q1": [1.0]}), {}, "set_points: there is no column 'c1'; "),
        ([[np.nan] * 4], {}, "set_points: row 0 is not finite"),
        ([[1.0] * 4], {"hold_s": "3 s"}, "hold_s '3 s': a number is needed, in seconds"),
        ([[1.0] * 4], {"hold_s": -1}, "hold_s -1: must be 1.5 s or more"),
        ([[1.0] * 4], {"hold_s": 0.5}, "hold_s 0.5: must be 1.5 s or more"),
        ([[1.0] * 4], {"hold_s": np.inf}, "hold_s inf: must be 1.5 s or more, and have an end"),
    ],
)
def test_what_is_no_set_point_is_said(lab: Path, given, more, said: str) -> None:
    """The number of columns, their names, and how long a hold may be."""
    with pytest.raises(LabrigError) as caught:
        labrig.predict(lab / "first", lab / "model.yaml", given, **more)
    assert str(caught.value).startswith(said)


def test_a_value_in_another_unit_predicts_nothing(lab: Path) -> None:
    """A time constant of one minute is not taken for one second."""
    leak = {"loss": Value(value=0.5), "tau_s": Value(value=1.0, unit="min")}
    model = labrig.Model.load(lab / "model.yaml").with_effect(
        EffectEntry(name="leak", form="exponential", parameters=leak)
    )
    with pytest.raises(
        LabrigError, match="'leak': tau_s is stated in min, and this run takes it in s: convert"
    ):
        labrig.predict(lab / "first", model, [[30.0] * 4])
