"""`labrig import`: somebody's own table becomes a run."""

import time
import warnings
from collections.abc import Sequence
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.log._cut import cut
from labrig.log._part import Part, session_blocks
from labrig.log._repeat_labels import drop_counts
from labrig.log._segments import read_run_yaml
from labrig.tables import (
    Guess,
    Mapping,
    TableFile,
    check_clock,
    check_limits,
    check_spelt,
    check_values,
    factor,
    is_dated,
    opened,
    read_mapping,
)

if TYPE_CHECKING:
    from xarray import Dataset

_GAP_S = 1.0
_ERA_S = 1e8
"""Dates are later than this, s since 1970; times of day are not."""
_COUNTED_S = 946_684_800.0
"""The year 2000: a clock in s that is beyond counts from 1970."""
_STARTED = "started"
_OTHER_SCALE = 100.0
"""Ratio of sizes in two files from which on a person is asked whether both have one unit."""


def import_table(
    mapping_path: Path, output: Path, tables: Sequence[Path] = (), *, replace: bool = False
) -> "Dataset":
    """Make a run folder of foreign tables as a MAP.yaml says; returns what `open_run` gives of it.

    `tables` replaces the files that the mapping names (relative to the mapping's own folder). With `replace`, an
    imported run of that name is replaced once the new one is whole; notes and tags stay.

    Raises `LabrigError`, and leaves nothing behind, when a file, a column or a unit does not exist, when an
    actuation or a time is not a number, or when the output exists and is not to be replaced, or was recorded.
    """
    refuse(output, replace)
    mapping = read_mapping(mapping_path)
    files = mapping.files()
    if tables:
        known = {Path(f.file).name: f for f in reversed(files)}
        given = [known.get(t.name, TableFile(file=t.name)) for t in tables]
        files = [f.model_copy(update={"file": str(t.resolve())}) for f, t in zip(given, tables, strict=True)]
    if not files:
        raise LabrigError(f"{mapping_path}: table: name the file, or give it on the command line")
    return write_import(mapping, files, mapping_path, output, replace)


def refuse(output: Path, replace: bool) -> None:
    """Raise `LabrigError` where a run folder is there and is not to be replaced, or is no imported run."""
    if not output.exists():
        return
    imported = read_run_yaml(output).get("procedure") == "import"
    if not replace:
        how = ", or replace it (--replace, in Python replace=True)" if imported else ""
        raise LabrigError(f"{output} exists already; choose another name{how}")
    if not imported:
        raise LabrigError(f"{output} is no imported run, and is not replaced; choose another name")


def write_import(
    mapping: Mapping,
    files: Sequence[TableFile],
    mapping_path: Path,
    output: Path,
    replace: bool = False,
    guess: Guess | None = None,
) -> "Dataset":
    """Write the run that tables and a mapping describe, and open it; what a `guess` assumed is kept with it."""
    from labrig.log._open import open_run
    from labrig.log._table import write_dataset

    dataset = dataset_from(mapping, files, mapping_path)
    run_yaml: dict[str, Any] = {
        "procedure": "import",
        "mapping": mapping.model_dump(mode="json", exclude_none=True),
    }
    if began := dataset.attrs.pop(_STARTED, ""):
        run_yaml["started"] = began
    if guess is not None:
        run_yaml["guessed"] = True
        dataset.attrs["assumed"] = guess.assumed
    write_dataset(dataset, output, run_yaml=run_yaml, replace=replace)
    return open_run(output)


def dataset_from(mapping: Mapping, files: Sequence[TableFile], mapping_path: Path) -> "Dataset":
    """The campaign that tables and a mapping describe, laid out as docs/reference/dataset.md says.

    `attrs["import_remarks"]` says what the person who imports should know.
    """
    from labrig.log._assemble import gather

    _check_units(mapping, mapping_path)
    _refuse_twice(files, mapping_path)
    parts, remarks = _by_clock(mapping, [Part(mapping, file, mapping_path) for file in files])
    remarks += _plausible(mapping, parts, mapping_path)
    values, turns = opened(
        [o.name for o in parts[0].observables],
        [o.unit for o in parts[0].observables],
        np.concatenate([part.values for part in parts]),
    )
    remarks += turns
    for part, own in zip(parts, np.split(values, np.cumsum([part.n for part in parts])[:-1]), strict=True):
        part.values = own
    for part in parts:
        cut(part)
        remarks += part.remarks
    began = _began(mapping, parts)
    _order_in_time(parts)
    dataset = gather(mapping, parts)
    if began:
        dataset.attrs[_STARTED] = began
    if mapping.repeat is not None:
        remarks += drop_counts(dataset, str(mapping.repeat.column))
    dataset.attrs["import_remarks"] = list(dict.fromkeys(remarks))  # sheets of one file say the same
    if all(part.counts_rows for part in parts):
        dataset.attrs["clock"] = "rows"
    return dataset


