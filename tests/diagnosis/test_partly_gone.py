"""A suspect that was taken away only in part, or beside something else: what is neither gone nor there as it was."""

from typing import TYPE_CHECKING

import numpy as np
import pytest

from labrig import rule_out
from labrig.diagnosis import considered, diagnose, prepared, rows_from
from labrig.diagnosis._constants import P_EFFECT
from labrig.diagnosis._curves import curves, family_of
from tests.conftest import Lab
from tests.laws import bowed
from tests.polynomials import fitted
from tests.walls import pressed

if TYPE_CHECKING:
    from xarray import Dataset


NEAR = {"frame", "rest_shape", "drift", "contact", "tension", "stiffening", "regulator", "coupling"}
"""What these suspects may be taken for; to ask about all effects takes twice as long."""


def shifted(lab: Lab, by_mm: float) -> np.ndarray:
    """What is measured in a frame that is off by so much, and turned a little about y."""
    values = lab.predict(lab.u)
    values[..., 0::3] += by_mm
    values[..., 2::3] += by_mm * (0.01 * lab.rest_mm[:, 0] - 0.6)
    return values


def told(first: "Dataset", second: "Dataset", lab: Lab, name: str) -> tuple[dict, list[str]]:
    """What is said of an effect that was ruled out in the second of two campaigns, and the warnings."""
    model = lab.model()
    summary = diagnose([first, rule_out(second, name)], model, without=set(model.library()) - NEAR).summary
    of = next(dict(c) for c in summary["effects_considered"] if c["effect"] == name)
    return of, list(summary["warnings"])


def test_a_frame_that_is_registered_again_not_quite_right_is_not_cleared(make_lab) -> None:
    """What each session has another amount of neither stays nor is gone: a registration has an error of its own."""
    first, again = make_lab(captures=50), make_lab(captures=30, seed=1)
    runs = [
        lab.dataset(shifted(lab, by) + lab.noise(0.05, 0.05)) for lab, by in ((first, 0.5), (again, -0.2))
    ]
    frame, warnings = told(runs[0], runs[1], first, "frame")
    assert frame["by_evidence"] > 0.9
    assert frame["call"] == "possible"
    assert frame.get("gone", 0.5) == pytest.approx(0.5, abs=0.1)
    assert not any("stays there" in line for line in warnings)


def test_a_wall_that_was_moved_is_not_cleared(make_lab) -> None:
    """Where a part of it is gone and a part stays, it may have been taken away in part."""
    first, again = make_lab(captures=50), make_lab(captures=30, seed=1)
    runs = [
        lab.dataset(pressed(lab, at) + lab.noise(0.05, 0.05)) for lab, at in ((first, 9.0), (again, 12.0))
    ]
    contact, warnings = told(runs[0], runs[1], first, "contact")
    assert contact["by_evidence"] > 0.9
    assert contact["call"] == "possible"
    assert any("contact was ruled out" in line and "these can't tell" in line for line in warnings)


def test_a_fitted_map_lacks_the_same_whatever_was_taken_away(make_lab) -> None:
    """A curve that a polynomial of the second degree has not cannot go with a suspect: what went is the suspect."""
    first, again = make_lab(captures=60, bent=0.0), make_lab(captures=40, bent=0.0, seed=1)
    runs = [
        first.dataset(first.predict(bowed(first)) + first.noise(0.05, 0.05)),
        rule_out(again.dataset(again.predict(again.u) + again.noise(0.05, 0.05)), "regulator"),
    ]
    context = prepared(rows_from(runs), fitted(first, 2)).context
    effects = {name: e for name, e in first.model().library().items() if name in ("regulator", "tension")}
    named = family_of(effects, context)
    found = curves(named, effects, context)
    of = {name: [s for n, s in named if n == name and any(s is own for own in found)] for name in effects}
    assert of["tension"]
    assert of["regulator"]
    assert all(space.stays for space in of["regulator"])


def test_set_points_that_come_back_without_a_suspect_repeat_nothing(make_lab) -> None:
    """Captures repeat each other only where the same can act: else the noise would be as large as what is gone."""
    first, again = (make_lab(captures=40, repeats=False, force=True, seed=s) for s in (0, 1))
    again.commanded = first.commanded.copy()
    runs = [
        first.dataset(first.predict(bowed(first)) + first.noise(0.3, 0.3)),
        again.dataset(again.predict(again.u) + again.noise(0.3, 0.3)),
    ]
    both = prepared(rows_from([runs[0], rule_out(runs[1], "regulator")]), first.model()).floor
    assert both.repeats["N"]["same history"] is None
    assert both.mean[0] < 1.0
    assert (
        prepared(rows_from([runs[1], runs[1]]), first.model()).floor.repeats["N"]["same history"] is not None
    )


def test_days_without_a_suspect_say_as_much_as_one(make_lab) -> None:
    """What was there on the only day on which a suspect could act is gone on the others, not a matter of that day."""
    first, again = (make_lab(captures=40, force=True, seed=s, sessions=1 + s) for s in (0, 1))
    runs = [
        first.dataset(first.predict(bowed(first)) + first.noise(0.3, 0.3)),
        again.dataset(again.predict(again.u) + again.noise(0.3, 0.3)),
    ]
    regulator, _ = told(runs[0], runs[1], first, "regulator")
    assert regulator["gone"] == pytest.approx(
        1 - P_EFFECT
    )  # no more: something else may have changed with it


def test_a_suspect_is_as_likely_beforehand_as_if_nobody_had_tried(make_lab) -> None:
    """Its spaces are there twice, and each half as likely, those that were found by a scan, too."""
    lab = make_lab(captures=50)
    run = lab.dataset(pressed(lab) + lab.noise(0.05, 0.05))
    half = run.assign_coords(session=("capture", ["first"] * 25 + ["second"] * 25))
    contact = {"contact": lab.model().library()["contact"]}

    def places(run: "Dataset") -> list[float]:
        context = prepared(rows_from([run]), lab.model()).context
        return [1 / s.scanned for _, s in family_of(contact, context) if s.scanned]

    assert sum(places(rule_out(half, "contact", sessions=["second"]))) <= 1.25 * sum(places(half))


def test_what_does_not_come_back_with_the_suspect_is_not_known_to_be_gone(make_lab) -> None:
    """Where it was there in the first run alone, and not once all was as before, its absence in between says nothing:
    what is gone and what stays are then the same, and as likely.
    """
    labs = [make_lab(chambers=2, captures=n, seed=s) for s, n in enumerate((40, 25, 25))]
    runs = [
        lab.dataset(lab.predict(bowed(lab) if not i else lab.u) + lab.noise(0.05, 0.05))
        for i, lab in enumerate(labs)
    ]
    for i, run in enumerate(runs):
        run.attrs["start_s"] = 20_000.0 * i
    model = labs[0].model()
    others = set(model.library()) - NEAR
    found = considered([runs[0], rule_out(runs[1], "regulator"), runs[2]], model, others)
    regulator = next(c for c in found if c.effect == "regulator")
    assert regulator.gone == pytest.approx(0.5, abs=0.05)
    assert regulator.call == "possible"
