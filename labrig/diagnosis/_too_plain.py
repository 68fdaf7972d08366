"""A polynomial that is fitted as base and is too plain: one of a higher degree errs much less."""

from dataclasses import replace
from math import comb

from labrig._errors import LabrigError
from labrig.contents import Summary
from labrig.diagnosis._amount import amount
from labrig.diagnosis._candidates import error_of
from labrig.diagnosis._notes import MUCH_LESS
from labrig.diagnosis._problem import prepared
from labrig.effects import Rows
from labrig.model import MOST_DEGREES, Model, StaticBase


def too_plain(rows: Rows, model: Model, summary: Summary) -> list[str]:
    """A line where something is missing, the base is a polynomial, and one of a higher degree alone errs much less on
    captures that were left out than this one with all that was found.
    """
    base = model.file.base
    if not isinstance(base, StaticBase) or summary["verdict"] in {"nothing_missing", "underpowered"}:
        return []
    best, least = base.degree, summary["error"]["model"]
    for degree in range(base.degree + 1, MOST_DEGREES + 1):
        if 3 * comb(len(rows.chambers) + degree, degree) > rows.n_captures:
            break
        error = _error(rows, model, base, degree)
        if error is not None and error < MUCH_LESS * least:
            best, least = degree, error
    if best == base.degree:
        return []
    unit, was = summary["units"], summary["error"]["base"]
    return [
        f"a polynomial of degree {best} as base errs by {amount(least, unit)} on captures that were left out, this one "
        f"of degree {base.degree} by {amount(was, unit)}: it is too plain for anything else to be seen beside it, so "
        f"say degree: {best} in the model file, and diagnose again"
    ]


def _error(rows: Rows, model: Model, base: StaticBase, degree: int) -> float | None:
    """The error of a base of this degree on captures that were left out; None where it can't be fitted to them."""
    other = base.model_copy(update={"degree": degree})
    try:
        ready = prepared(rows, replace(model, file=model.file.model_copy(update={"base": other})))
    except LabrigError:
        return None
    return error_of(ready.regression, ready.regression.base_left)
