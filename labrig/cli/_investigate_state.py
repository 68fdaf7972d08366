"""What an investigation knows so far: kept in investigation.json after every step, and printed at the end."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from labrig._errors import LabrigError
from labrig.cli._places import check_folder

STATE = "investigation.json"


@dataclass(frozen=True)
class Settings:
    """The options of `labrig investigate`."""

    rig: Path
    model: Path
    budget: float
    out: Path
    seed: int
    highest: float
    realtime: bool


@dataclass
class Investigation:
    """Everything that is known so far; `write` keeps it in investigation.json and the page."""

    settings: Settings
    state: str = "under way"
    conclusion: str = "Under way."
    units: str = ""
    rounds: list[dict[str, Any]] = field(default_factory=list)
    confirmation: dict[str, Any] | None = None
    waterfall: list[Any] = field(default_factory=list)
    model: str | None = None
    warnings: list[str] = field(default_factory=list)
    _opened: list[Any] = field(default_factory=list, repr=False)

    @property
    def folder(self) -> Path:
        return self.settings.out

    @property
    def minutes(self) -> float:
        return sum(r["minutes"] for r in self.rounds)

    @property
    def runs(self) -> list[Path]:
        return [self.folder / r["run"] for r in self.rounds]

    def opened(self) -> list[Any]:
        """The runs so far, each read once."""
        import labrig

        for run in self.runs[len(self._opened) :]:
            self._opened.append(labrig.open_run(run))
        return list(self._opened)

    def content(self) -> dict[str, Any]:
        settings = {k: str(v) if isinstance(v, Path) else v for k, v in vars(self.settings).items()}
        out = {
            k: getattr(self, k) for k in ("state", "conclusion", "units", "minutes", "rounds", "confirmation")
        }
        more = {k: getattr(self, k) for k in ("waterfall", "model", "warnings")}
        return {**out, "budget_min": self.settings.budget, **more, "settings": settings}

    def write(self) -> None:
        from labrig.diagnosis import write_json
        from labrig.view import write_investigation

        write_json(self.content(), self.folder / STATE)
        write_investigation(self.content(), self.folder)

    def end(self, state: str, conclusion: str) -> None:
        self.state, self.conclusion = state, conclusion
        self.write()


def command(settings: Settings) -> str:
    """How to go on."""
    named = f"--rig {settings.rig} --model {settings.model} --budget {settings.budget:g} --out {settings.out}"
    return f"labrig investigate {named} --seed {settings.seed} --resume"


def begun(settings: Settings, resume: bool) -> Investigation:
    path = settings.out / STATE
    check_folder(settings.out)
    if not resume:
        if settings.out.exists() and any(settings.out.iterdir()):
            raise LabrigError(
                f"{settings.out} is not empty; choose another --out, or continue it with --resume"
            )
        settings.out.mkdir(parents=True, exist_ok=True)
        return Investigation(settings)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        raise LabrigError(f"{settings.out} has no investigation to resume") from None
    if content["state"] not in {"under way", "interrupted", "out of budget"}:
        raise LabrigError(
            f"{settings.out} is finished ({content['state']}): see {settings.out / 'report.html'}, or begin anew with "
            "another --out"
        )
    known = {k: content[k] for k in ("rounds", "units", "confirmation", "waterfall", "model", "warnings")}
    return Investigation(settings, **known)


def print_closing(console: Console, investigation: Investigation) -> None:
    """The table of rounds, and where things are."""
    units = investigation.units
    table = Table(
        "round",
        "programme",
        "captures",
        "min",
        "verdict",
        "effects",
        f"error, {units}",
        "floor",
        box=None,
        pad_edge=False,
    )
    for each in investigation.rounds:
        names = ", ".join(each["effects"]) + (f" (or {', '.join(each['rivals'])})" if each["rivals"] else "")
        error = each["error"]
        table.add_row(
            str(each["round"]),
            each["programme"],
            str(each["captures"]),
            f"{each['minutes']:.1f}",
            each["verdict"],
            names,
            f"{error['model']:.3g}",
            f"{error['floor']:.3g}",
        )
    console.print(table)
    console.print(f"{investigation.state}: {investigation.conclusion}", soft_wrap=True)
    console.print(f"{investigation.minutes:.1f} of {investigation.settings.budget:g} min used")
    for warning in investigation.warnings:
        console.print(f"note: {warning}", soft_wrap=True)
    if investigation.model:
        console.print(f"new model: {investigation.model}", soft_wrap=True)
    console.print(f"report: {investigation.folder / 'report.html'}", soft_wrap=True)
