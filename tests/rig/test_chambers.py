"""`labrig rig check` fills each chamber in turn and says which tube, sensor or chamber is not well."""

import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig.rig import (
    Filling,
    Fillings,
    Rig,
    RigConfig,
    chamber_findings,
    fill_in_turn,
    parse_rig,
    swapped_markers,
)
from labrig_drivers import DeviceError, PressureSample, SimulatedClock

sys.path.insert(0, str(Path(__file__).parent))
from pneumatics import Board, Faults

sys.path.pop(0)

CONFIG = parse_rig(
    {
        "name": "pneumatics",
        "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
        "markers": ["m1", "m2"],
        "pressure": {"kind": "python", "file": "none.py", "class": "None"},
        "mocap": {"kind": "python", "file": "none.py", "class": "None"},
    },
    "rig.yaml",
    Path(),
)


def _check(faults: Faults, config: RigConfig = CONFIG) -> dict[str, tuple[str, str]]:
    clock = SimulatedClock()
    board = Board("pressure", clock, config.channels, faults)
    fillings = fill_in_turn(Rig(config, clock, board))
    assert np.abs(board.air_kpa).max() < 1.0, "nothing is left under pressure"
    return {finding.what: (finding.state, finding.text) for finding in chamber_findings(config, fillings)}


def test_a_rig_that_is_well_is_said_to_be_well() -> None:
    """Four chambers, four lines that say that they are well, and what each read."""
    found = _check(Faults())
    assert list(found) == ["c1", "c2", "c3", "c4"]
    assert {state for state, _ in found.values()} == {"well"}
    assert found["c1"][1].startswith(("reads 30.0 kPa of 30 kPa", "reads 29.9 kPa of 30 kPa"))


@pytest.mark.parametrize(
    ("faults", "what", "state", "words"),
    [
        (Faults(tube={2: None}), "c3", "bad", "its tube is off"),
        (Faults(tube={0: 1, 1: 0}), "c1", "bad", "is swapped with c2: asking for one fills the other"),
        (Faults(tube={0: 1, 1: 0}), "c2", "bad", "is swapped with c1: asking for one fills the other"),
        (Faults(tube={3: 0, 0: None}), "c4", "bad", "asking for it fills c1: look where its tube goes"),
        (Faults(zero_kpa={1: 2.0}), "c2, zero", "bad", "reads 2.0 kPa when vented, the others 0.0 kPa"),
        (Faults(zero_kpa={1: -2.5}), "c2, zero", "bad", "its sensor's zero is off"),
        (Faults(scale={3: 0.6}), "c4", "bad", "its sensor's scale is wrong (it reads 0.60 of the pressure)"),
        (Faults(scale={3: 1.5}), "c4", "bad", "its sensor's scale is wrong (it reads 1.5"),
        (Faults(hole={0: 1.0}), "c1", "bad", "it leaks as fast as it is filled"),
        (Faults(hole={0: 0.0008}, shut_in=True), "c1", "bad", "leaks: it loses"),
        (Faults(joint=((1, 2),)), "c2", "look", "c3 ("),
        (Faults(volume={2: 8.0}), "c3", "look", "slower (another volume, a narrow tube"),
    ],
)
def test_each_fault_is_found_by_name(faults: Faults, what: str, state: str, words: str) -> None:
    """What was put in is said of the chamber that it was put into."""
    found = _check(faults)
    assert found[what][0] == state
    assert words in found[what][1], found[what][1]


@pytest.mark.parametrize("faults", [Faults(tube={2: None}), Faults(scale={3: 0.6}), Faults(hole={0: 1.0})])
def test_the_other_chambers_are_left_alone(faults: Faults) -> None:
    """A fault of one chamber is not said of another."""
    assert sum(state != "well" for state, _ in _check(faults).values()) == 1


@pytest.mark.parametrize(
    ("limits", "faults", "state", "words"),
    [
        ({"min_kpa": -60, "max_kpa": 1}, Faults(), "well", "reads -30.0 kPa of -30 kPa"),
        ({"min_kpa": -60, "max_kpa": 1}, Faults(tube={1: None}), "bad", "its tube is off"),
        ({"max_kpa": 0}, Faults(), "look", "cannot be filled alone: its limits are 0 to 0 kPa"),
        ({"max_kpa": 60, "slew_kpa_s": 3}, Faults(), "well", "reads 30.0 kPa of 30 kPa"),
    ],
)
def test_unusual_limits_are_looked_at_for_what_they_are(
    limits: dict[str, float], faults: Faults, state: str, words: str
) -> None:
    """A chamber of vacuum is filled to its vacuum, one that may not move is not filled, a slow one is not narrow."""
    chambers = [chamber.model_dump() for chamber in CONFIG.chambers]
    chambers[1] = {"name": "c2", **limits}
    content = {**CONFIG.to_dict(), "chambers": chambers}
    found = _check(faults, parse_rig(content, "rig.yaml", Path()))
    assert found["c2"][0] == state
    assert words in found["c2"][1]
    assert {found[name][0] for name in ("c1", "c3", "c4")} == {"well"}


def test_the_rate_of_a_leak_is_said() -> None:
    """The stated loss is what the hole lets out: 40 * hole * sqrt(p) kPa/s, here 10 kPa a minute."""
    state, text = _check(Faults(hole={0: 10 / 60 / 40 / np.sqrt(29.0)}, shut_in=True))["c1"]
    assert state == "bad"
    assert float(text.split("loses ")[1].split(" kPa")[0]) == pytest.approx(10.0, rel=0.15)


def test_tubes_that_are_swapped_behind_the_sensors_show_in_the_markers() -> None:
    """Every sensor reads what was asked for; the markers move as if another chamber were filled."""
    expected = np.zeros((4, 2, 3))
    expected[:, 0, 2] = [5.0, 1.0, -3.0, 2.0]
    expected[:, 1, 0] = [0.0, 4.0, 2.0, -2.0]
    moved = expected[[1, 0, 2, 3]] + 0.05
    fillings = Fillings(np.zeros(4), [Filling(n, 30.0, moved_mm=moved[n]) for n in range(4)])
    found = {finding.what: finding.text for finding in swapped_markers(CONFIG, fillings, expected)}
    assert found == {
        "c1": "asking for c1 moves the markers as filling c2 would: are the tubes swapped?",
        "c2": "asking for c2 moves the markers as filling c1 would: are the tubes swapped?",
    }
    right: Any = Fillings(np.zeros(4), [Filling(n, 30.0, moved_mm=expected[n] + 0.05) for n in range(4)])
    assert [finding.state for finding in swapped_markers(CONFIG, right, expected)] == ["well"]


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        (lambda board: [], "no measurement for"),
        (
            lambda board: [PressureSample(board.clock.now_s(), np.full(4, np.nan))],
            "no reading (NaN) from c1, c2, c3, c4",
        ),
        (lambda board: [PressureSample(board.clock.now_s(), np.full(4, -40.0))], "below its limit of 0 kPa"),
    ],
)
def test_filling_is_watched_as_a_run_is(bad: Any, said: str) -> None:
    """Readings that stay out, are none, or lie below the lowest limit end the check: nothing more is filled."""
    clock = SimulatedClock()
    board = Board("pressure", clock, CONFIG.channels, Faults())
    good = board.samples
    board.samples = lambda: bad(board) if board.target_kpa.any() else good()  # type: ignore[method-assign]
    with pytest.raises(DeviceError, match=re.escape(said)):
        fill_in_turn(Rig(CONFIG, clock, board))
    assert np.count_nonzero(board.target_kpa) == 1
