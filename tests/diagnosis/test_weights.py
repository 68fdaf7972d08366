"""A family's own weights: for laws that no formula follows, in the model file and on another programme."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.linalg import block_diag

from labrig._errors import LabrigError
from labrig.bench import Campaign, draw
from labrig.bench._files import write_model
from labrig.bench._learner import capture_error
from labrig.diagnosis import Result, diagnose, forms_of, improve, prepared, rows_from, versus
from labrig.diagnosis._candidates import Candidate, fit, square_of
from labrig.diagnosis._design_matrix import columns_of
from labrig.diagnosis._diagnose import _errors
from labrig.diagnosis._formula import _plainest, good_enough
from labrig.diagnosis._score import score
from labrig.diagnosis._spectra import prior_of
from labrig.diagnosis._weights import family_forms
from labrig.effects import (
    fields_of,
    form_of,
    is_family,
    library,
    motion_scale,
    pressures_of,
    rows_of,
    weighable,
)
from labrig.model import Model


def error(model: Model, data: xr.Dataset) -> float:
    """The error of a model over the captures of a campaign, mistaken values left out."""
    rows = rows_of(data)
    return capture_error(rows, model.context(rows).base)


@pytest.fixture(scope="module")
def lip(tmp_path_factory: pytest.TempPathFactory) -> tuple[Campaign, Model, Result]:
    """A campaign on which a lip that seals itself leaks, a model without it, and the diagnosis."""
    campaign = draw("single", 790003)
    model = Model.load(write_model(campaign, tmp_path_factory.mktemp("lip")))
    others = set(model.library()) - {"leak", "creep", "delay", "drift"}
    return campaign, model, diagnose(campaign.dataset, model, without=others)


def test_the_error_falls_on_another_programme_as_far_as_was_found(
    lip: tuple[Campaign, Model, Result], tmp_path: Path
) -> None:
    """A lip that seals itself leaks by no formula of labrig's: the weights are saved, read, and hold elsewhere."""
    campaign, model, found = lip
    assert campaign.truth["laws"] == ["SelfActingLip"]
    assert found.improved is not None
    (entry,) = found.improved.file.effects
    assert entry.name == "leak"
    assert is_family(entry.form)
    found.improved.save(tmp_path / "better.yaml")
    saved = Model.load(tmp_path / "better.yaml")
    told = found.summary["error"]
    assert told["model"] < 0.6 * told["base"]
    left = error(saved, campaign.fresh)
    assert left == pytest.approx(error(found.improved, campaign.fresh), rel=1e-3)
    assert left < 0.6 * error(model, campaign.fresh)


def test_a_family_is_better_by_what_is_quoted_too(lip: tuple[Campaign, Model, Result]) -> None:
    """Nothing is shown as the weights of a family that errs more than the formula, or than the base, does."""
    campaign, model, _ = lip
    ready = prepared(rows_of(campaign.dataset), model)
    regression, weighted = ready.regression, 0

    def quoted(candidate: Candidate) -> float:
        return square_of(regression, regression.residual - fit([candidate]).heldout)

    for name in ("leak", "creep", "delay"):
        first, *others = forms_of(regression, ready.context, library()[name])
        formulas = [c for c in others if not is_family(c.variant.form)]
        if is_family(first.variant.form):
            weighted += 1
            assert quoted(first) < quoted(formulas[0])
            assert quoted(first) < square_of(regression, regression.residual - regression.nothing)
    assert weighted >= 1


def test_a_family_that_cannot_act_says_so(lip: tuple[Campaign, Model, Result]) -> None:
    """A saved family on a run without moments of its actuations is refused in words, not read as nothing."""
    campaign, _, found = lip
    assert found.improved is not None
    still = campaign.dataset.isel(time=slice(0, 1)).copy(deep=True)
    for name in ("hold_s", "event_time_s"):
        still[name].values[...] = np.nan
    with pytest.raises(LabrigError, match="effect 'leak'"):
        found.improved.context(rows_of(still))


