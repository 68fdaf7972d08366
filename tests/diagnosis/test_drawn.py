"""Campaigns of the blind benchmark's plants, drawn by class: one for each verdict, with large effects."""

from dataclasses import replace
from pathlib import Path

import pytest

from labrig.bench import draw, is_right, write_model
from labrig.bench._classes import CLASSES
from labrig.diagnosis import diagnose
from labrig.model import Model


@pytest.mark.parametrize(
    ("name", "seed", "verdict"),
    [
        ("null", 2, "nothing_missing"),
        ("single", 3, "identified"),
        ("pair", 1, "multiple"),
        ("confounded", 3, "confounded"),
        ("outside", 3, "unknown"),
    ],
)
def test_the_verdict_is_right(
    name: str, seed: int, verdict: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Verdict and names are those of the truth, which neither base nor library has been told."""
    monkeypatch.setitem(CLASSES, name, replace(CLASSES[name], floors=(3.5, 4.0)))
    campaign = draw(name, seed, captures=40)
    truth = campaign.truth
    model = Model.load(write_model(campaign, tmp_path))
    summary = diagnose(campaign.dataset, model, without=truth["without"]).summary
    assert truth["verdict"] == verdict
    assert is_right(truth, summary), (
        truth["laws"],
        summary["verdict"],
        summary["effects"],
        summary["rivals"],
    )
    if verdict in ("identified", "multiple"):
        assert 0.8 < summary["drop"] <= 1
    # of a row, what bends at a delay among it, and of a capture's mean
    assert 0.6 < summary["error"]["floor"] / truth["floor"] < 2.5
