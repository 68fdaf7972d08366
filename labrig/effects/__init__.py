"""Physical effects: one small file each; what a model can lack."""

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, field, motion_scale, pattern, pressure
from labrig.effects._fields import centre_of, contribution, frame_modes, scale_mode
from labrig.effects._registry import USER_FOLDER, get, library
from labrig.effects._rows import TRANSIENT_S, Covariate, Rows, join_rows, rows_of
from labrig.effects._sign import Part
from labrig.effects._spectrum import bulk_edge, bulk_noise, fill
from labrig.effects._template import write_template

__all__ = [
    "TRANSIENT_S",
    "USER_FOLDER",
    "Context",
    "Covariate",
    "Effect",
    "Parameter",
    "Part",
    "Rows",
    "Space",
    "Term",
    "Variant",
    "acting",
    "bulk_edge",
    "bulk_noise",
    "centre_of",
    "contribution",
    "field",
    "fill",
    "frame_modes",
    "get",
    "join_rows",
    "library",
    "motion_scale",
    "pattern",
    "pressure",
    "rows_of",
    "scale_mode",
    "write_template",
]
