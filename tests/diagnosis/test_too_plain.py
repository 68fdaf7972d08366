"""A straight line that is fitted to a rig which is curved: which polynomial would do is said."""

from pathlib import Path

import numpy as np
import pytest

from labrig.diagnosis import diagnose
from labrig.model import Model
from tests.conftest import HIGH_KPA, Lab
from tests.laws import power_law


def static(folder: Path, degree: int) -> Model:
    """A polynomial base."""
    (folder / "model.yaml").write_text(f"base: {{kind: static, degree: {degree}}}\n", encoding="utf-8")
    return Model.load(folder / "model.yaml")


def bent(lab: Lab, u: np.ndarray) -> np.ndarray:
    """A finger that bends in an arc, by the mean pressure: coordinates (n, T, K) of markers along it, mm."""
    angle = 2.2 * u.mean(axis=2)[..., None] / HIGH_KPA
    along = 60.0 * np.arange(1, lab.markers + 1) / lab.markers
    share = along / 60.0
    radius = along / np.maximum(angle * share, 1e-9)
    x, z = radius * (1 - np.cos(angle * share)), radius * np.sin(angle * share)
    return np.stack([x, 0 * x, z], axis=3).reshape(*u.shape[:2], -1)


def said(found) -> list[str]:
    """What is said of the base's degree."""
    return [line for line in found["warnings"] if line.startswith("a polynomial of degree")]


def test_a_line_for_a_curve_is_too_plain(make_lab, tmp_path, few_effects) -> None:
    """A finger bends in an arc, and its wall creeps: a line is said to be too plain, and which degree would do; of a
    base that has it creep is sure, and nothing more is said.
    """
    few_effects("creep", "delay", "leak", "hysteresis", "contact")
    lab = make_lab(chambers=2, captures=60)
    run = lab.dataset(bent(lab, power_law(lab)) + lab.noise())
    found = diagnose(run, static(tmp_path, 1)).summary
    (line,) = said(found)
    degree = int(line.split("say degree: ")[1][0])
    assert degree in (2, 3)
    assert f"{found['error']['base']:.2g} mm: it is too plain" in line
    again = diagnose(run, static(tmp_path, degree)).summary
    assert again["effects"] == ["creep"]
    assert said(again) == []


@pytest.mark.parametrize("straight", [True, False])
def test_a_line_for_a_line_is_not(make_lab, tmp_path, few_effects, straight: bool) -> None:
    """Where the rig is straight nothing is said of its degree, whatever creeps, nor of too few captures for another."""
    few_effects("creep", "delay", "leak")
    lab = make_lab(chambers=2, captures=60 if straight else 12, bent=0.0)
    law = power_law(lab)
    values = lab.predict(law) if straight else bent(lab, law)
    found = diagnose(lab.dataset(values + lab.noise()), static(tmp_path, 1)).summary
    assert found["verdict"] not in {"nothing_missing", "underpowered"}
    assert said(found) == []


def test_a_degree_that_is_no_better_is_not_said(make_lab, tmp_path, few_effects) -> None:
    """A straight rig that creeps, and a library without creep: unknown, and no polynomial is the better for it."""
    few_effects("leak", "regulator")
    lab = make_lab(chambers=2, captures=60, bent=0.0)
    found = diagnose(lab.dataset(lab.predict(power_law(lab)) + lab.noise()), static(tmp_path, 1)).summary
    assert found["verdict"] == "unknown"
    assert said(found) == []
