"""model.yaml: a base and its effects, as a person reads and edits them."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Literal
from zipfile import is_zipfile

import yaml
from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, model_validator

from labrig._durable import write_whole
from labrig._errors import LabrigError
from labrig._fields import check_fields
from labrig._paths import check_parent
from labrig._yaml import read_yaml

Number = Annotated[float, Field(allow_inf_nan=False)]
Numbers = Number | list[Number] | list[list[Number]]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class PythonBase(_Strict):
    """A function of the user's: ``predict(actuation: (F, C)) -> (F, K)``, in the units of the run.

    Or with memory. `record`: ``predict(u: (n, C), t: (n,)) -> (n, K)`` over one record. `step`: ``step(state: (S,),
    u: (C,), dt_s) -> (state, y: (K,))``, the output now and the state `dt_s` later, from `state` on. Left out, the
    number of its parameters says which. `learned`: it was fitted or trained, so its error may be any curve, but, where
    that is said, by no more than its `heldout_error`.
    """

    kind: Literal["python"]
    file: str
    function: str = "predict"
    memory: Literal["none", "record", "step"] | None = None
    state: list[float] | None = None
    max_step_s: float | None = Field(default=None, gt=0)
    learned: bool | None = None
    heldout_error: float | None = Field(default=None, gt=0)
    _given: Callable[..., Any] | None = PrivateAttr(default=None)

    @property
    def given(self) -> Callable[..., Any] | None:
        """The function itself, where it was handed over, not named by its file."""
        return self._given

    @classmethod
    def of(cls, function: Callable[..., Any], **more: Any) -> "PythonBase":
        """A base that is handed over; `more` as in the file. Raises `LabrigError` for what is none of those fields."""
        name = getattr(function, "__name__", None) or type(function).__name__
        base = check_fields(cls, {"kind": "python", "file": "", "function": name, **more}, name)
        base._given = function
        return base


class OdeBase(_Strict):
    """A differential equation of the user's: ``rate(t, x, u) -> dx/dt``, ``output(x, u) -> y (K,)``, from `state` on.

    Between two samples the input is `held` or `linear`.
    """

    kind: Literal["ode"]
    file: str
    rate: str = "rate"
    output: str = "output"
    state: list[float] = Field(min_length=1)
    input: Literal["held", "linear"] = "held"
    rtol: float = Field(default=1e-6, gt=0, lt=0.1)


class FmuBase(_Strict):
    """A model of another tool (FMI 2 or 3): chambers by name -> its inputs, observables by name -> its outputs."""

    kind: Literal["fmu"]
    file: str
    inputs: dict[str, str]
    outputs: dict[str, str]
    parameters: dict[str, float] = Field(default_factory=dict)


class TableBase(_Strict):
    """A table of predictions, with a column for each chamber and observable; between its set-points it is smooth.

    `learned`: it comes from a model that was fitted or trained, so its error may be any curve of the pressures, but,
    where that is said, by no more than its `heldout_error`.
    """

    kind: Literal["table"]
    file: str
    learned: bool | None = None
    heldout_error: float | None = Field(default=None, gt=0)


MOST_DEGREES = 3
"""The highest degree of a polynomial that is fitted as base."""


class StaticBase(_Strict):
    """A polynomial map from the pressures to each observable, fitted to the run, or to each of its sessions."""

    kind: Literal["static"]
    degree: int = Field(1, ge=0, le=MOST_DEGREES)
    in_each_session: bool | None = None


class SimulatorBase(_Strict):
    """labrig's simulator of the rig that `rig` (a rig.yaml) describes.

    `parameters` are values of its shell's parameters that are known better than the shell's file has them; `calibrated`
    names those that are not known beforehand: they are fitted to each run, and again beside every effect.
    """

    kind: Literal["simulator"]
    rig: str
    parameters: dict[str, float] = Field(default_factory=dict)
    calibrated: list[str] = Field(default_factory=list)


class SurrogateBase(_Strict):
    """A model that `labrig train` wrote: a forward model, or one with a sim-to-real correction."""

    kind: Literal["surrogate"]
    file: str


Base = Annotated[
    PythonBase | OdeBase | FmuBase | TableBase | StaticBase | SimulatorBase | SurrogateBase,
    Field(discriminator="kind"),
]


class Value(_Strict):
    """A fitted value: one number, or one for each chamber, pair or observable, and its standard deviation.

    `sd_given_shape`: the same where what is not linear in the form, such as a time constant, stays as it is.
    """

    value: Numbers
    sd: float | list[float] | list[list[float]] | None = None
    sd_given_shape: float | list[float] | list[list[float]] | None = None
    unit: str = "1"
    per: list[str] | None = None


class FittedOn(_Strict):
    """What an entry's values refer to, so that they mean the same on every run.

    `low`, `high`: the range of each of `chambers` that fractions are of, in `unit` (empty: not known); `centre_mm`: the
    point that rotations and scales are about, and a plane's distance is from; `start_s`: when the run began that
    moments are counted from, by the rig's clock; `yardsticks`: what the functions of a family are measured by, such as
    how far the rig went; `lowest`, `highest`: between which the run kept each chamber, where a family's weights are
    known from it.
    """

    chambers: list[str] = Field(default_factory=list)
    low: list[float] = Field(default_factory=list)
    high: list[float] = Field(default_factory=list)
    unit: str = ""
    centre_mm: Annotated[list[float], Field(min_length=3, max_length=3)] | None = None
    start_s: float | None = None
    yardsticks: dict[str, Numbers] | None = None
    lowest: list[float] | None = None
    highest: list[float] | None = None

    @model_validator(mode="after")
    def _each_chamber(self) -> "FittedOn":
        if not len(self.chambers) == len(self.low) == len(self.high):
            raise ValueError("chambers, low and high must have as many values as each other")
        if any(low >= high for low, high in zip(self.low, self.high, strict=True)):
            raise ValueError("low must be below high for each chamber")
        if any(kept is not None and len(kept) != len(self.chambers) for kept in (self.lowest, self.highest)):
            raise ValueError("lowest and highest must have a value for each chamber")
        return self


class EffectEntry(_Strict):
    """An effect of the model, the form it takes and its fitted values."""

    name: str
    form: str | None = None
    fitted_on: FittedOn | None = None
    parameters: dict[str, Value] = Field(default_factory=dict)


class ModelFile(_Strict):
    """The content of a model.yaml; `fitted_until`: when the last run was recorded that its effects were fitted to."""

    base: Base
    effects: list[EffectEntry] = Field(default_factory=list)
    fitted_until: datetime | None = None


def read_model_file(path: Path) -> ModelFile:
    """Read a model.yaml; raises `LabrigError` that names the file, the line and the field."""
    if is_zipfile(path):
        raise LabrigError(
            f"{path} is a learned model, which a model file names as its base: write one, such as "
            f"`base: {{kind: surrogate, file: {path.name}}}`"
        )
    content = read_yaml(path, "model", begins="base: {kind: static, degree: 1}")
    return check_fields(ModelFile, content, str(path), path)


def model_text(model: ModelFile) -> str:
    """The text of a model.yaml."""
    content = model.model_dump(exclude_none=True)
    content["base"] = {name: value for name, value in content["base"].items() if value not in ({}, [])}
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None, allow_unicode=True, width=110)


def write_model_file(model: ModelFile, path: Path) -> None:
    """Write a model.yaml, in one piece or not at all.

    Raises `LabrigError` where its folder is not there, or where something else is that is no model file.
    """
    check_parent(path)
    if path.is_dir():
        raise LabrigError(f"{path} is a folder: name the file, such as {path / 'model.yaml'}")
    if path.exists() and not _may_be_replaced(path):
        raise LabrigError(f"{path} exists and is no model file: choose another name")
    write_whole(path, model_text(model))


def _may_be_replaced(path: Path) -> bool:
    """Whether a file is empty, or a model's, be it one with a mistake or of another release: it has a base."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (UnicodeError, yaml.YAMLError):
        return False
    return content is None or (isinstance(content, dict) and "base" in content)