def test_a_run_that_goes_farther_than_its_weights_is_warned_of(lip: tuple[Campaign, Model, Result]) -> None:
    """Weights say little of pressures that no run which they were fitted to went to, and that is said."""
    campaign, model, found = lip
    assert found.improved is not None
    (entry,) = found.improved.file.effects
    on = entry.fitted_on
    assert on is not None
    assert on.lowest is not None
    assert on.highest is not None
    rows = rows_of(campaign.dataset)
    assert on.highest == rows.actuation.max(axis=0).tolist()
    narrow = [low + 0.6 * (high - low) for low, high in zip(on.lowest, on.highest, strict=True)]
    entry = entry.model_copy(update={"fitted_on": on.model_copy(update={"highest": narrow})})
    half = replace(
        found.improved, file=found.improved.file.model_copy(update={"effects": [entry]}), path=None
    )
    assert not any("weights" in line for line in found.improved.context(rows).rows.warnings)
    (line,) = (line for line in half.context(rows).rows.warnings if "weights" in line)
    name, low, high = rows.chambers[0], on.lowest[0], narrow[0]
    there = rows.actuation[:, 0]
    assert line.startswith(
        f"leak: its weights are known from {name} {low:.3g} to {high:.3g} kPa "
        f"(here {there.min():.3g} to {there.max():.3g})"
    )
    assert line.endswith("beyond that they say little, so fit it again with runs that go as far")
    assert line in versus(campaign.dataset, model, half).summary["warnings"]


def _positive(covariance: np.ndarray) -> np.ndarray:
    """Without what is negative, as a spectrum is kept with four digits."""
    power, turn = np.linalg.eigh(covariance)
    return (turn * np.maximum(power, 0.0)) @ turn.T


def test_a_family_is_weighted_by_its_principal_directions(make_lab: Callable[..., Any]) -> None:
    """As they show in the observables, the functions that are weighted are uncorrelated under the prior, largest first.

    Checked row by row against every chamber's functions written out, with zeros where a chamber is not concerned.
    """
    lab = make_lab(captures=12)
    ready = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model())
    context, effect = ready.context, library()["hysteresis"]
    space, form = next(weighable(effect, context)), next(family_forms(effect, context))
    P = pressures_of(space, context)
    F, C, a = P.shape
    out = np.zeros((F, C, a * (1 + C)))
    for c in range(C):
        out[:, c, :a] = out[:, c, a * (1 + c) : a * (2 + c)] = P[:, c]
    prior = prior_of(space)
    covariance = block_diag(_positive(prior.shared[:a, :a]), *[_positive(prior.own)] * C)
    shows = (out * np.sqrt((context.jacobian**2).mean(axis=(0, 1)))[:, None]).reshape(F * C, -1)
    made = form.terms[0].feature * np.sqrt((context.jacobian**2).mean(axis=(0, 1)))[:, None]
    made = made.reshape(F * C, -1)
    power = np.linalg.eigvalsh(shows @ covariance @ shows.T)[::-1][: made.shape[1]]
    np.testing.assert_allclose(made.T @ made, np.diag(power), atol=1e-6 * power[0])


def test_functions_of_the_observables_are_weighted_likewise(make_lab: Callable[..., Any]) -> None:
    """Also where the functions are those of the observables, alone or beside those of the pressures: in parts of the
    rig's motion they are uncorrelated under the prior, largest first.
    """
    lab = make_lab(captures=12, bent=1.2)
    ready = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model())
    context = ready.context
    J, C, scale = context.jacobian, len(context.span), motion_scale(context)[:, None]
    for name, form in (("creep", "family, in the skin"), ("stiffening", "family, compliance")):
        space = next(s for s in weighable(library()[name], context) if form_of(s) == form)
        variant = next(v for v in family_forms(library()[name], context) if v.form == form)
        P, fields = pressures_of(space, context), fields_of(space, context)
        each = [J[:, :, c, None] * P[:, None, c] for c in range(C)]
        whole = [np.sum(each, axis=0), *each, fields] if P.shape[2] else [fields]
        shows = (np.concatenate(whole, axis=2) / scale).reshape(J.shape[0] * J.shape[1], -1)
        prior, a = prior_of(space), P.shape[2]
        covariance = np.zeros((shows.shape[1],) * 2)
        shared = np.r_[np.arange(a), np.arange(shows.shape[1] - fields.shape[2], shows.shape[1])]
        covariance[np.ix_(shared, shared)] = _positive(prior.shared)
        for c in range(C if a else 0):
            own = slice(a * (1 + c), a * (2 + c))
            covariance[own, own] = _positive(prior.own)
        (term,) = variant.terms
        assert term.kind == "field"
        made = (term.feature / scale).reshape(len(shows), -1)
        power = np.linalg.eigvalsh(shows @ covariance @ shows.T)[::-1][: made.shape[1]]
        np.testing.assert_allclose(made.T @ made, np.diag(power), atol=1e-6 * power[0])


