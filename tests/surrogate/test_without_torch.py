"""labrig's own methods run without torch; what needs it says so in one line."""

import sys

import pytest

from labrig import LabrigError
from labrig.surrogate import save_model, train_forward


def test_default_needs_no_torch(data, monkeypatch, tmp_path):
    """The default forward model is trained, saved and evaluated where torch cannot be imported."""
    monkeypatch.setitem(sys.modules, "torch", None)
    model = train_forward(data, samples=6).model
    save_model(model, tmp_path / "forward.pt")
    assert model.points([30.0] * 3, [[0.5, 0.5]]).shape == (1, 1, 3)


def test_networks_say_what_they_need(data, monkeypatch):
    """Without torch a network's training says what installs it: from the checkout, for labrig is on no index."""
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(LabrigError) as caught:
        train_forward(data, "paper")
    assert str(caught.value) == (
        "training a network needs packages that are not installed: go to the folder of labrig's pyproject.toml "
        "and type: pip install '.[learn]'"
    )
