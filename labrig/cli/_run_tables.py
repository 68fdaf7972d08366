"""Tables of runs, for people."""

import math
import statistics
from pathlib import Path

from rich.console import Console
from rich.table import Table

from labrig._errors import LabrigError
from labrig.cli._run_screen import duration_text
from labrig.log import RunSummary, find_runs, summarise


def print_runs(named: Path | None) -> None:
    """One line for each run below a folder: the one that is named, ./runs, or the current one."""
    folder = named or (Path("runs") if Path("runs").is_dir() else Path())
    found = find_runs(folder)
    if not found:
        where = str(folder) if folder != Path() else "there is no folder runs here, and this one"
        raise LabrigError(f"{where} holds no runs; name the folder that does: labrig runs FOLDER")
    table = Table(
        "run", "started", "procedure", "captures", "length", "size", "state", box=None, pad_edge=False
    )
    for path in found:
        try:
            table.add_row(*_row(summarise(path), path, folder))
        except LabrigError as error:
            table.add_row(_short(path, folder), "", "", "", "", "", f"unreadable: {error}")
    for column in table.columns:
        column.no_wrap = True
    _console().print(table)


def _console() -> Console:
    """As wide as the terminal; wide enough for everything where there is none."""
    console = Console(highlight=False, markup=False, soft_wrap=True)
    if not console.is_terminal:
        console.width = 240
    return console


def _short(path: Path, folder: Path) -> str:
    return str(path.relative_to(folder)) if path != folder else path.name


def _row(summary: RunSummary, path: Path, folder: Path) -> list[str]:
    run = summary.run
    planned = f"/{run['captures']}" if run.get("captures") and not run.get("closed_loop") else ""
    lost = f", {len(summary.warnings)} warnings" if summary.warnings else ""
    return [
        _short(path, folder),
        str(run.get("started", "")).replace("T", " ").removesuffix("+00:00"),
        str(run.get("procedure", "")),
        f"{summary.captures}{planned}",
        duration_text(summary.duration_s),
        f"{summary.size_bytes / 1e6:.1f} MB",
        summary.state + lost,
    ]


def print_run(path: Path) -> None:
    """Everything that a person asks of one run."""
    summary = summarise(path)
    run = summary.run
    table = Table(box=None, show_header=False, pad_edge=False)
    for name, text in _facts(summary):
        table.add_row(name, text)
    console = _console()
    console.print(table)
    parameters = run.get("parameters") or {}
    if parameters:
        console.print("parameters  " + ", ".join(f"{name} {value}" for name, value in parameters.items()))
    for time_s, text in summary.events:
        console.print(f"{max(0.0, time_s):10.1f} s  {text}")
    for warning in summary.warnings:
        console.print(f"lost: {warning}")


def _facts(summary: RunSummary) -> list[tuple[str, str]]:
    run = summary.run
    rig = run.get("rig") or {}
    planned = f" of {run['captures']}" if run.get("captures") else ""
    kinds = ", ".join(f"{count} {kind}" for kind, count in summary.step_kinds.items())
    messages = ", ".join(f"{count} {topic}" for topic, count in summary.messages.items())
    facts = [
        ("procedure", str(run.get("procedure", "unknown"))),
        ("state", summary.state),
        ("started", str(run.get("started", ""))),
        ("operator", str(run.get("operator", ""))),
        ("rig", str(rig.get("name", ""))),
        ("seed", str(run.get("seed", ""))),
        ("captures", f"{summary.captures}{planned}{_missed(summary.missed)}"),
        ("steps done", f"{summary.steps_done} ({kinds})" if kinds else str(summary.steps_done)),
        ("sessions", str(summary.sessions)),
        ("length", duration_text(summary.duration_s)),
        ("stillness", _stillness(summary.stillness_mm_s)),
        ("pressures", _followed(summary.off_kpa)),
        ("messages", messages),
        ("size", f"{summary.size_bytes / 1e6:.1f} MB"),
    ]
    return [(name, text) for name, text in facts if text]


def _missed(count: int) -> str:
    return f", and {count} whose pressures did not follow" if count else ""


def _followed(off_kpa: dict[str, float]) -> str:
    if not off_kpa:
        return ""
    name = max(off_kpa, key=lambda chamber: off_kpa[chamber])
    return f"at most {off_kpa[name]:.2g} kPa off the set-point ({name})"


def _stillness(speeds_mm_s: list[float]) -> str:
    known = [speed for speed in speeds_mm_s if math.isfinite(speed)]
    if not known:
        return ""
    return f"{statistics.median(known):.3g} mm/s at the end of the settle (median), {max(known):.3g} mm/s at worst"