def test_a_formula_comes_before_weights_that_are_fewer(make_lab: Callable[..., Any]) -> None:
    """Weights in one direction that follow a leak in each chamber as well as three rates do are not taken for it."""
    lab = make_lab(captures=40)
    loss = lab.u / (1 + lab.hold_s[:, :, None] / 80.0) - lab.u  # as fast as the square of the pressure
    data = lab.dataset(lab.predict(lab.u + loss * np.array([1.0, 0.5, 0.2])) + lab.noise())
    ready = prepared(rows_from(data), lab.model())
    regression, context, effect = ready.regression, ready.context, library()["leak"]
    formula = next(c for c in forms_of(regression, context, effect) if "per chamber" in c.variant.form)
    wide = next(iter(family_forms(effect, context)))
    columns = columns_of(regression, wide)
    (term,) = wide.terms
    fitted = score(columns).beta[:, None]
    narrow = replace(wide, terms=(replace(term, feature=term.feature @ fitted),))
    columns = columns_of(regression, narrow)
    weights = Candidate(effect, narrow, columns, score(columns))
    assert weights.columns.width == 1 < formula.columns.width == 3
    assert good_enough(weights, formula)
    for options in ([weights, formula], [formula, weights]):
        assert _plainest(options, options, formula) is formula


def test_what_acts_in_the_observables_is_weighted_too(tmp_path: Path) -> None:
    """A crack across the body moves the observables, not one chamber each: the weights of such functions, saved and
    read, take off four fifths of the error on another programme.
    """
    campaign = draw("single", 99500012, "ninth")
    assert campaign.truth["laws"] == ["CrackInTheWhole"]
    model = Model.load(write_model(campaign, tmp_path))
    result = improve(campaign.dataset, model, ["leak"])
    assert result.improved is not None
    (entry,) = result.improved.file.effects
    assert is_family(entry.form)
    result.improved.save(tmp_path / "better.yaml")
    base, left = error(model, campaign.fresh), error(Model.load(tmp_path / "better.yaml"), campaign.fresh)
    floor = float(np.hypot(campaign.truth["spoil"]["capture"], campaign.truth["spoil"]["row"]))
    assert base - left > 0.8 * (base - floor)


def test_a_sag_by_the_load_needs_the_load(tmp_path: Path) -> None:
    """Weights of what a load does are refused on a run that logged none, not read as nothing."""
    campaign = draw("single", 99500018, "ninth")
    assert campaign.truth["laws"] == ["FilledWallsGiveLess"]
    model = Model.load(write_model(campaign, tmp_path))
    improved = improve(campaign.dataset, model, ["gravity"]).improved
    assert improved is not None
    assert is_family(improved.file.effects[0].form)
    bare = campaign.fresh.drop_vars([v for v in campaign.fresh.data_vars if str(v).startswith("covariate")])
    with pytest.raises(LabrigError, match=r"^effect 'gravity' needs the payload, which this run did not log"):
        improved.context(rows_of(bare))


def test_the_bound_is_what_any_effect_reached(lip: tuple[Campaign, Model, Result]) -> None:
    """Where no learner comes as near as an effect by itself, though it is in no model, that effect is the bound."""
    campaign, model, _ = lip
    ready = prepared(rows_of(campaign.dataset), model)
    forms = forms_of(ready.regression, ready.context, library()["leak"])
    reached = float(np.sqrt(square_of(ready.regression, ready.regression.residual - forms[0].alone.heldout)))
    assert _errors(ready, None, {})["ceiling"] > 1.05 * reached
    assert _errors(ready, None, {"leak": forms})["ceiling"] == pytest.approx(reached)
