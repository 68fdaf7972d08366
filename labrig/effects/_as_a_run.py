"""A Dataset as docs/reference/dataset.md describes it, out of what somebody made of a run with xarray.

What xarray spread over a dimension, `run.where(..., drop=True)` as much as `xarray.concat`, is put back; whatever is
missing, and what to do then, is one line.
"""

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

_DIMENSIONS = {
    "commanded": ("capture", "chamber"),
    "chamber_min": ("chamber",),
    "chamber_max": ("chamber",),
    "hold_s": ("capture", "time"),
    "time_s": ("capture", "time"),
    "session": ("capture",),
    "repeat": ("capture",),
    "event_of": ("capture",),
    "event_time_s": ("event",),
    "event_commanded": ("event", "chamber"),
    "event_session": ("event",),
}
REST_OF = tuple(f"rest_{axis}_mm" for axis in "xyz")
"""Coordinates that say where the marker of an observable is at rest."""
_OPTIONAL = {
    "measured": ("capture", "time", "chamber"),
    "position_mm": ("capture", "time", "marker", "axis"),
    "observed": ("capture", "time", "observable"),
    "unit": ("observable",),
    "marker_of": ("observable",),
    "axis_of": ("observable",),
    **dict.fromkeys(REST_OF, ("observable",)),
    "covariates": ("capture", "time", "covariate"),
    "covariate_unit": ("covariate",),
    "rest_mm": ("marker", "axis"),
    "ruled_out": ("capture",),
}
_NEEDED_BY = {
    "position_mm": ("marker", "axis"),
    "observed": ("observable", "unit", "marker_of", "axis_of"),
    "covariates": ("covariate", "covariate_unit"),
}
"""The coordinates without which nobody knows what a variable's columns are."""
_MM = ("mm", "millimeter", "millimetre")
_MEASURED = ("position_mm", "observed", "measured", "covariates")
_WHOLE = "labrig takes a run as labrig.open_run gives it"


def as_a_run(dataset: "Dataset", *, whole: bool = True) -> "Dataset":
    """The Dataset, its variables over the dimensions that a run has, in their order; itself where they are already.

    Raises `LabrigError` where a variable of a `whole` run, a dimension or a set-point is missing, or a capture is there
    twice.
    """
    where = _named(dataset)
    if dataset.sizes.get("capture") == 0:
        raise LabrigError(f"{where}: the run has no captures; nothing can be compared")
    if "commanded" in dataset.variables and "capture" not in dataset["commanded"].dims:
        raise _without(dataset, "commanded", "capture")
    for name in (*_DIMENSIONS, "chamber"):
        if whole and name not in dataset.variables:
            raise LabrigError(
                f"{where}: the run has no `{name}`: {_WHOLE}, so leave it in{_renamed(dataset)}"
            )
    for name, needed in _NEEDED_BY.items():
        for own in needed if whole and name in dataset.variables else ():
            if own not in dataset.variables or not dataset[own].dims:
                raise _without(dataset, name, own)
    put_back = {}
    for name, wanted in (_DIMENSIONS | _OPTIONAL).items():
        known = name in dataset.variables and (whole or {*wanted} <= {*dataset[name].dims})
        if known and dataset[name].dims != wanted:
            put_back[name] = _over(dataset, name, wanted)
    if put_back:
        dataset = dataset.assign(put_back)
    if all(name in dataset.variables for name in _DIMENSIONS):
        _check(dataset, where)
    return dataset


def _over(dataset: "Dataset", name: str, wanted: tuple[str, ...]) -> "DataArray":
    """A variable over the dimensions that it has in a run: along any other all of its copies are the same."""
    given = dataset[name]
    for dimension in wanted:
        if dimension not in given.dims:
            raise _without(dataset, name, dimension)
    for extra in (str(each) for each in given.dims if each not in wanted):
        given = _one_of(given, extra, f"{_named(dataset)}: `{name}` is not the same along `{extra}`")
    return given.transpose(*wanted)


