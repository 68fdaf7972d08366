"""What `labrig rig check` does with chambers: fill each in turn, and hold what came of it against the rig file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from labrig.cli._complaints import StoppedError
from labrig.rig import (
    VENTED,
    Fillings,
    RigConfig,
    chamber_findings,
    clock_of,
    connect,
    fill_in_turn,
    swapped_markers,
)
from labrig_drivers import DeviceError, Finding


def check_chambers(config: RigConfig, model: Path | None, tell: Callable[[str], None]) -> list[Finding]:
    """Fill each chamber alone, under the guard, and vent; a device that fails becomes a finding."""
    clock = clock_of(config)
    if config.scanner is not None:
        config = config.model_copy(update={"scanner": None})
    try:
        with connect(config, clock) as rig:
            fillings = fill_in_turn(rig, tell)
            config = rig.config
    except KeyboardInterrupt as error:
        vented = "; the chambers are vented" if VENTED in getattr(error, "__notes__", ()) else ""
        raise StoppedError(f"stopped by Ctrl-C{vented}") from None
    except DeviceError as error:
        return [Finding("pressure", "filling", "bad", str(error).removeprefix("pressure: "))]
    findings = chamber_findings(config, fillings)
    if model is not None:
        findings += swapped_markers(config, fillings, _expected_mm(config, model, fillings))
    return findings


def _expected_mm(config: RigConfig, model: Path, fillings: Fillings) -> np.ndarray:
    """How far a model lets the markers move when each chamber is filled alone, (C, M, 3)."""
    from labrig.view import live_predict

    predict = live_predict(model, config.markers)
    chambers = len(config.chambers)
    levels = [filling.level_kpa for filling in fillings.of]
    rest_mm = predict(np.zeros(chambers))
    return np.array([predict(np.eye(chambers)[n] * level) - rest_mm for n, level in enumerate(levels)])
