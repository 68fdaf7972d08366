"""A suspect that somebody took away: what looked like it is gone, or it stays and is something else."""

from typing import TYPE_CHECKING

import numpy as np
import pytest

from labrig import LabrigError, rule_out
from labrig.diagnosis import SURE, clean, diagnose, forms_of, prepared, rows_from
from labrig.diagnosis._constants import P_EFFECT
from labrig.effects import forms_on, get, may_act, spaces_on
from tests.conftest import Lab
from tests.walls import pressed

if TYPE_CHECKING:
    from xarray import Dataset

    from labrig.diagnosis import Result

NEAR = {"contact", "tension", "stiffening", "coupling", "regulator", "gravity"}
"""What a wall may be taken for; to ask about all effects takes three times as long."""


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory: pytest.TempPathFactory) -> dict[str, "Dataset"]:
    """A campaign at a wall; and afterwards: without it, with it still, and where the rig never comes near it."""
    folder = tmp_path_factory.mktemp("wall")

    def measured(seed: int, wall: bool, highest: float = 1.0) -> "Dataset":
        lab = Lab(folder, captures=40 if seed else 60, seed=seed)
        lab.commanded *= highest
        return lab.dataset((pressed(lab) if wall else lab.predict(lab.u)) + lab.noise(0.05, 0.05))

    first = measured(0, wall=True)
    Lab(folder).model()
    again = measured(2, wall=True)
    others = {
        "free": measured(1, wall=False),
        "stays": measured(1, wall=True),
        "low": measured(1, False, 0.1),
    }
    return {"first": first, "again": again} | {name: rule_out(run, "contact") for name, run in others.items()}


def _diagnosed(
    campaigns: dict[str, "Dataset"], tmp_path_factory: pytest.TempPathFactory, *names: str
) -> "Result":
    model = Lab(tmp_path_factory.mktemp("model")).model()
    return diagnose([campaigns[name] for name in names], model, without=set(model.library()) - NEAR)


@pytest.fixture(scope="module")
def found(campaigns, tmp_path_factory) -> dict[str, "Result"]:
    """The diagnosis of the first campaign, alone and with each of the others."""
    each = {name: _diagnosed(campaigns, tmp_path_factory, "first", name) for name in ("free", "stays", "low")}
    return {"alone": _diagnosed(campaigns, tmp_path_factory, "first")} | each


def _of(result: "Result", name: str = "contact") -> dict:
    return next(dict(c) for c in result.summary["effects_considered"] if c["effect"] == name)


def test_a_suspect_that_is_gone_once_it_was_taken_away_is_sure(found) -> None:
    """A wall is never sure from set-points alone; measured again without it, it is, and the error falls."""
    assert _of(found["alone"])["call"] == "possible"
    summary = found["free"].summary
    assert (summary["verdict"], summary["effects"]) == ("identified", ["contact"])
    (said,) = (line for line in summary["warnings"] if "ruled out" in line)
    assert said == (
        "contact was ruled out in 40 captures, and what looks like it is gone there; "
        "something else may have changed with it, so measure once more as it was"
    )
    assert summary["drop"] > 0.8


def test_its_size_is_that_where_it_acts(found) -> None:
    """Captures without the suspect do not make it smaller: beside 40 of these it is as large as before."""
    before, joined = _of(found["alone"]), _of(found["free"])
    assert joined["size"] == pytest.approx(before["size"], rel=0.1)
    assert joined["size_floors"] / joined["size"] == pytest.approx(
        before["size_floors"] / before["size"], rel=0.2
    )


def test_measured_once_more_as_it_was_it_is_surer(campaigns, found, tmp_path_factory) -> None:
    """That something else changed whenever the suspect came and went is less probable each time, and not warned of."""
    again = _diagnosed(campaigns, tmp_path_factory, "first", "free", "again")
    assert _of(found["free"])["gone"] == pytest.approx(1 - P_EFFECT)
    assert _of(again)["gone"] == pytest.approx(1 - P_EFFECT**2)
    assert _of(again)["probability"] > _of(found["free"])["probability"] > SURE
    assert not any("once more as it was" in line for line in again.summary["warnings"])


