"""One chamber of many leaks, creeps or meets something, and the others do not: its effect keeps its name."""

from collections import Counter

import numpy as np
import pytest

from labrig.diagnosis import observe, prepared, rows_from
from labrig.diagnosis._alone import _likeliest, with_single
from labrig.diagnosis._design import _share, design_of
from labrig.diagnosis._diagnose import laid_out, words_of
from labrig.diagnosis._observations import Observations
from labrig.effects import Space, pressure
from tests.laws import of_one, orifice, power_law, strut
from tests.naming import calls_of, verdict_of

AT_ONCE = (3.0, 3.5)
LONGER = (1.0, 3.0, 8.0)


def listed(spaces: list[tuple[str, Space]], observations: Observations) -> list[tuple[str, Space]]:
    """Spaces by owner, each followed by itself in one alone."""
    and_single = with_single(observations)
    return [(owner, one) for owner, space in spaces for one in and_single(owner, space)]


def test_what_one_of_five_chambers_has_is_named(make_lab) -> None:
    """Four chambers that do nothing do not make it improbable that the fifth leaks."""
    lab = make_lab(chambers=5, captures=45, rows_s=LONGER)
    found = verdict_of(lab.dataset(of_one(lab, orifice, 1)), lab.model())
    assert found.effects == ("leak",)
    assert found.warnings == (
        "most of what is missing is in c2 alone: look at its hose, valve, sensor and wall first",
    )


def test_nothing_is_said_of_one_chamber_where_all_have_it(make_lab) -> None:
    """Of a leak in all chambers no single one is to be looked at."""
    lab = make_lab(chambers=3, captures=45, rows_s=LONGER)
    found = verdict_of(lab.dataset(lab.predict(orifice(lab)) + lab.noise()), lab.model())
    assert (found.effects, found.warnings) == (("leak",), ())


def test_one_or_all_are_even_odds(make_lab) -> None:
    """A space and its single one, which stands for any of four chambers, are together as likely as the space was."""
    lab = make_lab(chambers=4, captures=60)
    model = lab.model()
    _, observations, _ = laid_out(prepared(rows_from(lab.dataset(of_one(lab, strut, 2))), model), {})
    blocks = design_of(observations, {"hysteresis": model.library()["hysteresis"]}).blocks
    share = {b.space.key: b.share for b in blocks if b.owner == "hysteresis"}
    whole = share["in the skin"]
    assert share["play"] == pytest.approx(whole / 2)
    assert share["play, c3 alone"] == pytest.approx(whole / 2 / 4)
    held = [b.share * (4 if b.space.alone_in else 1) for b in blocks if b.owner == "hysteresis"]
    assert sum(held) == pytest.approx(1.0)


def test_what_has_no_name_is_carried_by_a_name_of_its_own(make_lab) -> None:
    """Words of what carries an unnamed part do not change with the chamber that is asked about by itself."""
    lab = make_lab(chambers=4, captures=60)
    model = lab.model()
    _, observations, _ = laid_out(prepared(rows_from(lab.dataset(of_one(lab, strut, 2))), model), {})
    words = words_of(design_of(observations, {}))
    assert "history through the pressures" in words.values()
    assert not [w for w in words.values() if w.endswith(tuple(f"c{c} alone" for c in range(1, 5)))]


def test_what_one_chamber_meets_is_no_other_effect_surely(make_lab) -> None:
    """A curve of one chamber alone may be a stop or a wall that stiffens: the stop is possible at least."""
    lab = make_lab(chambers=5, captures=60, rows_s=AT_ONCE, bent=0.0)
    calls = calls_of(lab.dataset(of_one(lab, strut, 1)), lab.model())
    assert calls["contact"] in {"sure", "possible"}
    assert not [name for name, call in calls.items() if call == "sure" and name != "contact"]


def observations_of(lab, values: np.ndarray) -> Observations:
    """What a campaign says, as the diagnosis has it; what effects would be asked of it is laid out by others."""
    return laid_out(prepared(rows_from(lab.dataset(values)), lab.model()), {})[1]


@pytest.mark.parametrize(("law", "force"), [(power_law, False), (orifice, True), (strut, False)])
def test_the_chamber_is_found_by_what_it_does(make_lab, law, force: bool) -> None:
    """Where all chambers move one sensor, too, it is told by its own pressure, history and time."""
    for c in range(4):
        lab = make_lab(chambers=4, captures=60, rows_s=LONGER, force=force, seed=c)
        assert _likeliest(observations_of(lab, of_one(lab, law, c))) == c


@pytest.mark.parametrize("law", [power_law, orifice, strut])
def test_what_all_chambers_have_is_in_no_single_one(make_lab, law) -> None:
    """Where one chamber explains less than half of what all do, it is not asked for by itself."""
    lab = make_lab(chambers=8, markers=8, captures=60, rows_s=LONGER)
    assert _likeliest(observations_of(lab, lab.predict(law(lab)) + lab.noise())) is None


def test_of_two_chambers_there_is_no_single_one(make_lab) -> None:
    """Spaces of one chamber alone begin with three chambers."""
    lab = make_lab(chambers=2)
    observations = observations_of(lab, lab.predict(lab.u) + lab.noise())
    spaces = [("leak", Space("any", "any", (pressure("x", observations.context.rows.fraction),)))]
    assert _likeliest(observations) is None
    assert listed(spaces, observations) == spaces


def test_what_is_planned_says_nothing_of_the_chamber(make_lab) -> None:
    """Observations that are zero, because nothing was measured yet, do not change which chamber is asked."""
    lab = make_lab(chambers=4, captures=60)
    ready = prepared(rows_from(lab.dataset(of_one(lab, strut, 2))), lab.model())
    half = np.where((ready.context.rows.capture < 30)[:, None], ready.residual, 0.0)
    assert _likeliest(observe(ready.context, half, ready.floor)) == 2


def test_a_space_and_its_single_one(make_lab) -> None:
    """The single one has the same functions in one chamber, and none elsewhere; a scanned space has none, and neither
    has what acts in the observables."""
    lab = make_lab(chambers=4, captures=60)
    observations = observations_of(lab, of_one(lab, strut, 3))
    x = observations.context.rows.fraction
    (f,) = features = (pressure("x", x),)
    given = [
        ("contact", Space("limit", "contact limit", features, along=f)),
        ("slip", Space("found", "found", features, scanned=9)),
        ("regulator", Space("of c1", "of c1", (pressure("x", x * [1, 0, 0, 0]),))),
    ]
    both, of_c4, found, of_c1 = listed(given, observations)
    assert (both[0], both[1].key, both[1].rarer) == ("contact", "limit", 2)
    assert (of_c4[0], of_c4[1].key, of_c4[1].rarer) == ("contact", "limit, c4 alone", 8)
    for own in (of_c4[1].features[0], of_c4[1].along):
        assert own is not None
        assert np.array_equal(own.values, x * [0, 0, 0, 1])
    assert [found, of_c1] == given[1:]


def test_one_chamber_where_all_of_them_show_nothing() -> None:
    """Where the space of all chambers is too small to be laid out, that of one has its share all the same."""
    alone = Space("in c1", "leak", (pressure("leak", np.ones((4, 3))),), alone_in="c1", rarer=6)
    assert _share("leak", alone, Counter()) == pytest.approx(1 / 6)
