"""Tables of runs, for people."""

import math
import statistics
import sys
from pathlib import Path

from rich.cells import cell_len
from rich.console import Console
from rich.table import Table

from labrig._errors import LabrigError
from labrig._text import counted
from labrig.catalogue import UNREADABLE, Row, list_runs, write_parquet
from labrig.cli._console import new_console
from labrig.cli._lost import markers_lost
from labrig.cli._places import check_file, replaced
from labrig.cli._run_screen import duration_text
from labrig.log import RunSummary, summarise

_LONGEST_NOTE = 40


def print_runs(named: Path | None, where: str | None = None, parquet: Path | None = None) -> None:
    """One line for each run below a folder (the one that is named, ./runs, or the current one), or a Parquet file."""
    folder = named or (Path("runs") if Path("runs").is_dir() else Path())
    if parquet is not None:
        check_file(parquet, "--parquet")
    rows = _listed(folder, where)
    for row in rows:
        if row.notes.startswith(UNREADABLE):
            said = row.notes.removeprefix(UNREADABLE)
            print(f"labrig: {said}; its tags and notes are left out", file=sys.stderr)
    if not rows and not (where and list_runs(folder)):
        what = str(folder) if folder != Path() else "there is no folder runs here, and this one"
        raise LabrigError(f"{what} holds no runs; name the folder that does: labrig runs FOLDER")
    if parquet is not None:
        said = replaced(parquet)
        write_parquet(rows, parquet)
        print(f"{parquet}: {counted(len(rows), 'run')}{said}")
    elif not rows:
        print(f"no run in {folder} meets the condition {where}")
    else:
        print_lines(rows, folder)


def _listed(folder: Path, where: str | None) -> list[Row]:
    """The rows; where somebody watches, with how many logs there are still to be read."""
    status = new_console(stderr=True).status("")

    def progress(done: int, total: int) -> None:
        status.update(f"reading logs that are new or have changed: {done} of {total}")
        status.start()

    try:
        return list_runs(folder, where, progress)
    finally:
        status.stop()


def print_lines(rows: list[Row], folder: Path) -> None:
    """Rows as lines, their columns one below the other; what no run has is left out, and a rig that all have.

    Without rich's tables, which take a second for a thousand lines.
    """
    cells = {
        "run": [str(Path(row.run)) if row.run != "." else folder.resolve().name for row in rows],
        "started": [row.started for row in rows],
        "rig": [row.rig for row in rows],
        "procedure": [row.procedure for row in rows],
        "captures": [_captures(row) for row in rows],
        "length": ["" if row.length_s is None else duration_text(row.length_s) for row in rows],
        "size": ["" if row.size_mb is None else f"{row.size_mb:.1f} MB" for row in rows],
        "state": [
            _shortened(row.state) + (f", {row.warnings} warnings" if row.warnings else "") for row in rows
        ],
        "verdict": [row.verdict for row in rows],
        "error": [_error(row.error, row.units) for row in rows],
        "floor": [_error(row.floor, row.units) for row in rows],
        "tags": [" ".join(row.tags) for row in rows],
        "notes": [_shortened(row.notes) for row in rows],
        "ruled out": [row.ruled_out for row in rows],
    }
    if len(set(cells["rig"])) == 1:
        del cells["rig"]
    for name in ("verdict", "error", "floor", "tags", "notes", "ruled out"):
        if not any(cells[name]):
            del cells[name]
    columns = [_padded([name, *column]) for name, column in cells.items()]
    print("\n".join("  ".join(line).rstrip() for line in zip(*columns, strict=True)))


def _padded(cells: list[str]) -> list[str]:
    lengths = [cell_len(cell) for cell in cells]
    longest = max(lengths)
    return [cell + " " * (longest - length) for cell, length in zip(cells, lengths, strict=True)]


def _captures(row: Row) -> str:
    planned = f"/{row.planned}" if row.planned else ""
    return "" if row.captures is None else f"{row.captures}{planned}"


def _error(value: float | None, units: str) -> str:
    return "" if value is None else f"{value:.3g} {units}"


def _shortened(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _LONGEST_NOTE else line[: _LONGEST_NOTE - 3] + "..."


def _console() -> Console:
    """As wide as the terminal; wide enough for everything where there is none."""
    console = new_console(highlight=False, markup=False, soft_wrap=True)
    if not console.is_terminal:
        console.width = 240
    return console


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
    for line in markers_lost(path):
        console.print(f"markers: {line}")


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
        ("frames lost", _lost(summary.frames_lost, summary.frames)),
        ("messages", messages),
        ("size", f"{summary.size_bytes / 1e6:.1f} MB"),
    ]
    return [(name, text) for name, text in facts if text]


def _missed(count: int) -> str:
    return f", and {count} whose pressures did not follow" if count else ""


def _lost(lost: int, arrived: int) -> str:
    return f"{lost:,} of {lost + arrived:,} in the recordings" if lost else ""


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