def _one_of(given: "DataArray", extra: str, wrong: str) -> "DataArray":
    """The copy that all along `extra` are, some of which `where` may have made NaN; `wrong` where they differ."""
    copies = np.moveaxis(given.values, given.dims.index(extra), 0)
    numbers = copies.dtype.kind in "fO"
    known = np.equal(copies, copies) if numbers else np.ones(copies.shape, dtype=bool)
    first = np.take_along_axis(copies, known.astype(bool).argmax(axis=0)[None], axis=0)[0]
    if not np.where(known, copies == first, True).all():
        raise LabrigError(f"{wrong}; give several runs as a list, [run, other], and each as it was opened")
    return given.isel({extra: 0}, drop=True).copy(data=first)


def _check(dataset: "Dataset", where: str) -> None:
    """Raise `LabrigError` for a set-point that nobody knows, an axis too few, a capture twice or without its event."""
    captures = _labels(dataset, "capture")
    for name, among in (("commanded", captures), ("event_commanded", None)):
        unknown = np.argwhere(np.isnan(np.asarray(dataset[name].values, dtype=float)))
        for row, chamber in unknown[:1]:
            at = f"capture {among[row]}" if among is not None else f"event {row}"
            raise LabrigError(
                f"{where}: `{name}` of chamber {_labels(dataset, 'chamber')[chamber]} in {at} is NaN: every set-point "
                "has to be known; run.where(..., drop=True) leaves captures out, and without drop=True it only blanks"
            )
    for name in _MEASURED:
        infinite = (
            np.isinf(np.asarray(dataset[name].values, dtype=float)) if name in dataset else np.zeros(0, bool)
        )
        if infinite.any():
            at = captures[np.argwhere(infinite)[0][0]]
            raise LabrigError(f"{where}: `{name}` is infinite in capture {at}: NaN is what was not measured")
    unit = str(dataset["position_mm"].attrs.get("units") or "mm") if "position_mm" in dataset else "mm"
    if unit.lower().rstrip("s") not in _MM:
        raise LabrigError(
            f"{where}: `position_mm` is said to be in {unit}: it has to be in mm, as its name says"
        )
    if "position_mm" in dataset and (axes := "".join(map(str, _labels(dataset, "axis")))) != "xyz":
        raise LabrigError(
            f"{where}: `axis` is {', '.join(axes)}: a marker's places need x, y and z, in that order"
        )
    event = np.asarray(dataset["event_of"].values, dtype=float)
    if not ((event >= 0) & (event < dataset.sizes["event"])).all():
        raise LabrigError(f"{where}: `event_of` counts events that are not there: leave all of `event` in")
    if "capture" in dataset.coords and len(set(captures)) < len(captures):
        begun = [own[np.isfinite(own)][:1].tolist() for own in np.asarray(dataset["time_s"].values, float)]
        each = [(label, e, *t) for label, e, t in zip(captures, event.tolist(), begun, strict=True)]
        same, often = Counter(each).most_common(1)[0]
        if often > 1:
            raise LabrigError(f"{where}: capture {same[0]} is in it twice: what was measured counts once")


def _without(dataset: "Dataset", name: str, dimension: str) -> LabrigError:
    """What is missing where a variable has no such dimension, and how it stays."""
    if dimension == "time":
        todo = "it condenses each hold itself, and needs all rows of it: give the run before any mean over `time`"
    elif dimension in ("unit", "marker_of", "axis_of", "covariate_unit"):
        todo = f"{_WHOLE}, so leave it in"
    elif dimension in dataset.coords and not dataset[dimension].dims:
        todo = f"sel({dimension}=[{dataset[dimension].item()!r}]) keeps it, without the brackets it is gone"
    else:
        todo = f"{_WHOLE}; isel({dimension}=[0]) keeps the dimension, isel({dimension}=0) does not"
    return LabrigError(f"{_named(dataset)}: `{name}` has no `{dimension}`: {todo}{_renamed(dataset)}")


def _renamed(dataset: "Dataset") -> str:
    """A hint where a dimension has a name that no run has."""
    known = {each for dims in (_DIMENSIONS | _OPTIONAL).values() for each in dims}
    other = [str(each) for each in dataset.dims if each not in known]
    return f" (and a run has no dimension `{other[0]}`: was it renamed?)" if other else ""


def _labels(dataset: "Dataset", dimension: str) -> Any:
    if dimension in dataset.coords:
        return dataset[dimension].values.tolist()
    return list(range(dataset.sizes[dimension]))


def _named(dataset: "Dataset") -> str:
    return str(dataset.attrs.get("run", "run"))
