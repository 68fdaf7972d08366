"""Physical effects: one small file each; what a model can lack."""

from labrig.effects._as_a_run import as_a_run
from labrig.effects._context import FEW_OBSERVABLES, Context
from labrig.effects._effect import WEIGHTS, Effect, Parameter, Term, Variant
from labrig.effects._family import (
    Feature,
    Space,
    acting,
    by_covariate,
    field,
    motion_scale,
    one_way,
    pattern,
    pressure,
)
from labrig.effects._fields import (
    STRAINS,
    centre_of,
    contribution,
    distortions,
    frame_modes,
    scale_mode,
)
from labrig.effects._fitted import Fitted, with_named_units
from labrig.effects._flatten import TRANSIENT_S, rows_of, ruled_out_in
from labrig.effects._forms import plain_forms
from labrig.effects._in_parts import affine
from labrig.effects._join import join_rows
from labrig.effects._logged import is_payload, is_temperature, is_tilt
from labrig.effects._obstacles import NORMALS, Places, by_marker, to_rows
from labrig.effects._own import EffectError, without_failing
from labrig.effects._own_pressure import any_curve
from labrig.effects._reached import reached
from labrig.effects._registry import get, library, take_along
from labrig.effects._rows import Covariate, Rows, capture_means, ends
from labrig.effects._ruled_out import STAYING, forms_on, may_act, only_where, spaces_on, times_changed
from labrig.effects._sessions import MOST_SESSIONS, without_value
from labrig.effects._sign import Part, Sign, by_chamber
from labrig.effects._skin import by_itself, per_sensor
from labrig.effects._slips import errors_by_capture
from labrig.effects._spectrum import bulk_edge, bulk_noise
from labrig.effects._stretches import Stretch, stretch_of
from labrig.effects._template import write_template
from labrig.effects._turn import whole_markers
from labrig.effects._units import unit_on
from labrig.effects._weights import (
    fields_of,
    form_of,
    is_family,
    labels_of,
    pressures_of,
    term_of,
    weighable,
    weighted,
    yardsticks_of,
)

__all__ = [
    "FEW_OBSERVABLES",
    "MOST_SESSIONS",
    "NORMALS",
    "STAYING",
    "STRAINS",
    "TRANSIENT_S",
    "WEIGHTS",
    "Context",
    "Covariate",
    "Effect",
    "EffectError",
    "Feature",
    "Fitted",
    "Parameter",
    "Part",
    "Places",
    "Rows",
    "Sign",
    "Space",
    "Stretch",
    "Term",
    "Variant",
    "acting",
    "affine",
    "any_curve",
    "as_a_run",
    "bulk_edge",
    "bulk_noise",
    "by_chamber",
    "by_covariate",
    "by_itself",
    "by_marker",
    "capture_means",
    "centre_of",
    "contribution",
    "distortions",
    "ends",
    "errors_by_capture",
    "field",
    "fields_of",
    "form_of",
    "forms_on",
    "frame_modes",
    "get",
    "is_family",
    "is_payload",
    "is_temperature",
    "is_tilt",
    "join_rows",
    "labels_of",
    "library",
    "may_act",
    "motion_scale",
    "one_way",
    "only_where",
    "pattern",
    "per_sensor",
    "plain_forms",
    "pressure",
    "pressures_of",
    "reached",
    "rows_of",
    "ruled_out_in",
    "scale_mode",
    "spaces_on",
    "stretch_of",
    "take_along",
    "term_of",
    "times_changed",
    "to_rows",
    "unit_on",
    "weighable",
    "weighted",
    "whole_markers",
    "with_named_units",
    "without_failing",
    "without_value",
    "write_template",
    "yardsticks_of",
]
