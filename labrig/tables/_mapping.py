"""MAP.yaml: what the columns of somebody's own table mean."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, field_validator, model_validator

from labrig._errors import LabrigError
from labrig._fields import check_fields
from labrig._yaml import read_yaml
from labrig.arrays import Floats


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", populate_by_name=True)


class Column(_Strict):
    """A column by its name, or by its number (from 0) where the table has no header.

    `thousands` is the sign between groups of three digits, where the numbers have one.
    """

    column: str | int
    thousands: str | None = None


class TimeColumn(_Strict):
    """A clock: columns that are added, with their units (one for all, or one each), or `rate_hz` frames in a second.

    Without a `column` the rows themselves are counted. Columns of dates and times are read together, as one text. With
    `sort` the rows may stand in any order: they are sorted by it.
    """

    column: str | int | list[str | int] | None = None
    thousands: str | None = None
    unit: str | list[str] = "s"
    rate_hz: float | None = Field(None, gt=0)
    day_first: bool | None = None
    sort: bool = False

    @model_validator(mode="after")
    def _one_of_both(self) -> "TimeColumn":
        if self.rate_hz is not None and "unit" in self.model_fields_set:
            raise ValueError("a clock has a unit, or is frames at a rate_hz, not both")
        if self.column is None and self.rate_hz is None:
            raise ValueError("name the column of the clock, or the rate_hz of the rows")
        if self.rate_hz is not None and isinstance(self.column, list):
            raise ValueError("frames at a rate_hz are counted in one column")
        if not self.columns() and self.column is not None:
            raise ValueError("name at least one column")
        if isinstance(self.unit, list) and len(self.unit) != len(self.columns()):
            raise ValueError("give one unit, or one for each column")
        return self

    def columns(self) -> list[str | int]:
        """The columns that are added, none where rows are counted."""
        if self.column is None:
            return []
        return self.column if isinstance(self.column, list) else [self.column]

    def units(self) -> list[str]:
        """The unit of each column."""
        return self.unit if isinstance(self.unit, list) else [self.unit] * len(self.columns())


class UnitColumn(Column):
    """A column and the unit of its numbers."""

    unit: str


class CaptureColumn(_Strict):
    """Which rows make one capture: those that share a value of `column`, all of one file, or one plateau of the input.

    `segment`: labrig finds the plateaus, ramps and cycles of the input; rows of a moving input count one by one.
    """

    column: str | int | None = None
    per: Literal["file", "segment"] | None = None

    @model_validator(mode="after")
    def _one(self) -> "CaptureColumn":
        if (self.column is None) == (self.per is None):
            raise ValueError("give either 'column: NAME', 'per: file' or 'per: segment'")
        return self


class _Scaled(_Strict):
    """Numbers of an amplifier: `scale` times what the column says, plus `offset`, is in the unit."""

    scale: FiniteFloat = 1.0
    offset: FiniteFloat = 0.0

    @field_validator("scale")
    @classmethod
    def _some(cls, value: float) -> float:
        if value == 0:
            raise ValueError("should not be 0: every number would be the same")
        return value

    def scaled(self, numbers: Floats) -> Floats:
        """What numbers of the column are in the unit."""
        return self.scale * numbers + self.offset


class Actuation(_Scaled):
    """One chamber's command: from a column, or a constant `value`; with its limits if they are known.

    With `on_change` it is written only where it changes: an empty cell is as the one above.
    """

    column: str | int | None = None
    value: float | None = None
    on_change: bool = False
    thousands: str | None = None
    name: str
    unit: str
    min: float | None = None
    max: float | None = None


class Measured(UnitColumn, _Scaled):
    """What the sensor of the chamber `name` read."""

    name: str


class Observable(UnitColumn, _Scaled):
    """One measured number; `marker` and `axis` where it is a marker's coordinate."""

    name: str
    marker: str | None = None
    axis: Literal["x", "y", "z"] | None = None


class Covariate(_Scaled):
    """Anything else that was logged: in a column, or (without one) a constant of each file of `table`."""

    column: str | int | None = None
    name: str
    unit: str = "1"
    thousands: str | None = None


class Marker(_Strict):
    """A marker's position with every chamber vented, mm, and its label in a C3D file if that differs."""

    rest: tuple[float, float, float] | None = None
    point: str | None = None


class Event(_Strict):
    """An actuation within a file that does not say it itself: its moment and the commanded values by name."""

    time_s: float
    actuation: dict[str, float]
    record: bool = True


class TableFile(_Strict):
    """One file of a campaign in several; `session` defaults to the file's name, `join` names its own joined files.

    `part` is the sheet, group or topic of this file, where it is not that of all under `format`.
    """

    file: str
    part: str | None = None
    session: str | None = None
    actuation: dict[str, float] = Field(default_factory=dict)
    covariates: dict[str, float] = Field(default_factory=dict)
    events: list[Event] = Field(default_factory=list)
    join: dict[str, str] = Field(default_factory=dict)


