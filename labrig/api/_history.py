"""history: a rig over all its runs."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import path_of
from labrig.api._answer import drawn
from labrig.api._inputs import AnyPath, model_of, rig_of
from labrig.contents import HistoryChange, HistoryContent

if TYPE_CHECKING:
    from pandas import DataFrame
    from plotly.graph_objects import Figure

_RIG_FILES = (".yaml", ".yml")


@dataclass(frozen=True, repr=False)
class History:
    """A rig over its runs: what each says, and since when the rig is another.

    The chance of a single false change in all of it is 5 % at most, however often one looks, if runs scatter
    independently of each other; what else was logged (the group ambient) is shown and never counts as a change.
    """

    _content: HistoryContent = field(repr=False)

    @property
    def rig(self) -> str:
        """The rig's name."""
        return str(self._content["rig"])

    @property
    def runs(self) -> "DataFrame":
        """A row for each run, in order of time: `run`, `date` (UTC), `procedure`."""
        from pandas import DataFrame

        return _dated(DataFrame(self._content["runs"], columns=["run", "date", "procedure"]))

    @property
    def table(self) -> "DataFrame":
        """Everything that was read, a row for each number.

        Columns: `run`, `date`, `group` (effect, gain, error, floor, leak, zero, lost, frame, marker, ambient), `name`,
        `axis` (of places and turns, else empty), `value`, `sd`, `unit`.
        """
        from pandas import DataFrame

        runs, rows = self._content["runs"], []
        for quantity in self._content["quantities"]:
            for number, values, sd in zip(quantity["runs"], quantity["value"], quantity["sd"], strict=True):
                where = {"run": runs[number]["run"], "date": runs[number]["date"]}
                for axis, value in zip("xyz" if len(values) == 3 else ("",), values, strict=True):
                    what = {"group": quantity["group"], "name": quantity["name"], "axis": axis}
                    rows.append({**where, **what, "value": value, "sd": sd, "unit": quantity["unit"]})
        columns = ["run", "date", "group", "name", "axis", "value", "sd", "unit"]
        return _dated(DataFrame(rows, columns=columns)).astype({"sd": "float64"})

    @property
    def effects(self) -> "DataFrame":
        """Each effect of the model on each run: `run`, `date`, `effect`, `scale` (1: what the model has), `sd`."""
        columns = {"run": "run", "date": "date", "name": "effect", "value": "scale", "sd": "sd"}
        table = self.table
        own = table.loc[table["group"] == "effect", list(columns)]
        return own.set_axis(list(columns.values()), axis=1).reset_index(drop=True)

    @property
    def changes(self) -> "DataFrame":
        """What changed by more than chance, in the order in which it was noticed.

        `what` in words; `group`, `name`, `shape` (step or slope); `date`, and `earliest` and `latest` at 90 %;
        `noticed`; `before`, `after` in `unit` (of places: how far apart they are, in `after`); `since_fit`: whether it
        came after the model was fitted.
        """
        from pandas import DataFrame

        columns = ["what", "group", "name", "shape", "date", "earliest", "latest", "noticed"]
        columns += ["before", "after", "unit", "since_fit"]
        rows = [
            each | {"what": each["words"], "noticed": each["noticed_date"]} | _sizes(each)
            for each in self._content["changes"]
        ]
        table = DataFrame(rows, columns=columns)
        for name in ("date", "earliest", "latest", "noticed"):
            table = _dated(table, name)
        return table

    @property
    def warnings(self) -> list[str]:
        """What to keep in mind."""
        from labrig.view import history_notes

        return history_notes(self._content)

    @property
    def summary(self) -> HistoryContent:
        """All of it as plain values: the content of history.json."""
        return self._content

    @property
    def pictures(self) -> list[str]:
        """What `plot` knows."""
        from labrig.view import history_pictures

        return list(history_pictures(self._content))

    def plot(self, picture: str = "") -> "Figure":
        """A picture of the report as a plotly Figure; the first of `pictures` if none is named.

        Raises `LabrigError` for a picture that there is not.
        """
        from labrig.view import history_pictures

        return drawn(history_pictures(self._content), picture)

    def save(self, folder: AnyPath) -> Path:
        """Write history.json, history.png and report.html into `folder`; returns the report's path."""
        from labrig._json import write_json
        from labrig.view import write_history

        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        write_json(dict(self._content), folder / "history.json")
        return write_history(self._content, folder)

    def headline(self) -> str:
        """What came out, in a sentence."""
        from labrig.view import history_headline

        return history_headline(self._content)

    def __repr__(self) -> str:
        return f"History: {self.headline()}"

    def _repr_html_(self) -> str:
        """What a notebook shows: the sentence, and the changes."""
        from html import escape

        shown = self.changes[["what", "date", "noticed"]]
        table = shown.to_html(index=False, border=0) if len(shown) else ""
        return f"<p><b>{escape(self.headline())}</b></p>{table}"


def history(
    rig: Any,
    model: Any,
    *,
    runs: AnyPath = "runs",
    where: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> History:
    """All runs of a rig: how large each effect of a model was, the noise, leaks, sensors and markers, and what changed.

    Each run is read once; what it says is kept beside it, so that the next call is quick.

    Args:
        rig: the rig's name as its runs have it, or a rig.yaml's path, or what `labrig.load_rig` gives.
        model: a model.yaml's path, or what `labrig.Model.load` gives.
        runs: the folder that holds the runs, as for `labrig.runs`.
        where: a condition on the runs, as for `labrig.runs`: ``"started >= '2026-07'"``.
        progress: called with how many runs of how many were read.

    Raises:
        LabrigError: there is no such folder, it holds no runs of the rig, or none that fits the model.

    Example:
        >>> found = labrig.history("bench", "model.yaml")
        >>> list(found.runs["procedure"])
        ['capture', 'capture', 'programme']
        >>> found.changes.empty
        True
        >>> found.save("history").name
        'report.html'
    """
    from labrig import age

    name = _rig_name(rig)
    known = model_of(model).in_files()
    folder = path_of(runs, "a folder of runs", "its path, such as runs")
    rows = age.rows_of_rig(folder, name, where)
    read, left_out = age.read_rows(folder, rows, known, progress)
    if not read:
        raise LabrigError(f"none of the {len(rows)} runs of {name} fits the model: {left_out[0]['why']}")
    return History(age.summary_of(name, known, read, left_out))


def _rig_name(given: Any) -> str:
    """The name of a rig that is named, or described."""
    if isinstance(given, str) and Path(given).suffix not in _RIG_FILES:
        return given
    return rig_of(given).name


def _sizes(change: HistoryChange) -> dict[str, float]:
    from math import dist

    if len(change["before"]) == 1:
        return {"before": change["before"][0], "after": change["after"][0]}
    return {"before": 0.0, "after": dist(change["before"], change["after"])}


def _dated(table: "DataFrame", name: str = "date") -> "DataFrame":
    """The table with a column of texts as moments in UTC."""
    from pandas import to_datetime

    table[name] = to_datetime(table[name], utc=True, format="%Y-%m-%d %H:%M")
    return table
