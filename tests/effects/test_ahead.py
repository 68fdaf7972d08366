"""A delay is late: what is measured ahead of the model is no delay, however well lags describe it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.diagnosis._verdict import Verdict
from labrig.effects import rows_of
from labrig.effects.delay import Delay
from labrig.model import Model
from labrig.view._naming import carries
from tests.laws import stretched
from tests.naming import verdict_of

TIME_S = np.arange(0, 120, 0.1)


def input_at(t: np.ndarray, fast: float = 1.0) -> np.ndarray:
    """A pressure that never rests, kPa, so many times as fast."""
    t = fast * t
    return 25 + 8 * (np.sin(0.5 * t) + np.sin(1.13 * t + 1) + np.sin(1.9 * t + 2))


def recorded(run: Path, force: np.ndarray, fast: float = 1.0) -> Verdict:
    """What is said of a record of this force, N, of which the model says a fifth of the pressure."""
    noise = np.random.default_rng(5).normal(0, 0.1, len(TIME_S))
    columns = {
        "t (s)": TIME_S.round(2),
        "p set (kPa)": input_at(TIME_S, fast).round(3),
        "force (N)": (force + noise).round(3),
    }
    return verdict_of(labrig.import_table(pd.DataFrame(columns), run), Model.of(lambda u: 0.2 * u))


@pytest.mark.parametrize(("ahead_s", "fast"), [(0.1, 1.0), (0.3, 3.0)], ids=["hardly", "by much of a wave"])
def test_a_clock_that_is_ahead_is_no_delay(tmp_path: Path, ahead_s: float, fast: float) -> None:
    """It is unknown, and said to be ahead."""
    found = recorded(tmp_path / "ahead", 0.2 * input_at(TIME_S + ahead_s, fast), fast)
    assert (found.verdict, found.effects) == ("unknown", ())
    assert found.carried_by == "what is ahead of the input"


def test_a_clock_that_is_behind_is_a_delay(tmp_path: Path) -> None:
    """The same the other way round has a name."""
    assert recorded(tmp_path / "late", 0.2 * input_at(TIME_S - 0.3)).effects == ("delay",)


def test_a_damper_is_no_delay(tmp_path: Path) -> None:
    """A force in proportion to the speed leads what moves."""
    speed = np.gradient(input_at(TIME_S), TIME_S)
    found = recorded(tmp_path / "run", 0.2 * input_at(TIME_S) + 0.03 * speed)
    assert found.carried_by == "what is ahead of the input"


def test_a_lag_in_holds_stays_a_delay(make_lab) -> None:
    """A pressure that is late by a stretched exponential is not turned round."""
    lab = make_lab(chambers=2, rows_s=(1.0, 1.5, 2.5, 5.0), captures=60)
    found = verdict_of(lab.dataset(lab.predict(stretched(lab)) + lab.noise()), lab.model())
    assert "delay" in found.effects


def test_where_to_look_is_said() -> None:
    """Clocks first."""
    assert carries("what is ahead of the input").startswith("is ahead of the input: compare the clocks")


def test_what_is_ahead_by_less_than_the_rest_is_a_part_of_something(make_lab) -> None:
    """A small lead beside something larger says nothing of a delay."""
    lab = make_lab(force=True, chambers=2, rows_s=(1.0, 1.5, 2.5, 5.0), captures=60)
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    lead = np.einsum("fkc,fc->fk", context.jacobian, context.rows.actuation - context.relaxed(1.2))
    other = np.random.default_rng(0).normal(size=lead.shape)
    for share, said in ((0.5, ""), (2.0, "what is ahead of the input")):
        seen = context.base + share * lead / np.maximum(lead.std(axis=0), 1e-9) + other
        changed = replace(context, rows=replace(context.rows, values=seen), _memo={})
        assert Delay().turned_round(changed) == said
