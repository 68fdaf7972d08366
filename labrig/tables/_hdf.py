"""HDF5, MATLAB's files from 7.3 on and NetCDF-4: arrays as their attributes say that they are written."""

from pathlib import Path
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.tables._spelling import unit_of
from labrig.tables._units import factor, like

_UNITS = ("units", "unit", "Units", "Unit")
_NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable"


def arrays_of_hdf(path: Path) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """The arrays of a file by their paths within it, and the units of those whose attributes say one.

    Packed numbers (`scale_factor`, `add_offset`, `_FillValue`) are unpacked, NaN where there is none; a time since a
    date is in s since 1970.
    """
    import h5py

    out: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith("#") or item.size is None:
            return
        if item.dtype.names:
            for field in item.dtype.names:
                if item.dtype[field].kind in "fiub":
                    out[f"{name}/{field}"] = np.asarray(item[field])
        elif item.dtype.kind in "fiub" and item.ndim >= 1 and item.size:
            if _is_text(item) or _said(item, "NAME").startswith(_NO_VARIABLE):
                return
            out[name], unit = _since_1970(
                _unpacked(item), next(filter(None, (_said(item, n) for n in _UNITS)), "")
            )
            if unit is not None:
                units[name] = unit
        elif h5py.check_string_dtype(item.dtype) is not None and item.ndim == 1:
            out[name] = np.array([str(v) for v in item.asstr()[()]], dtype=object)

    try:
        with h5py.File(path, "r") as file:
            file.visititems(visit)
    except OSError as error:
        raise LabrigError(f"{path}: can't be read as HDF5 ({str(error).splitlines()[0]})") from None
    return out, units


def _is_text(item: Any) -> bool:
    """MATLAB's 7.3 files mark what is a text, a flag or a cell."""
    return _said(item, "MATLAB_class") in {"char", "cell"}


def _said(item: Any, name: str) -> str:
    """An attribute that is a text; empty where there is none."""
    found = item.attrs.get(name, "")
    found = found.ravel()[0] if isinstance(found, np.ndarray) and found.size else found
    return found.decode("utf-8", "replace") if isinstance(found, bytes) else str(found)


def _unpacked(item: Any) -> np.ndarray:
    """The numbers of an array, by the conventions of NetCDF where it has their attributes."""
    values = np.asarray(item[()])
    gone = [np.ravel(item.attrs[name]) for name in ("_FillValue", "missing_value") if name in item.attrs]
    gone = [code for code in gone if code.dtype.kind in "fiu"]
    packed = {name: item.attrs[name] for name in ("scale_factor", "add_offset") if name in item.attrs}
    none = np.isin(values, np.concatenate(gone)) if gone else np.zeros(1, bool)
    if not packed and not none.any():
        return values
    out = np.where(none, np.nan, values.astype(float))
    return out * float(np.ravel(packed.get("scale_factor", 1.0))[0]) + float(
        np.ravel(packed.get("add_offset", 0.0))[0]
    )


def _since_1970(values: np.ndarray, said: str) -> tuple[np.ndarray, str | None]:
    """Numbers and their unit; those of a time since a date (`days since 2026-05-04`) in s since 1970."""
    import pandas as pd

    written, since, date = said.partition(" since ")
    unit = unit_of(written)
    if not since or unit is None or not like(unit, "s"):
        return values, unit
    begin = pd.to_datetime(date, errors="coerce", utc=True)
    if begin is pd.NaT:
        return values, unit
    return values * factor(unit, "s", "time") + begin.timestamp(), "s"
