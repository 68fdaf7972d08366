"""The experiment that rules a suspect out: which set-points are measured again, and how they are handed over."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import yaml

from labrig import LabrigError, rule_out
from labrig.api._propose import Proposal
from labrig.diagnosis import rows_from
from labrig.effects import get
from labrig.experiment import Experiment, Limits, propose_experiment
from labrig.experiment._again import to_put_back
from labrig.live._adapt import propose
from tests.conftest import HIGH_KPA, Lab
from tests.walls import pressed

from .conftest import open_between

if TYPE_CHECKING:
    import xarray as xr

    from labrig.contents import Summary
    from labrig.model import Model

LIMIT_MM = 14.0
"""A wall that few of the set-points come to."""


@pytest.fixture(scope="module")
def at_a_wall(tmp_path_factory: pytest.TempPathFactory) -> tuple[Lab, "xr.Dataset", "Model"]:
    """A rig with three chambers, of which some set-points press markers against a wall."""
    lab = Lab(tmp_path_factory.mktemp("wall"), captures=60)
    return lab, lab.dataset(pressed(lab, LIMIT_MM) + lab.noise(0.05, 0.05)), lab.model()


@pytest.fixture(scope="module")
def only(at_a_wall) -> Experiment:
    """What is proposed where contact is all that is open, in four minutes."""
    _, run, model = at_a_wall
    return propose_experiment(run, model, summary=open_between("contact"), minutes=4)


@pytest.fixture(scope="module")
def beside(doubt) -> Experiment:
    """What is proposed where a regulator is open beside what set-points tell from it."""
    run, model, _ = doubt
    return propose_experiment(
        run, model, summary=open_between("hysteresis", "regulator"), minutes=4, changes=0
    )


def test_what_set_points_never_make_sure_is_measured_again_without_it(only: Experiment) -> None:
    """The programme is one to be run once the effect cannot act; it says so, and what a person does first."""
    assert only.summary["ruled_out"] == "contact"
    hand = only.summary["by_hand"][0]
    assert hand["what"] == (
        f"take away whatever the body could touch, leave all else as it is, and measure {len(only.points)} set-points "
        "again"
    )
    assert hand["captures"] == only.summary["captures"] == len(only.points)
    assert hand["minutes"] == only.summary["minutes"] <= 4
    assert only.points[-1].share == only.limits.rest


def test_the_set_points_are_those_that_show_it_and_others(only: Experiment, at_a_wall) -> None:
    """For half of the time those that press hardest, for the rest some that do not come near, in the run's order."""
    lab, run, _ = at_a_wall
    force = np.abs(pressed(lab, LIMIT_MM) - lab.predict(lab.u)).mean(axis=(1, 2))
    order = [tuple(row) for row in (run["commanded"].values / HIGH_KPA).round(3).tolist()]
    places = [order.index(tuple(np.round(point.share, 3).tolist())) for point in only.points[:-1]]
    touched = force[places] > 0.01
    assert touched.sum() >= 0.3 * len(places)
    assert (~touched).any()
    hardest = np.argsort(-force)[:8]
    assert {order.index(order[h]) for h in hardest} <= set(places)


def test_nothing_is_proposed_beyond_the_limits(at_a_wall) -> None:
    """Set-points of the run that the rig does not allow are not measured again."""
    _, run, model = at_a_wall
    limits = Limits.between(np.zeros(3), np.array([HIGH_KPA, 40.0, HIGH_KPA]))
    found = propose_experiment(run, model, summary=open_between("contact"), limits=limits, minutes=4)
    assert 5 < len(found.points) < 45
    assert max(limits.actuation(p.share)[1] for p in found.points) <= 40.0


@pytest.mark.parametrize(
    ("highest_kpa", "minutes"),
    [pytest.param(HIGH_KPA, 0.1, id="no time for any"), pytest.param(12.0, 4.0, id="none comes to the wall")],
)
def test_what_cannot_be_measured_again_is_not_proposed(at_a_wall, highest_kpa: float, minutes: float) -> None:
    """Nobody is sent to take something away for set-points that cannot show it."""
    _, run, model = at_a_wall
    limits = Limits.between(np.zeros(3), np.full(3, highest_kpa))
    with pytest.raises(LabrigError) as caught:
        propose_experiment(run, model, summary=open_between("contact"), limits=limits, minutes=minutes)
    said = f"no programme of {minutes:g} min within the rig's limits tells contact and no effect apart"
    assert str(caught.value) == said


