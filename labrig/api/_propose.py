"""propose_experiment: what to measure next, as a programme that the rig can run."""

from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._near import meant
from labrig._text import counted
from labrig.api._diagnose import Diagnosis
from labrig.api._inputs import AnyPath, model_of, positive, rig_of, runs_of
from labrig.contents import ProgrammePoint, Proposed
from labrig.tables import factor

PROGRAMME = "programme.csv"

if TYPE_CHECKING:
    from pandas import DataFrame
    from plotly.graph_objects import Figure
    from xarray import Dataset

    from labrig.experiment import Experiment


@dataclass(frozen=True, repr=False)
class Proposal:
    """The programme that tells what a diagnosis leaves open apart best, per minute in the laboratory."""

    _experiment: "Experiment" = field(repr=False)

    @property
    def minutes(self) -> float:
        """How long the programme takes."""
        return float(self.summary["minutes"])

    @property
    def separates(self) -> list[str]:
        """The effects that it tells apart; empty where it looks for what is not named yet."""
        return list(self.summary["separates"])

    @property
    def to_rule_out(self) -> list[str]:
        """The effects that somebody at the rig can rule out, each with set-points to measure then (`without`)."""
        return [hand["effect"] for hand in self.summary["by_hand"] if "captures" in hand]

    @property
    def why(self) -> str:
        """Why this one, in a sentence."""
        return str(self.summary["why"])

    @property
    def points(self) -> "DataFrame":
        """The set-points in order: a column for each chamber, in the runs' unit, then `hold_s`, `repeat`, `label`;
        without those that need somebody at the rig first (`summary["by_hand"]`), as an unattended run has them.
        """
        return self._table(self._experiment.programme())

    def without(self, effect: str) -> "DataFrame":
        """The set-points to be measured while somebody has ruled an effect out (`summary["by_hand"]`), likewise.

        Raises `LabrigError` where it is none of those that are offered.
        """
        offered = {each.effect: each for each in self._experiment.again}
        if effect == self.summary.get("ruled_out"):
            return self.points
        if effect not in offered:
            raise LabrigError(f"{effect} is not to be ruled out here{meant(effect, self.to_rule_out)}")
        return self._table(self._experiment.without(offered[effect]))

    def _table(self, points: "list[ProgrammePoint]") -> "DataFrame":
        from pandas import DataFrame

        rows = []
        for point in points:
            if point.get("by_hand"):
                continue
            named = dict.fromkeys(self._experiment.chambers, 0.0) | point.get("pressure_kpa", {})
            rows.append({**named, **{key: point.get(key, "") for key in ("hold_s", "repeat", "label")}})
        return DataFrame(rows)

    @property
    def warnings(self) -> list[str]:
        """What to keep in mind."""
        return [str(line) for line in self.summary["warnings"]]

    @property
    def summary(self) -> Proposed:
        """All of it as plain values: the content of next.json."""
        return self._experiment.summary

    def procedure(self) -> dict[str, Any]:
        """The parameters of the procedure `programme`: `labrig.run("programme", rig, **proposal.procedure())`.

        Its pressures are in kPa, as a rig's are, whatever the runs' unit is. Raises `LabrigError` where the set-points
        are no pressures.
        """
        return {"points": self._kpa(self._experiment.programme())}

    def _kpa(self, points: "list[ProgrammePoint]") -> "list[ProgrammePoint]":
        kpa = {name: _in_kpa(self._unit_of(name)) for name in self._experiment.chambers}
        for point in points:
            given = point.get("pressure_kpa", {})
            point["pressure_kpa"] = {c: float(f"{kpa[c] * p:.9g}") for c, p in given.items()}
        return points

    def _unit_of(self, chamber: str) -> str:
        """The unit of an input's set-points: that of all, or its own where they differ."""
        return self.summary.get("units_of", {}).get(chamber) or self.summary["actuation_units"] or "1"

    def plot(self) -> "Figure":
        """Each chamber's set-point over the time of the programme, as a plotly Figure."""
        from plotly.graph_objects import Figure

        from labrig.view import programme_figure

        return Figure(programme_figure(self._experiment.programme(), self.summary["actuation_units"]))

    def save(self, folder: AnyPath, procedure: AnyPath | None = None) -> Path:
        """Write next.json, programme.csv (a row for each set-point) and report.html into `folder`, as the command line
        does; returns the report's path. What is to be measured while an effect is ruled out is beside it,
        programme-without-contact.csv.

        `procedure` is a file (.yaml) to write the programme to, for `labrig run`. Raises `LabrigError` for another
        ending, and, once all else is written, where the set-points are no pressures.
        """
        from labrig._json import write_json
        from labrig.experiment import write_procedure
        from labrig.view import write_experiment

        folder, summary, refused = Path(folder), deepcopy(self.summary), None
        if procedure is not None:
            check_procedure_file(Path(procedure))
        folder.mkdir(parents=True, exist_ok=True)
        if procedure is not None:
            try:
                write_procedure(self._experiment, self.procedure()["points"], Path(procedure))
                summary["procedure"] = str(procedure)
                for each in self._experiment.again:
                    path = without_path(Path(procedure), each.effect)
                    write_procedure(self._experiment, self._kpa(self._experiment.without(each)), path, each)
                    for hand in summary["by_hand"]:
                        if hand["effect"] == each.effect and "captures" in hand:
                            hand["procedure"] = path.as_posix()
            except LabrigError as error:
                refused = error
        write_json(dict(summary), folder / "next.json")
        in_unit = {name: f"{name} [{self._unit_of(name)}]" for name in self._experiment.chambers}
        self.points.rename(columns=in_unit).to_csv(folder / PROGRAMME, index=False)
        for each in self._experiment.again:
            own = without_path(folder / PROGRAMME, each.effect)
            self.without(each.effect).rename(columns=in_unit).to_csv(own, index=False)
        report = write_experiment(summary, self._experiment.programme(), folder)
        if refused is not None:
            raise LabrigError(
                f"{refused}: no procedure file was written; {folder / PROGRAMME} has them, {report} shows them"
            )
        return report

    def __repr__(self) -> str:
        apart = " from ".join(self.separates) or "what is open"
        return f"Proposal: {counted(self.summary['captures'], 'capture')}, {self.minutes:.1f} min, to tell {apart}"

    def _repr_html_(self) -> str:
        from html import escape

        return f"<p><b>{escape(repr(self))}</b></p><p>{escape(self.why)}</p>{self.points.to_html(border=0)}"


