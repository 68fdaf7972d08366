"""Campaigns of the blind benchmark's plant, drawn by class and seed: each kind of verdict at least once."""

from pathlib import Path
from typing import Any

import pytest

from labrig.bench import draw, is_right, write_model
from labrig.diagnosis import diagnose
from labrig.model import Model


def judged(name: str, seed: int, folder: Path, **extra: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """The truth of a drawn campaign, and what the diagnosis says."""
    campaign = draw(name, seed)
    model = Model.load(write_model(campaign, folder))
    return campaign.truth, diagnose(
        campaign.dataset, model, without=campaign.truth["without"], **extra
    ).summary


@pytest.mark.parametrize(
    ("name", "seed", "verdict"),
    [
        ("null", 3, "nothing_missing"),
        ("null-slow", 500006, "nothing_missing"),  # slow noise of one force stands a little above its floor
        ("single-2", 1, "identified"),
        ("force", 0, "identified"),
        ("static", 0, "identified"),
        ("pair", 2, "multiple"),
        ("confounded", 0, "confounded"),
        (
            "confounded",
            98005,
            "confounded",
        ),  # on the whole problem every form of the leak loses out of sample
        ("confounded", 80004, "confounded"),  # two pressures in all: history and pressure are one
        ("confounded", 220006, "confounded"),  # the same, and the hysteresis hardly behind the friction
        ("confounded", 220005, "confounded"),  # one hold: nothing but the curve tells drift from creep
        ("pair", 90014, "multiple"),  # the leak's values change when the stiffening comes in
        ("pair", 210006, "multiple"),  # one stiffening for each chamber follows contact and coupling, nearly
        ("pair", 200002, "multiple"),  # the drift's form alone is another than beside the shape at rest
        ("pair", 200013, "multiple"),  # a drift that becomes nothing had kept the tension out
        ("pair", 210019, "multiple"),  # a warm-up that is nearly static, beside a coupling
        (
            "pair",
            210014,
            "multiple",
        ),  # beside a coupling the friction takes a form of its own for each chamber
        ("pair", 300006, "multiple"),  # a loop of a free pattern does as well as the friction
        ("pair", 90015, "multiple"),  # creep is a tie by block with the drift, not by capture
        ("pair", 320009, "multiple"),  # the limit's form is another beside the coupling than alone
        ("pair", 320013, "multiple"),  # a gain alike in all chambers does as well as a tension
        ("pair", 300008, "multiple"),  # the same, and a little better
        ("pair", 300054, "multiple"),  # a curve for each chamber follows a regulator and a limit
        ("pair", 300335, "multiple"),  # eighteen coefficients in the place of a tension and a limit
        ("pair", 300103, "multiple"),  # two laws in the place of a tension and a limit
        ("pair", 300175, "multiple"),  # plays that do as well, but lower no error beside a static map
        ("pair", 430006, "multiple"),  # a limit that misses a little of what a map sees, and no error of form
        ("pair", 300005, "multiple"),  # a coupling of which a stiffening leaves only what neighbours show
        ("pair", 300177, "multiple"),  # beside a coupling the regulator's field is that of a tension
        ("single-1", 410107, "identified"),  # a limit that is met softly is no stiffening as well
        ("force", 410008, "identified"),  # a limit that stops little is no rival of a stiffening
        ("force", 400001, "identified"),  # a few long holds are what a leak's form misses most
        (
            "single-1",
            300009,
            "identified",
        ),  # a gain for each chamber follows the creep, but not within the holds
        ("structural", 101004, "identified"),  # chambers of the base in other places are no regulator
        ("deleted", 0, "unknown"),
        ("deleted", 200004, "unknown"),  # a static name, and a little that moves
        ("unlisted", 200007, "unknown"),  # a name that moves, and more that moves
    ],
)
def test_the_verdict_is_right(name: str, seed: int, verdict: str, tmp_path: Path) -> None:
    """Verdict and names are those of the truth, which neither base nor library has been told."""
    truth, summary = judged(name, seed, tmp_path)
    assert truth["verdict"] == verdict
    assert is_right(truth, summary), (
        truth["effects"],
        summary["verdict"],
        summary["effects"],
        summary["rivals"],
    )
    if verdict in ("identified", "multiple") and not truth["structural"]:
        assert summary["drop"] > 0.8
    assert summary["error"]["floor"] == pytest.approx(truth["floor"], rel=0.6)


def test_noise_cannot_answer_a_fine_question(tmp_path: Path) -> None:
    """Where nothing is hidden and the tolerance is far below the floor, the data are not enough, and it is said."""
    truth, summary = judged("null", 3, tmp_path, tolerance=0.001)
    assert truth["verdict"] == "nothing_missing"
    assert summary["verdict"] == "underpowered"


def test_two_mistakes_in_a_row_hide_no_leak(tmp_path: Path) -> None:
    """Values of a single force that are mistaken in two captures on end do not keep a leak from being named."""
    truth, summary = judged("force", 400024, tmp_path)
    assert is_right(truth, summary), (summary["verdict"], summary["effects"])
