"""What compare, diagnose and improve give back has in common: errors, where they are, pictures, files."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar, cast

from labrig._errors import LabrigError
from labrig.api._inputs import AnyPath
from labrig.contents import Summary, Versus

if TYPE_CHECKING:
    from pandas import DataFrame
    from plotly.graph_objects import Figure
    from xarray import Dataset

    from labrig.diagnosis import Result, VersusResult
    from labrig.view import Figure as Drawn

_TABLE: dict[str, Any] = {"index": False, "float_format": "{:.3g}".format, "border": 0}
Found = TypeVar("Found", "Result", "VersusResult")


def drawn(pictures: "Mapping[str, Callable[[], Any]]", picture: str) -> "Figure":
    """One of the pictures as a plotly Figure, the first if none is named; raises `LabrigError` if there is no such."""
    from plotly.graph_objects import Figure

    wanted = picture or next(iter(pictures), "")
    if wanted not in pictures:
        raise LabrigError(f"there is no picture {wanted!r}; there are {', '.join(pictures)}")
    return Figure(pictures[wanted]())


@dataclass(frozen=True, repr=False)
class Answer(ABC, Generic[Found]):
    """Base of what says something of runs and models.

    `error` are root mean squares by name (`model`, `floor`, ...), per coordinate, in `units`; `where` has a row for
    each place; `fields` are the means over each hold (capture, observable) of what was `measured` and predicted:
    of the markers and other observables, where the `measured` of a run is what the pressure sensors read.
    """

    name: ClassVar[str] = ""
    _result: Found = field(repr=False)

    @property
    def units(self) -> str:
        """The unit of the errors."""
        return str(self._result.summary["units"])

    @property
    def error(self) -> dict[str, float]:
        """Root mean square errors by name, in `units`."""
        errors = cast("dict[str, float | None]", self._result.summary["error"])
        return {name: float(value) for name, value in errors.items() if value is not None}

    @property
    def errors(self) -> "DataFrame":
        """The same in every unit that was measured in, a row each; the unit that `error` is in comes first."""
        from pandas import DataFrame

        by_unit = self._result.summary.get("error_by_unit", {})
        rows: dict[str, Any] = {self.units: self.error}
        rows |= {unit: dict(row) for unit, row in by_unit.items() if unit != self.units}
        return DataFrame.from_dict(rows, "index")

    @property
    @abstractmethod
    def where(self) -> "DataFrame":
        """A row for each place, the worst first."""

    @property
    def fields(self) -> "Dataset":
        """`measured`, `base` and `model`, means over each hold, (capture, observable)."""
        return self._result.fields

    @property
    def values(self) -> list[str]:
        """What was fitted of each effect, one line each, with standard deviations."""
        return []

    @property
    def warnings(self) -> list[str]:
        """What to keep in mind."""
        return [str(line) for line in self._result.summary.get("warnings", [])]

    @property
    def summary(self) -> Summary | Versus:
        """All of it as plain values: the content of the JSON file that `save` writes."""
        return self._result.summary

    @property
    def pictures(self) -> list[str]:
        """What `plot` knows."""
        return list(self._pictures())

    def plot(self, picture: str = "") -> "Figure":
        """A picture of the report as a plotly Figure; the first of `pictures` if none is named.

        Raises `LabrigError` for a picture that there is not.
        """
        return drawn(self._pictures(), picture)

    def save(self, folder: AnyPath | None = None) -> Path:
        """Write the JSON and report.html into `folder`, as the command line does; returns the report's path.

        Raises `LabrigError` where none is named, or a file has its name.
        """
        from labrig._json import write_json

        if folder is None:
            raise LabrigError(f'save: name the folder to write into, such as save("{self.name}")')
        folder = Path(folder)
        if folder.is_file():
            raise LabrigError(f"save: {folder} is a file, where a folder is needed; choose another name")
        folder.mkdir(parents=True, exist_ok=True)
        write_json(self._result.summary, folder / f"{self.name}.json")
        return self._write_report(folder)

    @abstractmethod
    def headline(self) -> str:
        """What came out, in one sentence."""

    def said(self) -> list[str]:
        """What belongs to the headline, in further lines."""
        return []

    def __repr__(self) -> str:
        errors = [
            f"error, {unit} rms: " + ", ".join(f"{name} {value:.3g}" for name, value in row.dropna().items())
            for unit, row in self.errors.iterrows()
        ]
        lines = [f"{type(self).__name__}: {self.headline()}", *self.said(), *errors]
        return "\n".join([*lines, *(f"note: {line}" for line in self.warnings)])

    def _repr_html_(self) -> str:
        """What a notebook shows: the sentences, the errors, the places that stand out, and what to keep in mind."""
        from html import escape

        from pandas import DataFrame

        headline, *said = map(escape, (self.headline(), *self.said()))
        errors = self.errors if len(self.errors) > 1 else DataFrame([self.error])
        shown = [errors.to_html(**{**_TABLE, "index": len(errors) > 1})]
        shown += [table.to_html(**_TABLE) for table in self._shown() if len(table)]
        notes = "".join(f"<li>{escape(line)}</li>" for line in self.warnings)
        units = "" if len(errors) > 1 else f"{escape(self.units)} "
        return (
            f"<p><b>{headline}</b></p>{''.join(f'<p>{line}</p>' for line in said)}"
            f"<p>error, {units}rms</p>{''.join(shown)}{f'<ul>{notes}</ul>' if notes else ''}"
        )

    @abstractmethod
    def _shown(self) -> "list[DataFrame]":
        """The tables that a notebook shows below the errors."""

    @abstractmethod
    def _pictures(self) -> "dict[str, Callable[[], Drawn]]": ...

    @abstractmethod
    def _write_report(self, folder: Path) -> Path: ...


class ModelAnswer(Answer["Result"]):
    """Base of what says something of one model: `Comparison`, `Diagnosis` and `Improvement`."""

    @property
    def where(self) -> "DataFrame":
        """Where the model fails: `group`, `name`, `error` in `units`, `share` of the whole, `clear` of the noise."""
        from pandas import DataFrame

        columns = ["group", "name", "error", "share", "clear"]
        return DataFrame(self._result.where, columns=columns)

    @property
    def values(self) -> list[str]:
        """What was fitted of each effect, one line each, with standard deviations."""
        from labrig.view import value_lines

        return list(value_lines(self._result))

    @property
    def summary(self) -> Summary:
        """All of it as plain values: the content of the JSON file that `save` writes."""
        return self._result.summary

    def headline(self) -> str:
        """What came out, in one sentence."""
        from labrig.view import note

        return note(self._result.summary).headline

    def _shown(self) -> "list[DataFrame]":
        return [self.where.loc[self.where["clear"].astype(bool)].head(5)]

    def _pictures(self) -> "dict[str, Callable[[], Drawn]]":
        from labrig.view import pictures_of

        return pictures_of(self._result)

    def _write_report(self, folder: Path) -> Path:
        from labrig.view import write_report

        return write_report(self._result, folder)