def _refuse_twice(files: Sequence[TableFile], mapping_path: Path) -> None:
    """Raise `LabrigError` where a file is named twice; only what was commanded (`events`) may tell its parts apart."""
    seen: set[tuple[Path, str | None]] = set()
    for file in files:
        own = (mapping_path.parent / file.file).resolve(), file.part
        if own in seen and not file.events:
            raise LabrigError(
                f"{file.file} is named twice: the same measurements would count as if they had been repeated"
            )
        seen.add(own)


def _check_units(mapping: Mapping, path: Path) -> None:
    for what, entries in (
        ("actuation", mapping.actuation),
        ("measured", mapping.measured),
        ("observables", mapping.observables),
        ("covariates", mapping.covariates),
    ):
        for entry in entries:
            gauge = entry.offset if what in ("actuation", "measured") else None
            check_spelt(entry.unit, f"{path}: {what} {entry.name!r}", gauge=gauge)
    clocks = [(f"join {j.name!r}: time", j.time) for j in mapping.join]
    for what, entry in (("time", mapping.time), *clocks):
        if entry is not None:
            check_clock(entry, f"{path}: {what}")
    if mapping.hold is not None:
        factor(mapping.hold.unit, "s", f"{path}: hold")


def _plausible(mapping: Mapping, parts: Sequence[Part], path: Path) -> list[str]:
    """What is unusual about the numbers for their units; raises `LabrigError` for what cannot be."""
    where = str(path)
    said = check_limits(np.concatenate([p.actuation for p in parts]), mapping.actuation, where)
    for c, entry in enumerate(mapping.actuation):
        if entry.column is not None:
            u = np.concatenate([p.actuation[:, c] for p in parts])
            said += check_values(u, entry.unit, f"actuation {entry.name!r}", where)
    for k, o in enumerate(mapping.observables):
        if o.marker is None:
            values = np.concatenate([p.values[:, k] for p in parts])
            said += check_values(values, o.unit, f"observable {o.name!r}", where)
    for k, e in enumerate(mapping.covariates):
        values = np.concatenate([p.covariates[:, k] for p in parts])
        said += check_values(values, e.unit, f"covariate {e.name!r}", where)
    return [*said, *_other_scale(mapping, parts)]


def _other_scale(mapping: Mapping, parts: Sequence[Part]) -> list[str]:
    """Observables that are many times as large in one file as in another, as metres are beside millimetres."""
    sizes = np.array([[_size(v) for v in part.values.T] for part in parts])
    if len(parts) < 2 or not sizes.size:
        return []
    known = np.where(sizes > 0, sizes, np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a column that is empty throughout
        times = np.nanmax(known, axis=0) / np.nanmin(known, axis=0)
    apart = np.flatnonzero(times >= _OTHER_SCALE)
    if not len(apart):
        return []
    k = int(apart[0])
    most, least = (parts[int(pick(known[:, k]))].file.file for pick in (np.nanargmax, np.nanargmin))
    more = f" (and {len(apart) - 1} more)" if len(apart) > 1 else ""
    unit = mapping.observables[k].unit
    return [
        f"observable {mapping.observables[k].name!r}{more} is {times[k]:.3g} times as large in {most} as in {least}: "
        f"are both in {unit}?"
    ]


def _size(values: Floats) -> float:
    """The usual size of the numbers of a column, 0 where there are none."""
    known = np.abs(values[np.isfinite(values)])
    return float(np.percentile(known, 90)) if len(known) else 0.0


def _by_clock(mapping: Mapping, parts: list[Part]) -> tuple[list[Part], list[str]]:
    """The files in the order of their clocks, and that it is another than they were named in.

    Clocks that begin anew in each file, and times of day, which go on past midnight, say no order.
    """
    clock = mapping.time
    if clock is None or clock.column is None or (is_dated(clock) and parts[0].time_s.min() < _ERA_S):
        return parts, []
    ordered = sorted(parts, key=lambda part: float(part.time_s.min()))
    apart = all(one.time_s.max() < other.time_s.min() for one, other in pairwise(ordered))
    if ordered == parts or not apart:
        return parts, []
    first = ordered[0].file.part or Path(ordered[0].file.file).name
    return ordered, [f"the files are in the order of their clocks, not as they were named: {first} is first"]


def _began(mapping: Mapping, parts: Sequence[Part]) -> str:
    """The first moment of a record whose clock holds dates, or counts from 1970, as run.yaml has it; else empty.

    In UTC where its dates name a zone; others are taken as they stand.
    """
    clock, first_s = mapping.time, float(parts[0].time_s[0])
    if clock is None or clock.column is None:
        return ""
    if not (_ERA_S if is_dated(clock) else _COUNTED_S) <= first_s < time.time() + 86_400.0:
        return ""
    return datetime.fromtimestamp(first_s, UTC).isoformat(timespec="seconds")


def _order_in_time(parts: Sequence[Part]) -> None:
    """Put files and sessions whose clocks all begin anew one after the other."""
    end = None
    for part, own in session_blocks(parts):
        if end is not None and part.time_s[own][0] <= end:
            part.time_s[own] += end + _GAP_S - part.time_s[own][0]
        end = float(part.time_s[own][-1])
    start = parts[0].time_s[0]
    for part in parts:
        part.time_s -= start
