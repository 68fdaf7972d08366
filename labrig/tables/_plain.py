"""A DataFrame as a plain table: what is in its index, its levels of names and its cells of mixed kinds."""

from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig.tables import _names as names
from labrig.tables._names import take_apart

if TYPE_CHECKING:
    from pandas import DataFrame, Series

_AXES = ("x", "y", "z")


def plain(frame: "DataFrame") -> "DataFrame":
    """A frame whose columns have one name each, and numbers or text in them.

    What its index holds are columns, if it has a name, or is a clock: `time` then, if it has none.

    Raises `LabrigError` where two columns have one name.
    """
    index = frame.index
    timed = any(take_apart(_flat(name)).has(names.TIME) for name in frame.columns)
    named = [name is not None or (index.nlevels == 1 and _is_clock(index, timed)) for name in index.names]
    own = index.to_frame(index=False).loc[:, named]
    own.columns = [
        _flat("time" if name is None else name)
        for name, is_kept in zip(index.names, named, strict=True)
        if is_kept
    ]
    frame = frame.set_axis([_flat(name) for name in frame.columns], axis=1).reset_index(drop=True)
    frame = own.drop(columns=[name for name in own.columns if name in frame.columns]).join(frame)
    twice = frame.columns[frame.columns.duplicated()].unique().tolist()
    if twice:
        which = ", ".join(repr(name) for name in twice[:3]) + (", ..." if len(twice) > 3 else "")
        raise LabrigError(
            f"the DataFrame has several columns called {which}: rename all but one of each, or drop them"
        )
    return frame.assign(**{str(name): _alike(column) for name, column in frame.items()})


def _is_clock(index: Any, timed: bool) -> bool:
    """Whether an index holds times: dates or spans; where no column is `timed`, also fractions, or whole numbers that
    never go up by one.
    """
    if index.dtype.kind in "Mm" or timed:
        return index.dtype.kind in "Mm"
    if index.dtype.kind == "f":
        return True
    return index.dtype.kind in "iu" and len(index) > 1 and int(abs(index[1:] - index[:-1]).min()) > 1


def _flat(name: Any) -> str:
    """One name of a column, of all levels that it has; the axis of a marker comes last, as in m1.x."""
    if not isinstance(name, tuple):
        return str(name)
    words = [str(word) for word in name if str(word) != ""]
    if len(words) > 1 and words[0].lower() in _AXES and words[-1].lower() not in _AXES:
        words = [*words[1:], words[0]]
    return ".".join(words)


def _alike(column: "Series") -> "Series":
    """A column with text among its numbers as text, since a file has one kind in each column."""
    from pandas.api.types import infer_dtype

    if column.dtype != object or infer_dtype(column, skipna=True) not in {"mixed", "mixed-integer"}:
        return column
    if not column.map(lambda v: isinstance(v, str | int | float) or v is None).all():
        return column
    return column.map(str).where(column.notna(), None)
