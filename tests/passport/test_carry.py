"""improve --prior: an effect that was fitted on one rig, on another."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import labrig as lab
from labrig import LabrigError

Typed = Callable[..., tuple[int, str, str]]
CHAMBERS = ("c1", "c2", "c3", "c4")


def make_rig(
    folder: Path, name: str, creep_mm: float, chambers: tuple[str, ...] = CHAMBERS, seed: int = 1
) -> Path:
    """A folder with a rig that creeps, of another formula than the library's, and a model that does not know it."""
    hidden = {"effects": [{"name": "creep", "amplitude": creep_mm}], "unit": "mm", "seed": 1}
    rig: dict[str, Any] = {
        "name": name,
        "chambers": [{"name": each, "max_kpa": 60} for each in chambers],
        "pressure": {"kind": "simulated", "rate_hz": 5},
        "mocap": {"kind": "simulated", "rate_hz": 5},
        "simulated": {"surface": "membrane", "seed": seed, "hidden": hidden},
    }
    own = folder / name
    own.mkdir()
    (own / "rig.yaml").write_text(yaml.safe_dump(rig), encoding="utf-8")
    (own / "model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n", encoding="utf-8")
    return own


@pytest.fixture(scope="module")
def rigs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Rig `a` with a fitted model; `b`, which creeps 1.2 times as much, with runs of 6 and of 20; `c`, three times."""
    folder = tmp_path_factory.mktemp("rigs")
    for name, creep_mm, captures in (("a", 1.0, (30,)), ("b", 1.2, (6, 20)), ("c", 3.0, (12,))):
        own = make_rig(folder, name, creep_mm, seed=ord(name))
        for number in captures:
            lab.run("capture", own / "rig.yaml", out=own / f"run-{number}", captures=number, seed=number)
    fitted = lab.improve(folder / "a" / "run-30", folder / "a" / "model.yaml", "creep")
    fitted.model.save(folder / "a" / "fitted.yaml")
    return folder


def amplitudes(model: lab.Model) -> np.ndarray:
    """Of creep, by chamber."""
    (entry,) = model.file.effects
    return np.array(entry.parameters["amplitude"].value)


def test_a_short_run_and_a_prior_together(rigs: Path) -> None:
    """The values lie between both, nearer to the one that is surer, and are surer than either."""
    prior = rigs / "a" / "fitted.yaml"
    both = lab.improve(rigs / "b" / "run-6", rigs / "b" / "model.yaml", "creep", prior=prior)
    table = both.prior
    assert (table["sd"] < table["prior_sd"]).all()
    assert (table["sd"] <= table["data_sd"]).all()
    low, high = table[["prior", "data"]].min(axis=1), table[["prior", "data"]].max(axis=1)
    assert table["value"].between(low - 1e-9, high + 1e-9).mean() >= 0.75  # chambers pull at each other
    weight = table["prior_sd"] ** -2 / (table["prior_sd"] ** -2 + table["data_sd"] ** -2)
    assert (np.abs(table["value"] - table["data"]) <= np.abs(table["prior"] - table["data"])).all()
    assert (weight < 0.5).all()
    ratio = table["value"] / amplitudes(lab.Model.load(prior))
    assert np.allclose(ratio, 1.2, atol=0.15)
    assert both.error["model"] < 0.5 * both.error["base"]
    assert both.summary["prior"]["z"] < 3


def test_a_narrow_prior_counts_for_more(rigs: Path) -> None:
    """The less an effect may differ from place to place, the nearer the values are to the prior."""
    runs, model, prior = rigs / "b" / "run-6", rigs / "b" / "model.yaml", rigs / "a" / "fitted.yaml"
    away = []
    for spread in (0.15, 0.5):
        table = lab.improve(runs, model, "creep", prior=prior, spread=spread).prior
        away.append(float(np.abs(table["value"] / table["prior"] - 1).mean()))
    assert away[0] < away[1]


def test_what_is_carried_over_keeps_its_time_constant(rigs: Path) -> None:
    """The amounts of a prior count as they are known where its time constant stays: that each alone is known badly
    changes nothing.
    """
    content = yaml.safe_load((rigs / "a" / "fitted.yaml").read_text(encoding="utf-8"))
    amplitude = content["effects"][0]["parameters"]["amplitude"]
    assert np.all(np.array(amplitude["sd_given_shape"]) > 0)
    amplitude["sd"] = (1000 * np.array(amplitude["sd"])).tolist()
    vague = rigs / "a" / "vague.yaml"
    vague.write_text(yaml.safe_dump(content), encoding="utf-8")
    run, model = rigs / "b" / "run-6", rigs / "b" / "model.yaml"
    known, same = (
        lab.improve(run, model, "creep", prior=prior) for prior in (rigs / "a" / "fitted.yaml", vague)
    )
    assert amplitudes(same.model) == pytest.approx(amplitudes(known.model), rel=1e-9)


def test_runs_are_pooled(rigs: Path) -> None:
    """Several runs count together; each one's own values and those drawn towards the common mean are told."""
    runs = [rigs / "b" / "run-6", rigs / "b" / "run-20"]
    both = lab.improve(runs, rigs / "b" / "model.yaml", "creep", prior=rigs / "a" / "fitted.yaml")
    told = both.summary["prior"]
    own, shrunk = np.array(told["runs"]), np.array(told["shrunk"])
    assert own.shape == shrunk.shape == (2, 4)
    value = np.array(told["value"])
    assert (np.abs(shrunk - value).sum(axis=0) <= np.abs(own - value).sum(axis=0) + 1e-6).all()
    assert both.model.file.fitted_until is not None


