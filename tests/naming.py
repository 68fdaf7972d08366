"""The naming of effects alone, for tests that ask for nothing of what is fitted after it: half the time."""

from typing import TYPE_CHECKING

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._diagnose import laid_out, verdict_on
from labrig.diagnosis._verdict import Verdict
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset


def verdict_of(data: "Dataset", model: Model) -> Verdict:
    """What `diagnose` says is missing, without formulas, errors and places."""
    effects = model.library()
    return verdict_on(*laid_out(prepared(rows_from(data), model), effects), effects)


def calls_of(data: "Dataset", model: Model) -> dict[str, str]:
    """sure, possible or not it, by effect."""
    return {c.effect: c.call for c in verdict_of(data, model).considered}
