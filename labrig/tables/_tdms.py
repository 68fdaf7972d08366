"""LabVIEW's TDMS files: groups of channels, which may be waveforms with a clock of their own."""

import logging
from pathlib import Path
from typing import Any

import numpy as np

from labrig.tables._names import unit_of

_UNITS = ("unit_string", "NI_UnitDescription", "Unit", "unit")
"""Properties in which a channel's unit stands: LabVIEW's, and those that people write."""


def arrays_of_tdms(path: Path) -> dict[str, np.ndarray]:
    """The channels of a file by ``GROUP/NAME [UNIT]``; a group of waveforms has their clock as ``GROUP/time [s]``."""
    from nptdms import TdmsFile
    from nptdms.log import log_manager

    log_manager.set_level(logging.ERROR)  # a file that was cut off is read as far as it goes
    out: dict[str, np.ndarray] = {}
    with TdmsFile.open(path) as file:
        for group in file.groups():
            level = group.name.replace("/", "_")
            channels = [c for c in group.channels() if len(c) and c.dtype.kind in "fiubMUO"]
            step_s = {float(c.properties["wf_increment"]) for c in channels if "wf_increment" in c.properties}
            if len(step_s) == 1 and next(iter(step_s)) > 0 and len({len(c) for c in channels}) == 1:
                begin_s = float(channels[0].properties.get("wf_start_offset", 0.0))
                out[f"{level}/time [s]"] = begin_s + step_s.pop() * np.arange(len(channels[0]))
            for channel in channels:
                out[f"{level}/{_called(channel)}"] = np.asarray(channel[:])
    return out


def _called(channel: Any) -> str:
    """A channel's name, with its unit behind it where its properties say one."""
    name = str(channel.name).replace("/", "_")
    said = next((str(channel.properties[key]) for key in _UNITS if key in channel.properties), "")
    return f"{name} [{said}]" if unit_of(said) not in {None, "1"} else name