def without_path(path: Path, effect: str) -> Path:
    """Where the set-points are written that are measured while an effect is ruled out: beside the others."""
    return path.with_name(f"{path.stem}-without-{effect}{path.suffix}")


def check_procedure_file(path: Path) -> None:
    """Raise `LabrigError` for a procedure file that `labrig run` would not read as one."""
    if path.suffix not in {".yaml", ".yml"}:
        raise LabrigError(f"{path}: a procedure file ends in .yaml")


def _check_same(diagnosis: Diagnosis, runs: "list[Dataset]") -> None:
    """Raise `LabrigError` for a diagnosis of other runs, as far as these have an identity."""
    known = [run.attrs["run_id"] for run in runs if "run_id" in run.attrs]
    of = diagnosis.summary.get("runs", [])
    if known and of and sorted(known) != sorted(each["id"] for each in of):
        named = ", ".join(each["run"] for each in of)
        raise LabrigError(f"the diagnosis is one of {named}: give the diagnosis of these runs, or none")


def _in_kpa(unit: str) -> float:
    """How many kPa one of a unit is; raises `LabrigError` where it is none of pressure."""
    try:
        return factor(unit, "kPa", "set-points")
    except LabrigError:
        raise LabrigError(
            f"a rig's procedure is in kPa, and these set-points are in {'no unit' if unit == '1' else unit}"
        ) from None


def propose_experiment(
    runs: Any,
    model: Any,
    *,
    rig: Any = None,
    diagnosis: Diagnosis | None = None,
    minutes: float = 10.0,
    tolerance: float | None = None,
) -> Proposal:
    """The programme that separates what a diagnosis leaves open, best per minute.

    Args:
        runs: one run or a list, as paths or as `labrig.open_run` gives them.
        model: a model.yaml's path, what `labrig.Model.load` gives, or a function as `labrig.Model.of` takes it.
        rig: a rig.yaml's path, or what `labrig.load_rig` gives: its limits hold, and a dry run on it says how long it
            takes; by default the limits that the runs state.
        diagnosis: that of these runs; it is made where it is not given.
        minutes: the longest that the programme may take.
        tolerance: the smallest effect that matters, in the units of the observables; not beside a `diagnosis`, which
            has its own.

    Raises:
        NothingToDoError: the diagnosis leaves nothing open, or nothing that a programme could tell; a `LabrigError`.
        LabrigError: no programme of this rig would tell, the time is too short for any, or the rig is not the one of
            the runs.

    Example:
        >>> next = labrig.propose_experiment("runs/on_off", "model.yaml", rig="rig.yaml", minutes=3)
        >>> next.minutes < 3.5
        True
        >>> folder = labrig.run("programme", "rig.yaml", out="runs/second", **next.procedure())
        >>> labrig.open_run(folder).sizes["capture"] == len(next.points)
        True
    """
    from labrig import experiment as core

    positive(minutes, "minutes", "without a unit")
    if tolerance is not None:
        positive(tolerance, "tolerance", "in the units of the observables")
    opened, questioned = runs_of(runs), model_of(model)
    if diagnosis is not None:
        _check_same(diagnosis, opened)
    config = None if rig is None else rig_of(rig)
    if config is not None:
        for run in opened:
            core.check_rig(config, run, str(rig) if isinstance(rig, str | Path) else "")
    experiment = core.propose_experiment(
        opened,
        questioned,
        summary=None if diagnosis is None else diagnosis.summary,
        limits=None if config is None else core.limits_of(config),
        minutes=minutes,
        tolerance=tolerance,
    )
    return Proposal(experiment if config is None else core.on_rig(experiment, config))