def test_one_thing_is_said_to_be_done_by_hand(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Whoever registers the frame and measures set-points again is not told to measure one capture at rest besides."""
    lab = Lab(tmp_path_factory.mktemp("frame"), captures=60)
    run = lab.dataset(lab.predict(lab.u) + 0.4 + lab.noise(0.05, 0.05))
    found = propose_experiment(run, lab.model(), summary=open_between("frame"), minutes=4)
    assert [hand["effect"] for hand in found.summary["by_hand"]] == ["frame"]
    assert found.summary["by_hand"][0]["captures"] == len(found.points)


def test_it_is_offered_beside_the_programme_that_separates_others(beside: Experiment) -> None:
    """Where set-points tell something, they are the programme, and what to do by hand has set-points of its own."""
    assert "ruled_out" not in beside.summary
    assert beside.summary["expected"]
    (each,) = beside.again
    assert (each.effect, each.what) == ("regulator", get("regulator").ruled_out_by)
    assert beside.summary["by_hand"][0]["captures"] == len(each.points)


def test_who_has_ruled_it_out_is_not_asked_again(doubt) -> None:
    """What was gone, or stayed, where it was ruled out is settled; a try that told nothing is offered again."""
    run, model, _ = doubt
    for gone, offered in ((0.99, False), (0.01, False), (0.5, True)):
        told = [{"effect": "regulator", "probability": 0.5, "call": "possible", "gone": gone}]
        summary = open_between("hysteresis", "regulator", effects_considered=told)
        found = propose_experiment(run, model, summary=summary, minutes=3, changes=0)
        assert bool(found.again) == offered


@pytest.fixture(scope="module")
def gone(at_a_wall, tmp_path_factory: pytest.TempPathFactory) -> tuple["xr.Dataset", "xr.Dataset"]:
    """The run at the wall, and one of the same rig without it, in which contact is ruled out."""
    lab = Lab(tmp_path_factory.mktemp("free"), captures=30, seed=1)
    return at_a_wall[1], rule_out(lab.dataset(lab.predict(lab.u) + lab.noise(0.05, 0.05)), "contact")


def _seen_gone(probability_by_evidence: float, gone: float = 0.9) -> "Summary":
    """A diagnosis in which contact is possible, and was seen to be gone."""
    told = {"effect": "contact", "probability": 0.6, "call": "possible", "gone": gone}
    said = [told | {"by_evidence": probability_by_evidence, "share": 0.5}]
    return open_between("contact", effects_considered=said)


def test_what_was_gone_is_measured_once_more_as_it_was(gone, at_a_wall, tmp_path: Path) -> None:
    """What one change leaves in doubt is sure if it comes back with what was taken away: that is proposed, by hand
    first, and its run is not one in which anything is ruled out.
    """
    found = propose_experiment(gone, at_a_wall[2], summary=_seen_gone(0.98), minutes=4)
    assert (found.summary.get("ruled_out"), found.summary["put_back"]) == (None, "contact")
    assert found.summary["why"] == (
        "contact was gone once it was ruled out, and something else may have changed in that moment; when contact acts "
        "as before, what looks like it must be there again"
    )
    said = f"undo what ruled contact out, leave all else as it is, and measure {len(found.points)} set-points again"
    assert [hand["what"] for hand in found.summary["by_hand"]] == [said]
    proposal = Proposal(found)
    assert proposal.to_rule_out == []
    page = proposal.save(tmp_path, tmp_path / "next.yaml").read_text(encoding="utf-8")
    assert page.index("undo what ruled contact out") < page.index("What is measured")
    text = (tmp_path / "next.yaml").read_text(encoding="utf-8")
    assert f"# First {said}.\n" in text
    assert "rule-out" not in text
    assert propose(gone, at_a_wall[2], _seen_gone(0.98), [0.0] * 3, [HIGH_KPA] * 3, [100.0] * 3) == []


@pytest.mark.parametrize(
    ("order", "evidence", "name"),
    [
        pytest.param(1, 0.98, "contact", id="it would be sure"),
        pytest.param(-1, 0.98, "", id="it is back already"),
        pytest.param(1, 0.02, "", id="it would not be sure either"),
    ],
)
def test_what_would_not_make_it_sure_is_not_asked_for(gone, order: int, evidence: float, name: str) -> None:
    """Nobody is sent to put back what is back, or what has too little evidence to be sure then."""
    asked = to_put_back(_seen_gone(evidence), {"contact": get("contact")}, rows_from(gone[::order]))
    assert asked == name


def test_where_no_set_points_tell_somebody_has_to(at_a_wall) -> None:
    """Two curves of the pressures that no programme tells apart: one of them is taken away, and it says why."""
    _, run, model = at_a_wall
    found = propose_experiment(
        run, model, summary=open_between("contact", "stiffening"), minutes=4, changes=0
    )
    assert found.summary["ruled_out"] == "contact"
    assert found.summary["why"] == (
        "no programme within the limits tells contact and stiffening apart; "
        "when contact cannot act, what looks like it must be gone"
    )


def test_a_possible_name_of_an_unknown_error_can_be_taken_away_too(at_a_wall) -> None:
    """Where the error has no name that is probable enough, a possible one is offered beside where to look."""
    _, run, model = at_a_wall
    told = [{"effect": "contact", "probability": 0.4, "call": "possible"}]
    unknown = {"verdict": "unknown", "effects": [], "rivals": [], "carried_by": None}
    found = propose_experiment(run, model, summary={**unknown, "effects_considered": told}, minutes=4)
    assert "ruled_out" not in found.summary
    assert [each.effect for each in found.again] == ["contact"]
    assert found.summary["by_hand"][0]["effect"] == "contact"


def test_nobody_is_there_for_an_unattended_campaign(at_a_wall) -> None:
    """A campaign that adapts by itself takes no set-points for which somebody has to rule an effect out first."""
    _, run, model = at_a_wall
    assert propose(run, model, open_between("contact"), [0.0] * 3, [HIGH_KPA] * 3, [100.0] * 3) == []


def test_what_is_measured_without_it_has_files_of_its_own(beside: Experiment, tmp_path: Path) -> None:
    """Beside table and procedure lie those to be measured without the effect; the procedure says what to do first."""
    proposal = Proposal(beside)
    proposal.save(tmp_path / "next", tmp_path / "next.yaml")
    path = tmp_path / "next-without-regulator.yaml"
    text = path.read_text(encoding="utf-8")
    assert f"# First {beside.summary['by_hand'][0]['what']}.\n" in text
    assert "# Then say so: labrig rule-out RUN regulator\n" in text
    points: list[dict[str, Any]] = yaml.safe_load(text)["points"]
    assert len(points) == len(beside.again[0].points)
    assert {point["label"] for point in points} == {"regulator ruled out"}
    rows = (tmp_path / "next" / "programme-without-regulator.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == 1 + len(points)
    assert rows[0].startswith("c1 [kPa],c2 [kPa],hold_s")
    assert f'"procedure": "{path.as_posix()}"' in (tmp_path / "next" / "next.json").read_text(
        encoding="utf-8"
    )


def test_set_points_of_an_effect_that_is_not_offered_are_refused(beside: Experiment) -> None:
    """Only what is offered to be ruled out has set-points."""
    with pytest.raises(LabrigError) as caught:
        Proposal(beside).without("creep")
    assert str(caught.value) == "creep is not to be ruled out here"


def test_a_misspelt_effect_is_recognised(only: Experiment) -> None:
    """Also where all that is proposed is to rule one out."""
    with pytest.raises(LabrigError) as caught:
        Proposal(only).without("contacts")
    assert str(caught.value) == "contacts is not to be ruled out here; did you mean contact?"


def test_the_page_says_first_what_a_person_does(only: Experiment, beside: Experiment, tmp_path: Path) -> None:
    """Where the programme is for a rig without a suspect, taking it away comes before the set-points and no probe is
    told from another; elsewhere what to do by hand comes last.
    """
    page = Proposal(only).save(tmp_path / "only").read_text(encoding="utf-8")
    assert "minutes with contact ruled out." in page
    assert page.index("take away whatever the body could touch") < page.index("What is measured")
    assert "The probes" not in page
    page = Proposal(beside).save(tmp_path / "beside").read_text(encoding="utf-8")
    assert "minutes to tell hysteresis from regulator." in page
    assert page.index("The probes") < page.index("set each pressure by a reference manometer")
