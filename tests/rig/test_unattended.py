"""A run is left unattended only where something vents the chambers when this computer is gone."""

from pathlib import Path
from typing import Any

import pytest

from labrig import LabrigError
from labrig.rig import Rig, check_unattended, parse_rig
from labrig_drivers import Identity


def _rig(kind: str = "openpneu", details: dict[str, str] | None = None, **safety: Any) -> Rig:
    content = {
        "name": "bench",
        "chambers": [{"name": "c1", "max_kpa": 60}],
        "pressure": {"kind": kind},
        "simulated": {"surface": "mannequin"},
        "safety": safety,
    }
    config = parse_rig(content, "rig.yaml", Path())
    identity = {"pressure": Identity("pressure", kind, "the board", details or {})}
    return Rig(config, None, None, identity=identity)  # type: ignore[arg-type]


def test_a_board_without_a_watchdog_is_refused() -> None:
    """One line says why, and what to write into the rig file if something else vents."""
    with pytest.raises(LabrigError) as caught:
        check_unattended(_rig())
    assert str(caught.value) == (
        "rig bench is not left unattended: its pressure controller has no watchdog of its own, so nothing vents when "
        "this computer is gone; if something else does, say what in rig.yaml (safety: {vents_alone: ...})"
    )


@pytest.mark.parametrize(
    ("rig", "said"),
    [
        (_rig(details={"watchdog": "2 s"}), "the watchdog of the board, after 2 s"),
        (_rig(vents_alone="a relay on this computer's USB power"), "a relay on this computer's USB power"),
        (_rig("simulated"), "nothing is under pressure: the rig is simulated here"),
    ],
)
def test_what_vents_alone_is_said(rig: Rig, said: str) -> None:
    """A device's watchdog, an explicit word in rig.yaml, or a rig without air."""
    assert check_unattended(rig) == said
