"""A simulator whose stiffness each run says anew: what is refitted beside an effect, and what stands in its report."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from labrig._errors import LabrigError
from labrig.diagnosis import compare, improve, prepared
from labrig.diagnosis._candidates import Candidate, fit
from labrig.diagnosis._design_matrix import columns_of, join
from labrig.diagnosis._regression import Regression
from labrig.diagnosis._score import score
from labrig.effects import get, rows_of
from labrig.model import Model
from labrig.physics import ShellSurface, load_shell
from tests.naming import verdict_of

LONG_S = (3.0, 5.0, 10.0, 30.0)
SOFTER = 0.85


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are written to a folder of the test's own."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def regression(make_lab) -> Regression:
    """A rig that leaks, of a base with two calibrated parameters of which the rig has other values."""
    lab = make_lab(captures=40, chambers=3, long_s=LONG_S)
    u = lab.u * np.exp(-lab.hold_s / 60.0)[:, :, None]
    ready = prepared(rows_of(lab.dataset(lab.predict(u) + lab.noise())), lab.model())
    moves = ready.context.displacement
    fields = np.stack([moves, moves**2], axis=-1)
    return replace(ready.regression, calibrated=ready.regression.lift(fields))


@pytest.mark.parametrize("names", [["leak"], ["frame"], ["leak", "coupling"]])
def test_scores_are_those_of_refits_of_everything(regression: Regression, names: list[str]) -> None:
    """The gain of each left-out block is what effect and calibration, fitted to the others together, explain of it
    beyond a calibration alone."""
    variants = [next(iter(get(name).variants(regression.context))) for name in names]
    columns = join([columns_of(regression, variant) for variant in variants])
    fast = score(columns)
    assert regression.calibrated is not None
    w = regression.weight
    modes = regression.modes[:, columns.used][regression.source]
    for g in range(regression.n_groups):
        train, test = regression.group != g, regression.group == g
        left, X, E, own = (
            regression.partial(a, g)
            for a in (regression.residual, columns.X, columns.E, regression.calibrated)
        )
        every = np.concatenate([np.einsum("suq,suk->skq", X, modes), E, own], axis=2)
        n = columns.width
        G = np.einsum("skq,sk,skr->qr", every[train], w[train], every[train])
        c = np.einsum("skq,sk,sk->q", every[train], w[train], left[train])
        spent = G[:n, :n] - G[:n, n:] @ np.linalg.solve(G[n:, n:], G[n:, :n])
        G[:n, :n] += fast.ridge * np.diag(np.diag(spent))
        beta = np.linalg.solve(G, c)
        assert fast.fold_beta[g] == pytest.approx(beta[:n], rel=1e-3, abs=1e-4 * np.abs(beta[:n]).max())
        alone = np.linalg.solve(G[n:, n:], c[n:])
        before, after = (left - own @ alone)[test], (left - every @ beta)[test]
        gain = (w[test] * (before**2 - after**2)).sum()
        assert fast.gains[g] == pytest.approx(gain, rel=1e-3, abs=1e-3 * np.abs(fast.gains).max())


@pytest.mark.parametrize("names", [["leak"], ["frame"], ["leak", "coupling"]])
def test_the_error_that_is_quoted_is_the_one_that_is_scored(regression: Regression, names: list[str]) -> None:
    """By as much as the held-out gains say falls what the held-out prediction leaves."""
    assert_quoted_as_scored(regression, names)


@pytest.mark.parametrize("degree", [1, 2])
def test_the_same_of_a_map_that_is_fitted_to_the_run(make_lab, degree: int) -> None:
    """A static map that is fitted without a block gives way to the effects as it does in the scores."""
    lab = make_lab(captures=40, chambers=3, long_s=LONG_S)
    u = lab.u * np.exp(-lab.hold_s / 60.0)[:, :, None]
    rows = rows_of(lab.dataset(lab.predict(u) + lab.noise()))
    Path("static.yaml").write_text(f"base: {{kind: static, degree: {degree}}}\n")
    assert_quoted_as_scored(prepared(rows, Model.load("static.yaml")).regression, ["leak", "frame"])


def assert_quoted_as_scored(regression: Regression, names: list[str]) -> None:
    """The weighted square falls by the gain, block by block."""
    effects = [get(name) for name in names]
    variants = [next(iter(effect.variants(regression.context))) for effect in effects]
    columns = [columns_of(regression, variant) for variant in variants]
    parts = [Candidate(e, v, c, score(c)) for e, v, c in zip(effects, variants, columns, strict=True)]
    fitted = fit(parts)
    before = regression.square(regression.residual - regression.nothing)
    after = regression.square(regression.residual - fitted.heldout)
    gains = np.array([(before - after)[own].sum() for own in regression.blocks])
    assert gains == pytest.approx(fitted.score.gains, rel=1e-3, abs=1e-3 * np.abs(gains).max())


def test_nothing_is_what_a_calibration_alone_explains(regression: Regression) -> None:
    """What the base leaves is counted from a calibration that has not seen the block."""
    assert regression.calibrated is not None
    left = regression.residual - regression.nothing
    for g, own in enumerate(regression.blocks):
        target, fields = (
            regression.partial(regression.residual, g),
            regression.partial(regression.calibrated, g),
        )
        w = np.sqrt(regression.weight)[regression.group != g]
        A = (w[..., None] * fields[regression.group != g]).reshape(-1, 2)
        beta = np.linalg.lstsq(A, (w * target[regression.group != g]).ravel(), rcond=None)[0]
        assert left[own] == pytest.approx((target - fields @ beta)[own], abs=1e-4 * np.abs(left).max())


@pytest.fixture
def folder(small_rig: Callable[[int], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A coarse membrane, its rig, and its models with and without calibration."""
    monkeypatch.setenv("LABRIG_CACHE", str(tmp_path / "cache"))
    small_rig(10)
    Path("plain.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
    Path("model.yaml").write_text("base: {kind: simulator, rig: rig.yaml, calibrated: [modulus_1_kpa]}\n")
    return tmp_path


def measured(make_lab: Any, leak: bool) -> Any:
    """A campaign on a membrane that is softer than the model's, and whose chambers leak or not."""
    lab = make_lab(captures=36, chambers=4, markers=16, long_s=LONG_S)
    lost = 0.004 * lab.hold_s[:, :, None] if leak else 0.0  # through an orifice, not exponentially
    u = np.maximum(np.sqrt(lab.u) - lost, 0.0) ** 2
    known = load_shell("small.yaml")
    true = ShellSurface(known.changed(modulus_1_kpa=SOFTER * known.parameters["modulus_1_kpa"].value))
    position = true.predict(u.reshape(-1, 4)).reshape(*u.shape[:2], -1)
    noise = 0.05 * np.random.default_rng(3).normal(size=position.shape)
    return lab.dataset(position + noise).assign_coords(marker=list(true.marker_names))


def test_softer_sheets_are_no_missing_effect(folder: Path, make_lab) -> None:
    """A stiffness that is off has no effect's name: the calibrated model fits, the one that is not does not."""
    data = measured(make_lab, leak=False)
    plain, model = Model.load("plain.yaml"), Model.load("model.yaml")
    assert compare(data, plain).summary["error"]["model"] > 3 * compare(data, model).summary["error"]["model"]
    fitted = model.predictor(rows_of(data)).base
    assert fitted.values["modulus_1_kpa"] == pytest.approx(SOFTER * 400.0, rel=0.03)
    assert verdict_of(data, model).verdict == "nothing_missing"


def test_an_effect_is_found_beside_softer_sheets(folder: Path, make_lab) -> None:
    """With a leak as well, that is what is named; the model with it is right without being told the stiffness."""
    data, model = measured(make_lab, leak=True), Model.load("model.yaml")
    found = verdict_of(data, model)
    assert (found.verdict, found.effects) == ("identified", ("leak",))
    better = improve(data, model, ["leak"])
    assert better.improved is not None
    after = compare(data, better.improved).summary["error"]
    assert after["model"] < 1.3 * after["floor"]
    shown = better.fields["measured"] - better.fields["model"]
    assert float(np.sqrt((shown**2).mean())) < 1.3 * after["floor"]


def test_a_stiffness_that_is_known_is_given(folder: Path, make_lab) -> None:
    """A model with the right value of a parameter is as good as one that fits it, and has nothing fitted."""
    data = measured(make_lab, leak=False)
    Path("known.yaml").write_text(
        f"base: {{kind: simulator, rig: rig.yaml, parameters: {{modulus_1_kpa: {SOFTER * 400.0}}}}}\n"
    )
    known, fitted = (compare(data, Model.load(f"{m}.yaml")).summary["error"] for m in ("known", "model"))
    assert known["model"] == pytest.approx(fitted["model"], rel=0.05)
    for bad, complaint in (
        ("{softness: 3}", r"^shell membrane4: there is no parameter 'softness' \(it has modulus_1_kpa, "),
        ("{modulus_1_kpa: -3}", r"modulus"),
    ):
        Path("known.yaml").write_text(f"base: {{kind: simulator, rig: rig.yaml, parameters: {bad}}}\n")
        with pytest.raises(LabrigError, match=complaint):
            compare(data, Model.load("known.yaml"))
    Path("known.yaml").write_text("base: {kind: simulator, rig: rig.yaml, parameters: {modulus_1_kpa: 3}}\n")
    Path("rig.yaml").write_text(
        yaml.safe_dump({**yaml.safe_load(Path("rig.yaml").read_text()), "simulated": {"surface": "membrane"}})
    )
    with pytest.raises(
        LabrigError, match=r"^rig.yaml: a reduced surface has no parameters: modulus_1_kpa cannot be set$"
    ):
        compare(data, Model.load("known.yaml"))


def test_a_parameter_that_is_not_there(folder: Path, make_lab) -> None:
    """A name that the simulator does not know is one line with those that it does; reduced surfaces have none."""
    data = measured(make_lab, leak=False)
    Path("model.yaml").write_text("base: {kind: simulator, rig: rig.yaml, calibrated: [softness]}\n")
    with pytest.raises(LabrigError) as error:
        compare(data, Model.load("model.yaml"))
    assert str(error.value).startswith(
        "base: calibrated: the simulator of rig.yaml has no parameter 'softness' (it has modulus_1_kpa, thickness_1_mm,"
    )
    Path("rig.yaml").write_text(
        yaml.safe_dump({**yaml.safe_load(Path("rig.yaml").read_text()), "simulated": {"surface": "membrane"}})
    )
    with pytest.raises(LabrigError, match=r"has no parameter 'softness' \(it has none\)$"):
        compare(data, Model.load("model.yaml"))
