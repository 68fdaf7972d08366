"""A base of wrong form: its own error put aside, names that stand beside it stay, and no others."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig.bench import draw, is_right, write_model
from labrig.diagnosis import diagnose, prepare
from labrig.diagnosis._base_form import beside_form
from labrig.diagnosis._candidates import lay_out
from labrig.diagnosis._columns import Columns, columns_of, join
from labrig.diagnosis._score import score
from labrig.diagnosis._streams import Streams
from labrig.effects import get, rows_of
from labrig.model import Model


def verdict_of(name: str, seed: int, folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """The truth of a drawn campaign and the summary of its diagnosis."""
    campaign = draw(name, seed)
    model = Model.load(write_model(campaign, folder))
    return campaign.truth, diagnose(campaign.dataset, model, without=campaign.truth["without"]).summary


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        ("structural", 300001),  # patches in other places, and a frame that a shape at rest had followed
        ("structural", 300015),  # a wrong law, and a coupling
        ("structural", 300006),  # a wrong law, and a limit that a stiffening had followed
        ("structural", 300035),  # beside a leak what is static is the base's own
        ("structural", 400028),  # beside a creep the form is put aside too
        ("structural", 310021),  # a drift that gravity has made nothing
        ("structural", 430046),  # a frame that patterns too free had followed
        (
            "structural",
            431023,
        ),  # a tension, and no coupling that what each chamber's own law lacks could be taken for
        ("unlisted", 310016),  # a stand that gives way: nothing stands beside its form but a little coupling
        ("unlisted", 310001),  # a lens that a drift had followed
        ("pair", 300016),  # two names that leave no more than an error of form would
        ("single-2", 310009),  # a gain of the only chamber is of that form itself
    ],
)
def test_names_stand_beside_an_error_of_form(name: str, seed: int, tmp_path: Path) -> None:
    """What a place, a pair or a limit does is named beside the base's error of form; what is all form is unknown."""
    truth, summary = verdict_of(name, seed, tmp_path)
    assert is_right(truth, summary), (truth["effects"], summary["verdict"], summary["effects"])


@pytest.mark.parametrize(
    ("name", "seed", "carried_by"),
    [
        ("deleted", 300013, "the pressures of neighbouring chambers together"),
        ("deleted", 320011, "the pressures of neighbouring chambers together"),
        ("unlisted", 310008, "nothing that was logged"),  # no name comes in, and the error is three floors
        ("unlisted", 300019, "nothing that was logged"),  # creep takes less than half of it
    ],
)
def test_what_is_left_of_them_is_unknown(name: str, seed: int, carried_by: str, tmp_path: Path) -> None:
    """Names that follow an error only in part are not its cause, whether or not a learner sees the rest."""
    truth, summary = verdict_of(name, seed, tmp_path)
    assert truth["verdict"] == summary["verdict"] == "unknown"
    assert summary["carried_by"] == carried_by


def test_a_misfit_between_neighbours_is_not_seen_in_every_limit(tmp_path: Path) -> None:
    """A limit whose true law is rounder leaves a little that neighbours could explain, and stays named."""
    truth, summary = verdict_of("pair", 330021, tmp_path)
    assert is_right(truth, summary), (truth["effects"], summary["verdict"], summary["effects"])


@pytest.fixture
def laid_out(make_lab) -> tuple[Streams, Columns]:
    """Streams beside the base's own error of form, and the columns of a gain and of a coupling on them."""
    lab = make_lab(captures=60, bent=2.0, markers=6)
    values = lab.predict(1.1 * lab.u) + lab.noise()
    values[4, :, 3:6] = np.nan
    streams, context, _, _ = prepare(rows_of(lab.dataset(values)), lab.model())
    beside = beside_form(streams)
    assert beside is not None
    uneven = np.random.default_rng(1).uniform(0.2, 2.0, (len(beside.weight), 1))
    beside = replace(beside, weight=uneven * beside.weight)
    variants = [next(iter(get(name).variants(context))) for name in ("regulator", "coupling", "frame")]
    return beside, join([columns_of(beside, variant) for variant in variants])


def test_sums_made_once_are_those_of_each_fold(laid_out) -> None:
    """What is left out is predicted as if the form's coefficients had been fitted anew without it."""
    streams, columns = laid_out
    assert not columns.X.shape[2]
    for fold in (0, 5, streams.n_groups - 1):
        split = columns.held_out(fold)
        E, y = streams.partial(columns.E, fold), streams.partial(streams.residual, fold)
        for rows, gram, product in (
            (streams.group != fold, split.gram, split.product),
            (streams.group == fold, split.own_gram, split.own_product),
        ):
            weighted = streams.weight[rows][:, :, None] * E[rows]
            assert gram == pytest.approx(np.einsum("skq,skr->qr", weighted, E[rows]), rel=1e-6)
            assert product == pytest.approx(np.einsum("skq,sk->q", weighted, y[rows]), rel=1e-6, abs=1e-6)


def test_a_gain_of_the_form_explains_nothing_beside_it(make_lab) -> None:
    """A chamber that moves another pattern than the base says is form; what is left of a gain beside that is noise."""
    lab = make_lab(captures=60, markers=6)
    rng = np.random.default_rng(3)
    x = lab.u / 60.0
    wrong = (x * (1 + lab.bent) / (1 + lab.bent * x)) @ rng.normal(size=(3, 18))
    streams, context, floor, _ = prepare(
        rows_of(lab.dataset(lab.predict(lab.u) + wrong + lab.noise())), lab.model()
    )
    beside = beside_form(streams)
    assert beside is not None
    square = np.nanmean(np.where(beside.weight > 0, (beside.residual - beside.nothing) ** 2, np.nan))
    assert np.sqrt(square) < 1.3 * floor.row.mean()
    regulator = get("regulator")
    best = lay_out(beside, regulator, list(regulator.variants(context)))[0]
    alone = max(score(columns_of(streams, variant)).gain for variant in regulator.variants(context))
    assert best.score.gain < 0.01 * alone


def test_a_form_says_little_where_a_chamber_was_hardly_used(make_lab) -> None:
    """A pattern that only a few captures show does not make what is left out of them wildly wrong."""
    lab = make_lab(captures=60, markers=6, repeats=False)
    lab.commanded[:, 2] *= 0.02
    lab.commanded[20:25, 2] *= 50.0
    values = lab.predict(lab.u) + lab.noise()
    streams, _, _, _ = prepare(rows_of(lab.dataset(values)), lab.model())
    beside = beside_form(streams)
    assert beside is not None
    kept, free = (
        np.square(s.residual - s.nothing)[s.weight > 0].mean() for s in (beside, replace(beside, shrunk=None))
    )
    alone = np.square(streams.residual)[streams.weight > 0].mean()
    assert kept < 1.3 * alone
    assert free > 2.0 * alone


def test_a_law_without_a_name_is_the_bases_own(tmp_path: Path) -> None:
    """Where laws of the pressures tie, what stands beside them is the answer, and the warning has them."""
    truth, summary = verdict_of("structural", 430021, tmp_path)
    assert summary["verdict"] == "identified"
    assert summary["effects"] == truth["effects"] == ["delay"]
    assert any("(regulator or stiffening: not told apart here)" in said for said in summary["warnings"])


def test_one_force_has_no_form_of_its_own(make_lab) -> None:
    """Beside a pattern for every observable nothing would be left of a pressure where there are few observables."""
    lab = make_lab(captures=60, force=True)
    streams, _, _, _ = prepare(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model())
    assert beside_form(streams) is None
