"""Files of named arrays: MAT (v5 and v7.3), HDF5, NPZ and NPY, and LabVIEW's TDMS.

Arrays of one length stand side by side as the columns of a table; what has another length is another part.
"""

import re
import zipfile
from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from itertools import product
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from labrig._errors import LabrigError
from labrig.tables._hdf import arrays_of_hdf
from labrig.tables._mapping import Format
from labrig.tables._table import Table

_WIDEST = 512
"""Columns of one array, at most: of a depth map more are thinned out."""
_FEW = 4
"""Numbers that belong together, as coordinates do, along an axis that is never thinned out."""
Arrays = dict[str, np.ndarray]


def groups(path: Path) -> dict[str, int]:
    """The parts of a file: groups (or structs) of arrays of one length, by name; "" is the file's own level."""
    return {name: part.rows for name, part in _grouped(_arrays(path)[0]).items()}


def groups_of_one_kind(path: Path) -> dict[str, int]:
    """The groups (or structs) of a file that hold arrays of the same names, with the rows of each, in its order."""
    return {name: part.rows for name, part in _of_one_kind(_arrays(path)[0]).items()}


def read_arrays(path: Path, how: Format) -> Table:
    """Read the part that `how` names, else the one with most columns; raises `LabrigError` where there is none."""
    import pandas as pd

    arrays, said = _arrays(path)
    parts = _grouped(arrays)
    if how.part is not None and how.part not in parts:
        parts |= _of_one_kind(arrays)
    if not parts:
        raise LabrigError(f"{path}: holds no arrays of numbers that could be columns")
    if how.part is not None and how.part not in parts:
        raise LabrigError(f"{path}: has no part {how.part!r}; it has {', '.join(repr(p) for p in parts)}")
    name = how.part if how.part is not None else max(parts, key=lambda p: parts[p].size)
    part = parts[name]
    columns: dict[str, Any] = {}
    units: dict[str, str] = {}
    notes: list[str] = []
    for key in part.members:
        every, left = _every(_axes(arrays[key], part.rows)[1:])
        if every > 1:
            wide = arrays[key].size // part.rows
            notes.append(
                f"array {key!r} has {wide} numbers a row: one in {every} along each axis is read, {left} in all"
            )
        own = dict(_columns(key[len(part.level) + 1 :] if part.level else key, arrays[key], part.rows))
        columns |= own
        units |= dict.fromkeys(own, said[key]) if key in said else {}
    frame = pd.DataFrame(columns).iloc[how.skip_rows :]
    return Table(path, frame, how.skip_rows + 1, said=tuple(notes), units=units)


class _Part(NamedTuple):
    """Arrays of one length, whose names begin with their level's."""

    level: str
    rows: int
    members: list[str]

    @property
    def size(self) -> int:
        """How many numbers it has, at least."""
        return self.rows * len(self.members)


def _grouped(arrays: Arrays) -> dict[str, _Part]:
    """Arrays of the same level and length, by the level's name; a level with several lengths is told apart by them.

    All that share one length over all levels are one part, "".
    """
    lines = {a.size for a in arrays.values() if _length(a) == a.size}
    lengths = {key: _length(a, lines) for key, a in arrays.items()}
    lengths = {key: n for key, n in lengths.items() if n >= 2}
    if len(set(lengths.values())) == 1:
        return {"": _Part("", next(iter(lengths.values())), list(lengths))}
    found: dict[tuple[str, int], list[str]] = defaultdict(list)
    for key, n in lengths.items():
        found[key.rpartition("/")[0], n].append(key)
    out: dict[str, _Part] = {}
    for (level, n), members in sorted(found.items(), key=lambda item: -len(item[1])):
        out[level if level not in out else f"{level}#{n}"] = _Part(level, n, members)
    return out


def _of_one_kind(arrays: Arrays) -> dict[str, _Part]:
    """Groups whose arrays are called alike, the outermost that are, by their names; each has arrays of one length.

    None where only one is called so, or has arrays of several lengths.
    """
    lines = {a.size for a in arrays.values() if _length(a) == a.size}
    rows = {tuple(key.split("/")): n for key, a in arrays.items() if (n := _length(a, lines)) >= 2}
    for depth in range(1, max(map(len, rows), default=0)):
        inner: dict[str, dict[str, int]] = defaultdict(dict)
        for key, n in rows.items():
            if len(key) > depth:
                inner["/".join(key[:depth])]["/".join(key[depth:])] = n
        alike: dict[frozenset[str], list[str]] = defaultdict(list)
        for level, own in inner.items():
            if len(own) > 1:
                alike[frozenset(own)].append(level)
        levels = _by_number(max(alike.values(), key=len, default=[]))
        if len(levels) > 1:
            even = all(len(set(inner[level].values())) == 1 for level in levels)
            return {level: _part_of(level, inner[level]) for level in levels} if even else {}
    return {}


