"""Whether one space holds what another does."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from labrig._linalg import svd
from labrig.arrays import Floats
from labrig.effects import Space

_NEARLY_ALIKE = 0.1
"""Share of a function that another space may lack and still hold it."""
_ROWS_COMPARED = 50
"""About how many rows two spaces are compared on; numerical."""


class Span(NamedTuple):
    """What so many functions span: an orthonormal `basis` (n, q) over n numbers."""

    functions: int
    basis: Floats


def has_name(space: Space, named: Sequence[Mapping[str, Span]], rows: int = _ROWS_COMPARED) -> bool:
    """Whether one space with a name, of which so many rows are known, holds nearly all that this one does: what has a
    name is not unnamed as well.
    """
    own = _by_kind(space, rows)
    return any(all(_within(f, known.get(kind)) for kind, f in own.items()) for known in named)


def spans(space: Space, rows: int = _ROWS_COMPARED) -> dict[str, Span]:
    """What the features of a space span, by their kind, over about so many rows."""
    out = {}
    for kind, columns in _by_kind(space, rows).items():
        U, s, _ = svd(columns)
        heard = s > max(columns.shape) * np.finfo(s.dtype).eps * s.max(initial=0.0)
        out[kind] = Span(columns.shape[1], U[:, heard])
    return out


def _by_kind(space: Space, rows: int) -> dict[str, Floats]:
    """The features of a space by their kind, about so many rows of each, as unit columns."""
    out = {}
    for kind in {f.kind for f in space.features}:
        values = [f.values for f in space.features if f.kind == kind]
        step = max(1, len(values[0]) // rows)
        columns = np.stack([v[::step].ravel() for v in values], axis=1)
        out[kind] = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    return out


def alike(one: Space, other: Space) -> bool:
    """Whether two spaces are the same, of whatever owners: then they differ in nothing that the data could tell."""
    if (one.spectrum, one.key) != (other.spectrum, other.key):
        return False
    both = zip(one.features, other.features, strict=False)
    return len(one.features) == len(other.features) and all(
        f.name == g.name and np.array_equal(f.values, g.values) for f, g in both
    )


def different(spaces: Sequence[Space]) -> list[Space]:
    """Spaces without those that are the same as one before, of another owner."""
    out: list[Space] = []
    for space in spaces:
        if not any(alike(before, space) for before in out):
            out.append(space)
    return out


def _within(columns: Floats, known: Span | None) -> bool:
    """Whether unit columns (n, q) lie in what is spanned, nearly, and not just because that is nearly everything."""
    if known is None or not columns.shape[1] <= known.functions <= len(known.basis) / 2:
        return False
    left = columns - known.basis @ (known.basis.T @ columns)
    return bool(np.linalg.norm(left, axis=0).max() < _NEARLY_ALIKE)
