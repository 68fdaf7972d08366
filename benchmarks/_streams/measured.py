"""Streams that were measured and published: excerpts of public sets, one input and one output each.

The numbers lie in `measured/`; its README says who measured them, when, under which licence, which stretch was copied
and how the copy was checked. `right` holds the names that the published description of the rig supports.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks._streams.sets import Record, StreamSet

FOLDER = Path(__file__).parent / "measured"
MM_PER_INCH = 25.4
KN_PER_KIP = 4.4482216


def stretch(
    name: str, given: str, output: str, given_scale: float = 1.0, output_scale: float = 1.0
) -> Callable[[np.random.Generator, float], Record]:
    """A maker of the record in `measured/<name>.csv`, from its columns; it draws nothing and ignores its length."""

    def make(_random: np.random.Generator, _seconds: float) -> Record:
        table = np.genfromtxt(FOLDER / f"{name}.csv", delimiter=",", names=True)
        time_s = table["time_s"] - table["time_s"][0]
        return Record(time_s, given_scale * table[given], output_scale * table[output])

    return make


_KNOWN = (
    StreamSet(
        "cylinder",
        "Zillen et al. 2021",
        stretch("cylinder", "position_mm", "force_n"),
        ("position", "mm"),
        ("force", "N"),
        0.0,
        "base: {kind: static, degree: 1}\n",
        frozenset({"hysteresis", "friction"}),
    ),
    StreamSet(
        "vhb4910",
        "Zhao, GitHub",
        stretch("vhb4910", "extension_mm", "force_n"),
        ("extension", "mm"),
        ("force", "N"),
        0.0,
        "base: {kind: static, degree: 3}\n",
        frozenset({"creep"}),
    ),
    StreamSet(
        "tanks",
        "Schoukens et al. 2016",
        stretch("tanks", "pump_v", "level_v"),
        ("pump", "V"),
        ("level", "V"),
        0.0,
        "base: {kind: static, degree: 2}\n",
        frozenset({"creep", "delay"}),
    ),
    StreamSet(
        "band_brake",
        "Coble et al. 2022",
        stretch("band_brake", "displacement_in", "force_kip", MM_PER_INCH, KN_PER_KIP),
        ("displacement", "mm"),
        ("force", "kN"),
        0.0,
        "base: {kind: static, degree: 1}\n",
        frozenset({"hysteresis", "friction"}),
    ),
)
MEASURED = tuple(one for one in _KNOWN if (FOLDER / f"{one.name}.csv").is_file())
"""The sets whose numbers are here."""
