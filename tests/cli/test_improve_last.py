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


def test_a_new_model_is_said_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ctrl-C while figures are printed comes after the line that says where the new model is."""
    output = tmp_path / "b.yaml"

    def interrupted(*_: Any) -> None:
        raise KeyboardInterrupt

    model = SimpleNamespace(save=lambda path: path.write_text("base: {}"))
    better: Any = SimpleNamespace(model=model, save=lambda folder: folder / "report.html", summary={})
    monkeypatch.setattr(labrig, "improve", lambda *_, **__: better, raising=False)
    monkeypatch.setattr("labrig.cli._diagnosis._table", interrupted)
    with pytest.raises(KeyboardInterrupt):
        improve([tmp_path / "run"], tmp_path / "model.yaml", output, ["creep"], out=tmp_path / "out")
    assert output.exists()
    assert capsys.readouterr().out.replace("\n", "") == f"new model: {output}"
