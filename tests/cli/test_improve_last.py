"""A new model appears last, when everything else of `labrig improve` is written."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import labrig
from labrig.cli._diagnosis import improve


def test_an_interrupted_improve_has_no_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C while the report is written leaves no new model behind: "interrupted" means that there is none."""
    output = tmp_path / "b.yaml"

    def interrupted(folder: Path) -> Path:
        raise KeyboardInterrupt

    model = SimpleNamespace(save=lambda path: path.write_text("base: {}"))
    better: Any = SimpleNamespace(model=model, save=interrupted, summary={})
    monkeypatch.setattr(labrig, "improve", lambda *_, **__: better, raising=False)
    with pytest.raises(KeyboardInterrupt):
        improve([tmp_path / "run"], tmp_path / "model.yaml", output, ["creep"], out=tmp_path / "out")
    assert not output.exists()
