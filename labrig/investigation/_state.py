"""What an investigation knows so far, and what it does now: kept in investigation.json."""

import json
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from labrig._errors import LabrigError
from labrig.investigation_contents import (
    Confirmation,
    Doing,
    InvestigationContent,
    InvestigationSettings,
    Round,
)

if TYPE_CHECKING:
    from xarray import Dataset

STATE = "investigation.json"
HIGHEST = 0.85
"""How high a campaign goes by default, as a share of each chamber's range."""
OPEN = {"under way", "interrupted", "out of budget"}
"""States that can be gone on with; the others are `settled` and `open`."""


@dataclass(frozen=True)
class Settings:
    """What an investigation is asked for.

    `rig` and `model` are what they are called in what is said, `budget_min` the time on the rig, `highest` the highest
    pressure of a campaign, as a share of the range. `runs` were measured before; without any the first round is a
    campaign. `rig_file` is noted in each run, for `labrig run --resume`; `model_sha256` is that of the model's text.
    """

    rig: str
    model: str
    out: Path
    budget_min: float = 30.0
    seed: int = 0
    highest: float = HIGHEST
    realtime: bool = False
    runs: tuple[Path, ...] = ()
    rig_file: Path | None = None
    model_sha256: str = ""

    def content(self) -> InvestigationSettings:
        """The settings as plain values."""
        return {
            "rig": self.rig,
            "model": self.model,
            "budget_min": self.budget_min,
            "out": str(self.out),
            "seed": self.seed,
            "highest": self.highest,
            "realtime": self.realtime,
            "runs": [run.as_posix() for run in self.runs],
            "model_sha256": self.model_sha256,
        }


@dataclass
class State:
    """Everything that is known so far; `write` keeps it in investigation.json and the page."""

    settings: Settings
    state: str = "under way"
    conclusion: str = "Under way."
    units: str = ""
    rounds: list[Round] = field(default_factory=list)
    confirmation: Confirmation | None = None
    waterfall: list[Any] = field(default_factory=list)
    model: str | None = None
    warnings: list[str] = field(default_factory=list)
    now: Doing | None = None
    _opened: "list[Dataset]" = field(default_factory=list, repr=False)

    @property
    def folder(self) -> Path:
        """Where everything lies."""
        return self.settings.out

    @property
    def minutes(self) -> float:
        """Time on the rig so far."""
        return sum(r["minutes"] for r in self.rounds)

    @property
    def runs(self) -> list[Path]:
        """The folders of all runs so far, those that were given first."""
        return [
            run
            for r in self.rounds
            for run in ([Path(one) for one in r["given"]] if "given" in r else [self.folder / r["run"]])
        ]

    def opened(self) -> "list[Dataset]":
        """The runs so far, each read once."""
        from labrig.log import open_run

        for run in self.runs[len(self._opened) :]:
            self._opened.append(open_run(run))
        return list(self._opened)

    def content(self) -> InvestigationContent:
        """The content of investigation.json."""
        return {
            "state": self.state,
            "conclusion": self.conclusion,
            "units": self.units,
            "minutes": self.minutes,
            "rounds": self.rounds,
            "confirmation": self.confirmation,
            "budget_min": self.settings.budget_min,
            "waterfall": self.waterfall,
            "model": self.model,
            "warnings": self.warnings,
            "now": self.now,
            "settings": self.settings.content(),
        }

    def doing(
        self, what: str, programme: str, run: str = "", minutes: float = 0.0, captures: int = 0
    ) -> None:
        """Note in investigation.json what is being done now, for whoever looks at it meanwhile."""
        from labrig._json import write_json

        number = len(self.rounds) + 1
        self.now = {
            "what": what,
            "round": number,
            "programme": programme,
            "run": run,
            "minutes": minutes,
            "captures": captures,
            "since_s": round(time.time()),
        }
        write_json(dict(self.content()), self.folder / STATE)

    def discard(self, *, keep_folder: bool) -> bool:
        """Remove the folder, or what is in it, where nothing was measured; whether that was so."""
        if any(path.name != STATE for path in self.folder.iterdir()):
            return False
        (self.folder / STATE).unlink(missing_ok=True)
        if not keep_folder:
            self.folder.rmdir()
        return True

    def write(self) -> None:
        """Write investigation.json and report.html."""
        from labrig._json import write_json
        from labrig.view import write_investigation

        write_json(dict(self.content()), self.folder / STATE)
        write_investigation(self.content(), self.folder)

    def end(self, state: str, conclusion: str) -> None:
        """Note how it ended."""
        self.state, self.conclusion, self.now = state, conclusion, None
        self.write()


def read_state(folder: Path) -> InvestigationContent:
    """The content of a folder's investigation.json; raises `LabrigError` where there is none that can be read."""
    try:
        content = json.loads((folder / STATE).read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        content = None
    if not isinstance(content, dict) or "state" not in content:
        raise LabrigError(f"{folder} holds no investigation: there is no {STATE} that can be read")
    return cast(InvestigationContent, content)


def highest_of(folder: Path) -> float:
    """How high the investigation of a folder goes, for who goes on with it; the default where nobody wrote it down."""
    try:
        return float(read_state(folder)["settings"]["highest"])
    except (LabrigError, KeyError, TypeError, ValueError):
        return HIGHEST


def _finished(content: InvestigationContent) -> list[Round]:
    """The rounds that were done with: what was measured in the one that was cut short is there, and is not again."""
    rounds = content["rounds"]
    last = rounds[-1] if rounds else None
    if last is None or "given" in last:
        return rounds
    judged = last["programme"] != "confirmation" or (content["confirmation"] or {}).get("run") == last["run"]
    return rounds if last["verdict"] and judged else rounds[:-1]


def start_or_resume(settings: Settings, resume: bool) -> State:
    """A new state in a folder that is made, or the one that is gone on with; raises `LabrigError` for neither."""
    out = settings.out
    if out.is_file():
        raise LabrigError(f"{out} is a file; name a folder")
    if not resume:
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise LabrigError(
                f"{out} cannot be made: {error.strerror or error}; choose another folder"
            ) from None
        if any(out.iterdir()):
            raise LabrigError(
                f"{out} is not empty; choose another folder, or go on with what is there (--resume, resume=True)"
            )
        return State(settings)
    if not (out / STATE).exists() and (out / "run-1" / "run.yaml").exists():
        return State(settings)  # the power was cut in the first round
    content = read_state(out)
    if content["state"] not in OPEN:
        raise LabrigError(
            f"{out} is finished ({content['state']}): see {out / 'report.html'}, or begin anew in another folder"
        )
    began = content["settings"].get("model_sha256")
    if began and began != settings.model_sha256 and any(r["verdict"] for r in content["rounds"]):
        raise LabrigError(
            f"{settings.model} is not the model that {out} began with ({content['settings']['model']}), or was changed "
            "since: give it as it was, or begin anew in another folder with the runs of this one"
        )
    return State(
        settings,
        units=content["units"],
        rounds=_finished(content),
        confirmation=content["confirmation"],
        waterfall=content["waterfall"],
        model=content["model"],
        warnings=content["warnings"],
    )
