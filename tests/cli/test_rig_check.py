"""`labrig rig check` on a rig that is simulated here, as a person runs it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from labrig.cli import main


def _check(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[object, str, str]:
    with pytest.raises(SystemExit) as ended:
        main(["rig", "check", "rig.yaml", "--read-s", "0.2", *map(str, arguments)])
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def test_every_chamber_is_filled_and_judged(
    lab: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A rig that is well ends with code 0; each chamber has its line, and what is filled is said as it happens."""
    lab("nothing")
    code, out, err = _check(capsys)
    assert code == 0
    for name in ("c1", "c2", "c3", "c4"):
        assert f"labrig: filling {name} to 30 kPa\n" in err
    assert out.count("and keeps it") == 4


def test_a_leak_that_is_hidden_in_the_simulated_rig_is_found(
    lab: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """Its formula is the simulator's; the check says that chambers lose pressure, and how fast."""
    lab("leak")
    code, _, err = _check(capsys)
    assert code == 3
    assert "leaks: it loses" in err


def test_without_filling_nothing_moves(
    lab: Callable[..., Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """--still reads and vents only."""
    lab("nothing")

    def moved(*_: Any) -> None:
        raise AssertionError("a set-point was commanded")

    monkeypatch.setattr("labrig_drivers.simulated.SimulatedPressure.set", moved)
    code, out, err = _check(capsys, "--still")
    assert (code, err) == (0, "")
    assert "confirmed in" in out


def test_tubes_that_are_swapped_show_in_the_markers(
    lab: Callable[..., Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With sensors on the board the pressures are as asked for; against a model the markers tell."""
    from labrig_drivers.simulated._plant import SimulatedPlant

    lab("nothing")
    code, out, _ = _check(capsys, "--model", "model.yaml")
    assert code == 0
    assert "mocap tubes well" in " ".join(out.replace("│", " ").split())
    engine_state = SimulatedPlant._moments

    def swapped(self: Any, time_s: Any) -> Any:
        since_s, deflection = engine_state(self, time_s)
        return since_s, deflection[:, [0, 2, 1, 3]]

    monkeypatch.setattr(SimulatedPlant, "_moments", swapped)
    code, _, err = _check(capsys, "--model", "model.yaml")
    assert code == 3
    assert "c2: asking for c2 moves the markers as filling c3 would: are the tubes swapped?" in err
    assert "c3: asking for c3 moves the markers as filling c2 would: are the tubes swapped?" in err
