"""The file that `labrig effects new NAME` writes: a user's own effect that works at once."""

import re
from pathlib import Path

from labrig._errors import LabrigError
from labrig._own_code import USER_FOLDER
from labrig.effects._registry import shipped

_TEMPLATE = '''"""{title}: say in one line what it is."""

from collections.abc import Iterator

from labrig.effects import Context, Effect, Parameter, Term, Variant


class {cls}(Effect):
    name = "{name}"
    meaning = (
        "What happens physically, in two lines,\\n"
        "so that a colleague recognises it."
    )
    acts_on = "pressure"
    parameters = (Parameter("amplitude", "1", -1.0, 1.0, meaning="change of the pressure at full range"),)
    reference = "where the formula comes from"
    signature = "how its error depends on pressure, time, direction or place"
    experiment = "what to measure to isolate it"

    def variants(self, context: Context) -> Iterator[Variant]:
        # context.rows: actuation (F, C), hold_s, time_s, covariates, ...; context.relaxed, play, direction: history.
        # Here: each chamber's pressure is off by amplitude x p x (p / range)^3. Put your own formula in its place.
        change = context.rows.actuation * context.rows.fraction**3
        yield Variant("simple", (Term.common("amplitude", change),))
'''


def write_template(name: str, folder: Path) -> Path:
    """Write `effects/NAME.py` below `folder` and return its path.

    Raises `LabrigError` when the name is no identifier, is taken, or the file exists.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise LabrigError(f"{name!r}: an effect's name is lower-case letters, digits and _, such as humidity")
    if name in shipped():
        raise LabrigError(f"{name!r}: labrig has an effect of this name; see: labrig effects show {name}")
    path = folder / USER_FOLDER / f"{name}.py"
    if path.exists():
        raise LabrigError(f"{path}: already exists; edit it, or choose another name")
    path.parent.mkdir(exist_ok=True)
    cls = "".join(part.capitalize() for part in name.split("_"))
    path.write_text(_TEMPLATE.format(name=name, cls=cls, title=cls), encoding="utf-8")
    return path
