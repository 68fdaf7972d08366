"""The benchmark of a suspect that is taken away: what is tried, and what is counted."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from labrig.bench import _ruled_out, ruled_out_plan, ruled_out_rows, run_ruled_out
from labrig.bench._draw import draw
from labrig.bench._programmes import Plan
from labrig.bench._ruled_out import MIX, Tried, _states, tried_of
from labrig.diagnosis import Considered


def tried(there: bool, gone: float, after: float = 0.9, **more: object) -> Tried:
    """What was said of a contact that evidence is sure of."""
    return Tried("ninth", "contact", there, 0.6, after, 0.999, 1.0, gone, **{"back": after, **more})  # type: ignore[arg-type]


def test_classes_come_one_after_another() -> None:
    """Each half has the same classes, with a seed for each campaign."""
    todo = ruled_out_plan(8, 5, ("ninth", "tenth"))
    assert [name for name, _, half in todo if half == "ninth"] == [*MIX, MIX[0]]
    assert [seed for _, seed, half in todo if half == "tenth"] == list(range(5, 13))


def test_a_drawn_suspect_is_taken_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """A leak that is hidden and then closed is surer than before, since what looked like it is gone."""
    monkeypatch.setattr(_ruled_out, "draw", partial(draw, captures=40))
    found = tried_of(("single", 81_000_118, "eleventh"))
    assert found is not None
    assert (found.effect, found.there) == ("leak", True)
    assert found.gone == pytest.approx(0.9)  # no more, since something else may have changed
    assert found.after > 0.9


@pytest.mark.parametrize(
    ("after", "gone", "runs"), [(0.6, 0.9, 3), (0.9, 0.9, 2), (0.6, 0.5, 2), (0.05, 0.9, 2)]
)
def test_what_was_gone_and_is_in_doubt_is_put_back(
    monkeypatch: pytest.MonkeyPatch, after: float, gone: float, runs: int
) -> None:
    """As labrig next asks: a third run, with the effect and with nothing ruled out; not where it is sure, or not it, or
    where nothing was seen to be gone.
    """
    asked: list[list[xr.Dataset]] = []

    def considered(given: "list[xr.Dataset] | xr.Dataset", *_: object) -> tuple[Considered, ...]:
        asked.append(given if isinstance(given, list) else [given])
        said = {1: 0.5, 2: after, 3: 0.97}[len(asked[-1])]
        return (Considered("leak", said, by_evidence=0.9, share=0.9, gone=gone),)

    monkeypatch.setattr(_ruled_out, "considered", considered)
    found = tried_of(("single", 81_000_118, "eleventh"))
    assert found is not None
    assert (found.after, found.back) == (after, 0.97 if runs == 3 else after)
    assert ["ruled_out" in run.coords for run in asked[-1]] == [False, True, False][:runs]


def test_a_later_plan_lacks_what_is_ruled_out() -> None:
    """The same rig without the effect is as its base says, and its captures say what was ruled out."""
    campaign = draw("single", 81_000_118, "eleventh")
    (name,) = campaign.truth["effects"]
    assert campaign.later is not None

    def measured(ruled_out: tuple[str, ...]) -> np.ndarray:
        plan = Plan(np.random.default_rng(1), campaign.dataset["chamber_max"].values)
        for _ in range(3):
            plan.capture(0.8 * campaign.dataset["chamber_max"].values, 30.0, 6)
        run = campaign.later(plan, 1, ruled_out)  # type: ignore[misc]
        assert ("ruled_out" in run.coords) == bool(ruled_out)
        assert not ruled_out or list(run["ruled_out"].values) == [name] * 3
        values = run["position_mm" if "position_mm" in run else "observed"].values
        return values.reshape(3, 6, -1)

    with_it, without = measured(()), measured((name,))
    noise = campaign.truth["floor"]
    fell = np.abs(np.nanmean(with_it[:, -1] - with_it[:, 0], axis=0)).max()
    assert fell > 3 * np.abs(np.nanmean(without[:, -1] - without[:, 0], axis=0)).max() > 0
    assert fell > 3 * noise


def test_all_else_is_as_it_was() -> None:
    """A campaign that was turned is measured again turned in each of these ways; another one in none."""
    turned = next(
        c for c in (draw("single", s, "ninth") for s in range(200, 260)) if "covariates" in c.dataset
    )
    states = _states(turned.dataset)
    assert len(states) > 1
    assert len(set(states)) == len(states)
    still = next(
        c for c in (draw("single", s, "ninth") for s in range(200, 260)) if "covariates" not in c.dataset
    )
    assert _states(still.dataset) == [(0.0, 0.0)]


def test_a_row_for_those_that_were_there_and_one_for_the_others() -> None:
    """Of each suspect, and of all: how many were sure before and after, with intervals."""
    head, rows = ruled_out_rows(
        [tried(True, 0.99), tried(True, 0.9, after=0.5, back=0.8), tried(False, 0.01, after=0.02)]
    )
    assert head[2:5] == ["sure before", "sure after", "sure once it was put back"]
    assert [row[:2] for row in rows] == [["all", "yes"], ["all", "no"], ["contact", "yes"], ["contact", "no"]]
    shares = ["0 of 2 (0 to 66 %)", "1 of 2 (9 to 91 %)", "2 of 2 (34 to 100 %)"]
    assert rows[0][2:5] == shares
    assert rows[1][5] == "1 of 1 (21 to 100 %)"


def test_what_was_tried_is_not_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder that has some campaigns goes on with the others; campaigns without a suspect are known, too."""
    asked = []

    def said(task: tuple[str, int, str]) -> Tried | None:
        asked.append(task)
        return None if task[1] % 2 else tried(True, 0.99)

    monkeypatch.setattr(_ruled_out, "tried_of", said)
    todo = ruled_out_plan(4, 0, ("ninth",))
    first = list(run_ruled_out(todo[:2], tmp_path, 1))
    assert list(run_ruled_out(todo, tmp_path, 1)) == [*first, tried(True, 0.99), None]
    assert asked == todo
