"""What is not linear in a form, such as a time constant: which of it is moved, and the form with another value."""

from labrig.diagnosis._candidates import Candidate
from labrig.effects import Context, Variant, forms_on


def is_moved(part: Candidate, name: str) -> bool:
    """Whether a value of a form's shape is a size that may be moved: which chamber it is of is none."""
    parameter = part.effect.parameter(name)
    return part.variant.shape[name] > 0 and not parameter.given and parameter.per == "one"


def with_shape(context: Context, part: Candidate, name: str, value: float) -> Variant | None:
    """The same form with another value in its shape; None where it can't act with that."""
    pinned = context.pin({**part.variant.shape, name: value})
    return next((v for v in forms_on(part.effect, pinned) if v.form == part.variant.form), None)