def _by_number(names: list[str]) -> list[str]:
    """Names that differ by a number only by that number (HDF5 has trial_10 before trial_2); others as they are."""
    if len({re.sub(r"\d+", "0", name) for name in names}) > 1:
        return names
    return sorted(names, key=lambda name: [int(n) for n in re.findall(r"\d+", name)])


def _part_of(level: str, own: dict[str, int]) -> _Part:
    return _Part(level, next(iter(own.values())), [f"{level}/{name}" for name in own])


def _length(a: np.ndarray, lines: Collection[int] = ()) -> int:
    """How many rows an array has: as many as one of the file's `lines` (lengths of arrays with one axis), else all that
    its longest axis has: 20 times of 34 markers are 20 rows.
    """
    shape = [s for s in a.shape if s > 1]
    return max([s for s in shape if s in lines] or shape, default=0)


def _columns(name: str, a: np.ndarray, n: int) -> Iterator[tuple[str, Any]]:
    """An array with n rows along one of its axes, as columns: NAME, or NAME.i, NAME.i.j."""
    if a.ndim > 1:
        a = a.reshape([s for s in a.shape if s > 1])
        a = np.moveaxis(a, a.shape.index(n), 0)
    if a.ndim == 1:
        yield name.replace("/", "."), a
        return
    every, _ = _every(a.shape[1:])
    for place in product(*(range(0, s, every if s > _FEW else 1) for s in a.shape[1:])):
        yield ".".join([name.replace("/", "."), *map(str, place)]), a[(slice(None), *place)]


def _axes(a: np.ndarray, n: int) -> list[int]:
    """The lengths of an array's axes, that of its n rows first, without those of one."""
    lengths = [s for s in a.shape if s > 1]
    lengths.remove(n)
    return [n, *lengths]


def _every(axes: Sequence[int]) -> tuple[int, int]:
    """Which number along each long axis is read, so that they are no more than `_WIDEST`, and how many these are."""
    every = 1
    while (left := prod(-(-s // every) if s > _FEW else s for s in axes)) > _WIDEST and every < max(axes):
        every += 1
    return every, left


def _arrays(path: Path) -> tuple[Arrays, dict[str, str]]:
    """Every array of numbers or text in a file, by its path within it; and the units of those that say one."""
    with path.open("rb") as file:
        head = file.read(16)
    if head.startswith((b"\x89HDF", b"MATLAB 7.3")):
        return arrays_of_hdf(path)
    return _without_units(path, head), {}


def _without_units(path: Path, head: bytes) -> Arrays:
    if head.startswith(b"\x93NUMPY"):
        loaded = np.load(path, allow_pickle=False)
        if loaded.dtype.names:
            return {name: loaded[name] for name in loaded.dtype.names}
        return {path.stem: loaded} if loaded.dtype.kind in "fiub" else {}
    if head.startswith(b"PK"):
        if not zipfile.is_zipfile(path):
            raise LabrigError(f"{path}: is cut off: the end of the archive is missing")
        with np.load(path, allow_pickle=False) as loaded:
            out: Arrays = {}
            for name in loaded.files:
                try:
                    out[name] = loaded[name]
                except ValueError:  # pickled objects: nothing that may be run
                    continue
            return {name: a for name, a in out.items() if a.dtype.kind in "fiubUM"}
    if head.startswith(b"TDSm"):
        from labrig.tables._tdms import arrays_of_tdms

        return arrays_of_tdms(path)
    if head.startswith(b"CDF"):
        raise LabrigError(f"{path}: is NetCDF of version 3; save it as NetCDF-4 or CSV")
    return _mat(path)


def _mat(path: Path) -> Arrays:
    from scipy.io import loadmat

    with np.errstate(all="ignore"):
        content = loadmat(str(path), squeeze_me=True, struct_as_record=False)
    out: Arrays = {}

    def walk(name: str, value: Any, depth: int) -> None:
        if hasattr(value, "_fieldnames"):
            if depth < 6:
                for inner in value._fieldnames:
                    walk(f"{name}/{inner}", getattr(value, inner), depth + 1)
        elif isinstance(value, np.ndarray):
            if (value.dtype.kind in "fiubU" and value.size) or (
                value.dtype == object and value.ndim == 1 and all(isinstance(v, str) for v in value)
            ):
                out[name] = value
            elif value.dtype == object and depth < 6:
                for i, inner in enumerate(value.ravel()[:64]):
                    walk(f"{name}/{i}", inner, depth + 1)

    for name, value in content.items():
        if not name.startswith("__"):
            walk(name, value, 0)
    if not out:
        raise LabrigError(
            f"{path}: holds no arrays of numbers; MATLAB's tables and timeseries can't be read: "
            "save their columns as arrays or with writetable"
        )
    return out
