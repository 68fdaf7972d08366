"""investigate: from a model and a rig to what the model lacks, measuring whatever it takes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import wrong
from labrig._text import counted
from labrig.api._answer import drawn
from labrig.api._diagnose import effects_table
from labrig.api._inputs import AnyPath, model_of, number, positive, rig_of, runs_of
from labrig.contents import Summary
from labrig.investigation_contents import Confirmation, InvestigationContent

if TYPE_CHECKING:
    from pandas import DataFrame
    from plotly.graph_objects import Figure

    from labrig.investigation import Reporter
    from labrig.model import Model
    from labrig.view import Figure as Drawn


@dataclass(frozen=True, repr=False)
class Investigation:
    """What came out of an investigation, and every round of it; `folder` holds its runs, reports and new model.

    `state` is settled, open, out of budget or interrupted; `verdict` and `effects` are those of the last diagnosis.
    """

    folder: Path
    _content: InvestigationContent = field(repr=False)
    _diagnosis: Summary = field(repr=False)

    @classmethod
    def load(cls, folder: AnyPath) -> "Investigation":
        """Read the folder of an investigation; raises `LabrigError` where there is none, or no round in it."""
        import json

        from labrig.investigation import read_state

        folder = Path(folder)
        content = read_state(folder)
        written = [report for each in content["rounds"] if (report := each.get("report"))]
        if not written:
            raise LabrigError(f"{folder}: nothing was diagnosed yet ({content['state']})")
        path = folder / Path(written[-1]).with_name("diagnosis.json")
        try:
            diagnosis = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, json.JSONDecodeError):
            raise LabrigError(f"{path}: the last diagnosis of the investigation cannot be read") from None
        return cls(folder, content, diagnosis)

    @property
    def state(self) -> str:
        """settled (also on captures recorded after the verdict), open, out of budget or interrupted."""
        return str(self._content["state"])

    @property
    def conclusion(self) -> str:
        """What came out, in a sentence."""
        return str(self._content["conclusion"])

    @property
    def verdict(self) -> str:
        """nothing_missing, identified, multiple, confounded, unknown or underpowered: of all runs together."""
        return str(self._diagnosis.get("verdict"))

    @property
    def sure(self) -> list[str]:
        """The names of the effects that are sure."""
        return list(self._diagnosis.get("effects", []))

    @property
    def effects(self) -> "DataFrame":
        """Every effect, the most probable first, as `Diagnosis.effects` has them."""
        return effects_table(self._diagnosis)

    @property
    def units(self) -> str:
        """The unit of the errors."""
        return str(self._content["units"])

    @property
    def error(self) -> dict[str, float]:
        """Root mean square errors by name, of all runs together, in `units`."""
        return {name: float(v) for name, v in self._diagnosis["error"].items() if isinstance(v, float | int)}

    @property
    def minutes(self) -> float:
        """Time on the rig."""
        return float(self._content["minutes"])

    @property
    def rounds(self) -> "DataFrame":
        """A row for each round.

        Columns: `round`, `programme`, `captures`, `minutes`, `verdict`, `effects`, `rivals`, `error` and `floor` in
        `units`, `run` (its folder).
        """
        from pandas import DataFrame

        names = ("round", "programme", "captures", "minutes", "verdict", "effects", "rivals")
        rows = []
        for each in self._content["rounds"]:
            run = each["given"][0] if "given" in each else str(self.folder / each["run"])
            error = {"error": each["error"]["model"], "floor": each["error"]["floor"], "run": run}
            rows.append({**{name: each[name] for name in names}, **error})
        return DataFrame(rows)

    @property
    def confirmation(self) -> Confirmation | None:
        """The errors `before`, `after` and `floor` on captures recorded after the verdict, if there were any."""
        return self._content["confirmation"]

    @property
    def model(self) -> "Model | None":
        """The model with what was found, fitted to all runs; None where nothing was added."""
        from labrig.model import Model

        named = self._content["model"]
        return None if named is None else Model.load(self.folder / Path(named).name)

    @property
    def warnings(self) -> list[str]:
        """What to keep in mind."""
        return [str(line) for line in self._content["warnings"]]

    @property
    def summary(self) -> InvestigationContent:
        """All of it as plain values: the content of investigation.json."""
        return self._content

    @property
    def report(self) -> Path:
        """The page with every round."""
        return self.folder / "report.html"

    @property
    def pictures(self) -> list[str]:
        """What `plot` knows: `rounds` (error and floor, round by round), `error` (from the model to the noise)."""
        return list(self._figures())

    def plot(self, picture: str = "") -> "Figure":
        """A picture as a plotly Figure; the first of `pictures` if none is named.

        Raises `LabrigError` for a picture that there is not.
        """
        return drawn(self._figures(), picture)

    def _figures(self) -> "dict[str, Callable[[], Drawn]]":
        from labrig.view import investigation_pictures

        return investigation_pictures(self._content)

    def save(self, folder: AnyPath) -> Path:
        """Write investigation.json, all reports and the new model into another folder, without the runs.

        Returns the path of its report.html. Raises `LabrigError` for the investigation's own folder.
        """
        import shutil

        folder = Path(folder)
        if folder.resolve() == self.folder.resolve():
            raise LabrigError(f"{folder}: this is where the investigation lies; name another folder")
        folder.mkdir(parents=True, exist_ok=True)
        for source in sorted(self.folder.glob("diagnosis-*")) + sorted(self.folder.glob("next-*")):
            shutil.copytree(source, folder / source.name, dirs_exist_ok=True)
        for name in ("investigation.json", "report.html"):
            shutil.copyfile(self.folder / name, folder / name)
        if (model := self.model) is not None:
            model.save(folder / Path(str(self._content["model"])).name)
        return folder / "report.html"

    def __repr__(self) -> str:
        rounds = len(self._content["rounds"])
        return (
            f"Investigation: {self.state}, {self.verdict}. {self.conclusion}\n"
            f"{counted(rounds, 'round')}, {self.minutes:.1f} min on the rig; {self.report}"
        )

    def _repr_html_(self) -> str:
        from html import escape

        shown = self.rounds.drop(columns=["run"]).to_html(
            index=False, float_format="{:.3g}".format, border=0, na_rep="-"
        )
        said = f"{self.state}: {self.conclusion}"
        return f"<p><b>{escape(said)}</b></p>{shown}<p>{escape(str(self.report))}</p>"


def investigate(
    runs: Any,
    model: Any,
    rig: Any,
    *,
    out: AnyPath = "investigation",
    budget_min: float = 30.0,
    seed: int = 0,
    highest: float | None = None,
    resume: bool = False,
    realtime: bool = False,
    reporter: "Reporter | Callable[[str], object] | None" = None,
) -> Investigation:
    """Measure, diagnose, measure what settles the doubt, add what is missing, and confirm it on a fresh programme.

    It actuates the rig without asking, within its limits, until nothing is open or the time is used.

    Args:
        runs: what has been measured so far: one run or a list, as paths or as `labrig.open_run` gives them; None to
            measure a first campaign.
        model: a model.yaml's path, or what `labrig.Model.load` gives; it stays as it is.
        rig: a rig.yaml's path, or what `labrig.load_rig` gives.
        out: the folder for the runs, the reports and the new model.
        budget_min: time on the rig, min.
        seed: of everything that is random.
        highest: the highest pressure of a campaign, as a share of each chamber's range: 0.85, or, with `resume`, what
            it was.
        resume: go on with the investigation in `out` that was interrupted; nothing is measured twice.
        realtime: let a rig that is simulated here take as long as a real one.
        reporter: told what happens: `print` for a line each time, or a `labrig.investigation.Reporter` for more.

    Raises:
        LabrigError: a run, the model or the rig cannot be read, or they do not fit together; `out` is not empty, or
            holds nothing to go on with; another process uses it or the rig; the budget is too small; a limit would be
            broken.
        DeviceError: a device failed; the chambers are vented, and what is known is kept, for `resume`.
        KeyboardInterrupt: Ctrl-C, with the same care.

    Example:
        >>> found = labrig.investigate("runs/first", "model.yaml", "rig.yaml", budget_min=2)
        >>> found.rounds["programme"][0]
        'given'
        >>> found.effects["effect"][0]
        'hysteresis'
        >>> found.state  # with it the error falls on captures recorded after the verdict, too
        'settled'
    """
    from labrig import experiment, investigation
    from labrig.investigation import HIGHEST, Lines, Reporter

    if positive(budget_min, "budget_min", "in minutes") == float("inf"):
        raise LabrigError("budget_min inf: the time on the rig has an end, in minutes")
    if highest is None:
        highest = investigation.highest_of(Path(out)) if resume else HIGHEST
    if not 0 < (highest := number(highest, "highest", "a share of the limit")) <= 1:
        raise LabrigError(f"highest {highest:g}: a share of the limit is above 0 and at most 1")
    told = reporter if reporter is None or isinstance(reporter, Reporter) else None
    if told is None and reporter is not None:
        if not callable(reporter):
            raise wrong("a reporter", reporter, "print, or a labrig.investigation.Reporter")
        told = Lines(reporter)
    config, questioned = rig_of(rig), model_of(model).in_files()
    rig_name = str(rig) if isinstance(rig, str | Path) else f"rig {config.name}"
    given = [] if runs is None else runs_of(runs)
    for run in given:
        experiment.check_rig(config, run, rig_name)
    settings = investigation.Settings(
        rig=rig_name,
        model=str(questioned.path or "the model"),
        out=Path(out),
        budget_min=float(budget_min),
        seed=seed,
        highest=highest,
        realtime=realtime,
        runs=tuple(_folder_of(run) for run in given),
        rig_file=Path(rig) if isinstance(rig, str | Path) else None,
    )
    investigation.investigate(settings, config, questioned, resume=resume, reporter=told)
    return Investigation.load(out)


def _folder_of(run: Any) -> Path:
    """Where a run was opened from: an investigation reads it again when it is gone on with."""
    folder = run.attrs.get("run")
    if folder is None or not Path(folder).exists():
        raise LabrigError(
            "an investigation needs runs with a folder of their own; name it, such as runs/first"
        )
    return Path(folder)