def test_a_prior_that_the_runs_contradict_is_refused(rigs: Path) -> None:
    """One line says by how much, of which value, here and there."""
    with pytest.raises(
        LabrigError, match=r"contradict the prior \(z = \d+\.\d, at most 3\): creep: amplitude of"
    ):
        lab.improve(
            rigs / "c" / "run-12", rigs / "c" / "model.yaml", "creep", prior=rigs / "a" / "fitted.yaml"
        )


def test_several_priors_say_how_much_places_differ(rigs: Path, tmp_path: Path) -> None:
    """From three models on, their own scatter counts, and no share has to be stated."""
    from labrig.model import read_model_file, write_model_file

    file = read_model_file(rigs / "a" / "fitted.yaml")
    priors = []
    for factor in (0.9, 1.1, 1.4):
        copy = file.model_copy(deep=True)
        value = copy.effects[0].parameters["amplitude"]
        value.value = [factor * each for each in value.value]  # type: ignore[union-attr]
        path = rigs / "a" / f"{factor}.yaml"
        write_model_file(copy, path)
        priors.append(path)
    runs, model = rigs / "b" / "run-6", rigs / "b" / "model.yaml"
    tables = [lab.improve(runs, model, "creep", prior=priors, spread=s).prior for s in (0.0, 5.0)]
    assert np.allclose(tables[0], tables[1])
    spread = tables[0]["prior_sd"] / tables[0]["prior"]
    assert spread.between(0.3, 0.8).all()


def test_chambers_of_another_name_get_what_chambers_usually_have(rigs: Path, tmp_path: Path) -> None:
    """A rig with other chambers is as uncertain of each as the chambers of the first one differ."""
    own = make_rig(tmp_path, "other", 1.0, ("left", "right", "top", "bottom"))
    lab.run("capture", own / "rig.yaml", out=own / "run", captures=8)
    prior = rigs / "a" / "fitted.yaml"
    both = lab.improve(own / "run", own / "model.yaml", "creep", prior=prior, spread=0.0)
    there = amplitudes(lab.Model.load(prior))
    assert np.allclose(both.prior["prior"], there.mean())
    assert (both.prior["prior_sd"] > there.std()).all()
    assert both.model.file.effects[0].parameters["amplitude"].per == ["left", "right", "top", "bottom"]


def test_the_new_model_predicts_and_is_kept(rigs: Path, tmp_path: Path) -> None:
    """Saved and loaded, it has the error on a run that it was not fitted to about as low as on its own."""
    prior = rigs / "a" / "fitted.yaml"
    both = lab.improve(rigs / "b" / "run-6", rigs / "b" / "model.yaml", "creep", prior=prior)
    path = rigs / "b" / "carried.yaml"
    both.model.save(path)
    fresh = lab.compare(rigs / "b" / "run-20", path).error["model"]
    before = lab.compare(rigs / "b" / "run-20", rigs / "b" / "model.yaml").error["model"]
    assert fresh < 0.3 * before
    assert both.save(tmp_path / "out").is_file()
    assert both.plot().data


def test_the_command(rigs: Path, labrig: Typed, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """labrig improve --prior writes the model and says where the prior came from; wrong words are one line."""
    monkeypatch.chdir(tmp_path)
    words = ("improve", rigs / "b" / "run-6", "--model", rigs / "b" / "model.yaml", "--add", "creep", "-o")
    code, out, err = labrig(*words, "new.yaml", "--prior", rigs / "a" / "fitted.yaml")
    assert (code, err) == (0, "")
    assert "prior: fitted.yaml; the runs are" in out
    assert Path("new.yaml").is_file()
    for more, said in (
        (("--prior", rigs / "a" / "model.yaml"), "model.yaml: has no creep"),
        (("--spread", 0.2), "--prior"),
        (("--prior", rigs / "a" / "fitted.yaml", "--spread", -1), "spread -1"),
        (("--prior", rigs / "a" / "nothing.yaml"), "nothing.yaml"),
    ):
        code, out, err = labrig(*words, "other.yaml", *more)
        assert code != 0
        assert said in err
        assert err.count("\n") == 1
    assert not Path("other.yaml").exists()


def test_what_belongs_to_one_place_is_not_carried(rigs: Path) -> None:
    """A marker that slipped there and then says nothing of here."""
    with pytest.raises(LabrigError, match="marker_slip can't be carried over"):
        lab.improve(
            rigs / "b" / "run-6", rigs / "b" / "model.yaml", "marker_slip", prior=rigs / "a" / "fitted.yaml"
        )


def test_weights_of_a_family_are_not_carried(rigs: Path, tmp_path: Path) -> None:
    """A prior in which an effect is no formula is refused in one line, and nothing is written."""
    content = yaml.safe_load((rigs / "a" / "fitted.yaml").read_text(encoding="utf-8"))
    weights = {"weights": {"value": [0.1, 0.2], "sd": [0.1, 0.1], "per": ["lag 5.0", "lag 50.0"]}}
    content["effects"][0] |= {"form": "family, retarded", "parameters": weights}
    (rigs / "a" / "weighted.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    with pytest.raises(LabrigError, match="creep is there as the weights of a family"):
        lab.improve(
            rigs / "b" / "run-6", rigs / "b" / "model.yaml", "creep", prior=rigs / "a" / "weighted.yaml"
        )
