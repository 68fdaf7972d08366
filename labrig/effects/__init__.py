"""Physical effects: one small file each; what a model can lack."""

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._registry import USER_FOLDER, get, library
from labrig.effects._rows import Covariate, Rows, join_rows, rows_of
from labrig.effects._template import write_template

__all__ = [
    "USER_FOLDER",
    "Context",
    "Covariate",
    "Effect",
    "Parameter",
    "Rows",
    "Term",
    "Variant",
    "get",
    "join_rows",
    "library",
    "rows_of",
    "write_template",
]
