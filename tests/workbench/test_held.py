"""What the worker holds open: it is read again when anything has changed that it was made of."""

import os
from pathlib import Path

import pytest

from labrig.workbench._held import stamp


@pytest.mark.parametrize("where", ["beside the model", "where labrig was called"])
def test_an_own_effect_that_was_edited_is_another(tmp_path: Path, monkeypatch, where: str) -> None:
    """Whoever edits an effect of their own sees what it does now, and not the fits of the one before."""
    own = tmp_path / ("models" if where == "beside the model" else "here") / "effects" / "humidity.py"
    own.parent.mkdir(parents=True)
    own.write_text("x = 1")
    for folder in ("run", "models", "here"):
        (tmp_path / folder).mkdir(exist_ok=True)
    model = tmp_path / "models" / "model.yaml"
    model.write_text("base: {}")
    monkeypatch.chdir(tmp_path / "here")
    key = (str(tmp_path / "run"), str(model))
    before = stamp(key)
    assert stamp(key) == before
    own.write_text("x = 2")
    os.utime(own, ns=(1, 1))
    assert stamp(key) != before