def test_what_stays_where_it_was_ruled_out_is_something_else(found) -> None:
    """Where nothing is gone once the suspect was taken away, it is not there, and the verdict is that it is unknown."""
    summary = found["stays"].summary
    assert (summary["verdict"], summary["effects"], summary["rivals"]) == ("unknown", [], [])
    assert summary["carried_by"] == "what acts as contact does, and stays where that was ruled out"
    assert _of(found["stays"])["call"] == "not it"
    said = "contact was ruled out in 40 captures, and what looks like it stays there, so it is something else"
    assert said in summary["warnings"]


def test_set_points_that_do_not_show_the_suspect_change_nothing(found) -> None:
    """Where the rig does not come near it, that it was taken away says nothing, for it and against it."""
    alone, low = _of(found["alone"]), _of(found["low"])
    assert low["call"] == "possible"
    assert low["probability"] == pytest.approx(alone["probability"], abs=0.2)
    assert low.get("gone", 0.5) == pytest.approx(0.5, abs=0.1)
    assert any(
        "can't tell whether what looks like it is gone" in line for line in found["low"].summary["warnings"]
    )


def test_the_improved_model_has_nothing_of_it_there(found, campaigns, tmp_path_factory) -> None:
    """In captures where an effect is ruled out a model that has it says what it says without; elsewhere it does not."""
    improved = found["free"].improved
    assert improved is not None
    rows = rows_from([campaigns["first"], campaigns["free"]])
    changed = np.abs(
        improved.context(rows).base - Lab(tmp_path_factory.mktemp("b")).model().context(rows).base
    )
    acts = may_act(rows, "contact")
    assert changed[~acts].max() == 0.0
    assert changed[acts].max() > 1.0


def test_forms_and_spaces_act_only_where_the_effect_can(campaigns, tmp_path_factory) -> None:
    """A space is there twice: as what is gone where the effect was ruled out, and as what stays."""
    context = (
        Lab(tmp_path_factory.mktemp("c")).model().context(rows_from([campaigns["first"], campaigns["free"]]))
    )
    acts, contact = may_act(context.rows, "contact"), get("contact")
    assert acts.sum() == (context.rows.capture < 60).sum()
    assert all(not term.feature[~acts].any() for form in forms_on(contact, context) for term in form.terms)
    spaces = list(spaces_on(contact, context))
    gone, stay = ([s for s in spaces if s.stays == stays] for stays in (False, True))
    assert len(gone) > 0
    assert len(stay) > 0
    assert all(not f.values[~acts].any() for s in gone for f in s.features)
    assert any(f.values[~acts].any() for s in stay for f in s.features)
    assert not any(s.stays for s in spaces_on(get("tension"), context))


def test_what_is_gone_in_some_captures_is_no_mistake_in_the_others(campaigns, tmp_path_factory) -> None:
    """Mistaken values are looked for among captures in which the same can act."""
    model = Lab(tmp_path_factory.mktemp("d")).model()
    alone, dropped = clean(model.context(rows_from([campaigns["first"]])))
    both, _ = clean(model.context(rows_from([campaigns["first"], campaigns["free"]])))
    assert np.array_equal(np.isnan(both[: len(alone)]), np.isnan(alone))
    assert dropped == 0


def test_an_effect_that_is_ruled_out_in_all_captures_is_not_asked(campaigns, tmp_path_factory) -> None:
    """A campaign in which an effect could never act has no form of it to fit, and says nothing of it."""
    ready = prepared(rows_from([campaigns["free"]]), Lab(tmp_path_factory.mktemp("e")).model())
    contact, context = get("contact"), ready.context
    assert list(forms_on(contact, context)) == list(spaces_on(contact, context)) == []
    assert forms_of(ready.regression, context, contact) == []


def test_a_name_that_is_no_effect_is_refused(campaigns, tmp_path_factory) -> None:
    """What is ruled out has to be an effect that the model may name."""
    model = Lab(tmp_path_factory.mktemp("f")).model()
    run = campaigns["first"].assign_coords(ruled_out=("capture", ["contacts"] * 60))
    with pytest.raises(LabrigError) as caught:
        prepared(rows_from([run]), model)
    assert str(caught.value) == "'contacts' is ruled out in a run, and is no effect; did you mean contact?"