class Format(_Strict):
    """How a table is written, and which part of its file it is.

    `encoding` is found out where it is not given; with `units_row` the line below the header holds units. `groups` are
    lines, so many above the names, that say what several columns belong to. `missing` stands where there is no number.
    """

    separator: str = ","
    header: bool = True
    units_row: bool = False
    decimal: str = "."
    encoding: str | None = None
    part: str | None = None
    skip_rows: int = Field(default=0, ge=0)
    groups: list[Annotated[int, Field(gt=0)]] = Field(default_factory=list)
    missing: list[str] = Field(default_factory=list)
    rows: int | None = Field(default=None, gt=0)
    every: int = Field(default=1, gt=0)

    @field_validator("missing", mode="before")
    @classmethod
    def _words(cls, value: Any) -> Any:
        """Numbers that stand for nothing may be written as numbers."""
        return (
            [str(v) if isinstance(v, int | float) else v for v in value] if isinstance(value, list) else value
        )


class Join(_Strict):
    """Another file whose rows have a clock of their own: its columns are read at the table's times.

    Its columns are called ``NAME.column``. Its time t, in s, is the table's `rate` * t + `offset_s`. `how` is `linear`,
    `nearest` or `previous`; a time that is farther than `within_s` from any row of it was not seen, nor, where it is
    `linear`, one between two rows that are more than twice as far apart, or twice the usual step.
    """

    name: str
    file: str | None = None
    time: TimeColumn
    how: Literal["linear", "nearest", "previous"] = "linear"
    offset_s: float = 0.0
    rate: float = Field(default=1.0, gt=0)
    within_s: float | None = Field(default=None, gt=0)
    format: Format = Field(default_factory=Format)


class Mapping(_Strict):
    """The content of a MAP.yaml (docs/reference/mapping.md)."""

    table: str | list[str | TableFile] | None = None
    format: Format = Field(default_factory=Format)
    join: list[Join] = Field(default_factory=list)
    time: TimeColumn | None = None
    capture: CaptureColumn | None = None
    hold: UnitColumn | None = None
    settle_s: float | None = Field(None, ge=0)
    session: Column | None = None
    between_sessions: Literal["held", "vented", "unknown"] = "unknown"
    repeat: Column | None = None
    actuation: list[Actuation] = Field(default_factory=list)
    measured: list[Measured] = Field(default_factory=list)
    observables: list[Observable] = Field(default_factory=list)
    markers: dict[str, Marker] | list[str] = Field(default_factory=dict)
    covariates: list[Covariate] = Field(default_factory=list)

    @field_validator("between_sessions", mode="before")
    @classmethod
    def _formerly(cls, value: Any) -> Any:
        """Files from before call vented pressures `released`."""
        return "vented" if value == "released" else value

    @model_validator(mode="after")
    def _since_when(self) -> "Mapping":
        if self.settle_s is not None and self.hold is not None:
            raise ValueError("'hold:' and 'settle_s:' say the same: leave one of them out")
        if self.settle_s is not None and self.time is None:
            raise ValueError("'settle_s:' needs the time of each row: say its column under 'time:'")
        return self

    def files(self) -> list[TableFile]:
        """The tables, in order."""
        many = self.table if isinstance(self.table, list) else [self.table] if self.table else []
        return [f if isinstance(f, TableFile) else TableFile(file=f) for f in many]

    def any_thousands(self) -> bool:
        """Whether some column has signs between its thousands, so that the table must be read as text."""
        return any(c is not None and c.thousands for c in (self.time, *self._numbers()))

    def without_thousands(self) -> list[str | int]:
        """The columns of numbers of which nothing is said of signs between their thousands."""
        found = (c.column for c in self._numbers() if c is not None and not c.thousands)
        return [column for column in found if column is not None]

    def _numbers(self) -> list[Column | Actuation | Covariate | None]:
        return [self.hold, *self.actuation, *self.measured, *self.observables, *self.covariates]

    def marker_table(self) -> dict[str, Marker]:
        """Markers by name, whichever way they were written."""
        return self.markers if isinstance(self.markers, dict) else {name: Marker() for name in self.markers}


def read_mapping(path: Path) -> Mapping:
    """Read a MAP.yaml; raises `LabrigError` that names the file, the line and the field."""
    return check_mapping(read_yaml(path, "mapping", begins="table: ..."), path, path)


def check_mapping(content: dict[str, Any], where: Path, path: Path | None = None) -> Mapping:
    """The content of a mapping, checked; complaints name `where`, and lines of the YAML file `path` if there is one."""
    mapping = check_fields(Mapping, content, str(where), path)
    path = where
    names = [a.name for a in mapping.actuation]
    if len(set(names)) < len(names):
        raise LabrigError(f"{path}: actuation: two entries have the same name")
    if not names:
        raise LabrigError(
            f"{path}: actuation: name at least one commanded value (a constant one has 'value:')"
        )
    for measured in mapping.measured:
        if measured.name not in names:
            raise LabrigError(f"{path}: measured: {measured.name!r} is no name under 'actuation:'")
    observables = [o.name for o in mapping.observables]
    if len(set(observables)) < len(observables):
        raise LabrigError(f"{path}: observables: two entries have the same name")
    joined = [j.name for j in mapping.join]
    if len(set(joined)) < len(joined):
        raise LabrigError(f"{path}: join: two entries have the same name")
    return mapping
