"""What `labrig history` and `labrig check` do and print, and the line before a campaign."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.table import Table

from labrig._errors import LabrigError
from labrig.cli._console import new_console
from labrig.contents import HistoryContent, Quantity

if TYPE_CHECKING:
    from labrig.api._history import History

_GROUP_ROWS = 3
_FIRST = 3
_ROUNDING = 1e-9


@contextmanager
def reading_progress() -> Iterator[Callable[[int, int], None]]:
    """Says how many runs were read, where somebody watches."""
    with new_console(stderr=True).status("") as status:
        yield lambda done, total: status.update(f"reading runs: {done} of {total}")


def say_if_changed(rig: str, model: Path, folder: Path) -> None:
    """One line on the error stream where a rig is no longer what a model was fitted to."""
    from labrig.age import warning
    from labrig.model import Model

    if said := warning(rig, Model.load(model), folder):
        typer.echo(f"labrig: {said}", err=True)


def do_check(rig: Path, model: Path, runs: Path, out: Path, arguments: list[str], realtime: bool) -> None:
    """Run the check, tag it, and say what it and the runs before it say."""
    from labrig.api._check import TAG
    from labrig.api._procedures import read_procedure
    from labrig.api._run import new_folder
    from labrig.cli._run_steps import Request, do_run

    _check_files(rig, model)
    folder = new_folder(read_procedure(TAG, arguments), runs)
    folders = "".join(
        f" {option} {chosen}"
        for option, chosen, usual in (("--runs", runs, "runs"), ("--out", out, "history"))
        if chosen != Path(usual)
    )
    command = f"labrig check --rig {rig} --model {model}{folders}"
    do_run(TAG, arguments, Request(rig, folder, 0, realtime, False, False, command=command))
    _conclude(folder, rig, model, runs, out)


def go_on_with_check(rig: Path, model: Path, runs: Path, out: Path, folder: Path) -> None:
    """Go on with a check that was interrupted; then as `do_check`.

    Raises:
        LabrigError: for a run that is no check, or that cannot be resumed.
    """
    from labrig.api._check import TAG
    from labrig.cli._run_steps import Request, do_resume
    from labrig.log import summarise

    _check_files(rig, model)
    if folder.is_dir() and (what := summarise(folder).run.get("procedure")) not in (TAG, None):
        raise LabrigError(f"{folder} is no check but a {what}; to resume: labrig run --resume {folder}")
    do_resume(folder, Request(rig, None, 0, False, False, False))
    _conclude(folder, rig, model, runs, out)


def _check_files(rig: Path, model: Path) -> None:
    """Raise `LabrigError` for a rig or a model that is none, before anything moves."""
    import labrig

    labrig.load_rig(rig)
    labrig.Model.load(model)


def _conclude(folder: Path, rig: Path, model: Path, runs: Path, out: Path) -> None:
    """Tag a check that is done, and say what it and the runs before it say."""
    import labrig
    from labrig.api._check import TAG
    from labrig.catalogue import tag

    tag(folder, [TAG])
    found = labrig.history(labrig.load_rig(rig), labrig.Model.load(model), runs=runs)
    print_check(found)
    typer.echo(f"report: {found.save(out)}")


def print_check(found: "History") -> None:
    """A few lines: what the newest run changed in the history, what lasts, and the table."""
    summary = found.summary
    last = len(summary["runs"]) - 1
    new = [change for change in summary["changes"] if change["noticed"] == last]
    old = [change for change in summary["changes"] if change["noticed"] != last and change["since_fit"]]
    _print_table(summary)
    for change in new:
        typer.echo(f"new: {change['words']}")
    for change in old:
        typer.echo(f"since the model was fitted: {change['words']} (noticed {change['noticed_date'][:10]})")
    if not new and not old:
        typer.echo(found.headline())
    _print_notes(found)


def print_history(found: "History") -> None:
    """What changed, line by line, and a table of first and last values."""
    _print_table(found.summary)
    for change in found.summary["changes"]:
        before = "" if change["since_fit"] else ", before the model was fitted"
        typer.echo(f"{change['words']} (noticed {change['noticed_date'][:10]}{before})")
    if not found.summary["changes"]:
        typer.echo(found.headline())
    _print_notes(found)


def _print_notes(found: "History") -> None:
    for note in found.warnings:
        typer.echo(f"note: {note}")


def _print_table(summary: HistoryContent) -> None:
    count = "1 run" if len(summary["runs"]) == 1 else f"{len(summary['runs'])} runs"
    table = Table("", "", "first runs", "last run", "changed", title=f"{summary['rig']}: {count}")
    for column in table.columns[2:4]:
        column.justify = "right"
    changed = {(c["group"], c["name"]): c["date"][:10] for c in summary["changes"]}
    for quantity in _shown(summary, set(changed)):
        first, last = _ends(summary, quantity)
        sd = quantity["sd"][-1]
        give = f" ± {_plain(sd, 2)}" if sd else ""
        key = (quantity["group"], quantity["name"])
        table.add_row(
            _labels()[quantity["group"]],
            quantity["name"],
            "" if _is_first(summary, quantity) else _plain(first, 3),
            f"{_plain(last, 3)}{give} {quantity['unit']}",
            changed.get(key, ""),
        )
    new_console().print(table)


def _plain(value: float, digits: int) -> str:
    """A number as a person reads it: what is nothing but rounding is 0."""
    return "0" if abs(value) < _ROUNDING else f"{value:.{digits}g}"


def _is_first(summary: HistoryContent, quantity: Quantity) -> bool:
    """Whether the last run is the only one of its kind, so that there are no first ones to set beside it."""
    kinds = [summary["runs"][number]["kind"] for number in quantity["runs"]]
    return len(kinds) > 1 and kinds.count(kinds[-1]) == 1


def _labels() -> dict[str, str]:
    from labrig.age import GROUPS

    return GROUPS


def _shown(summary: HistoryContent, changed: set[tuple[str, str]]) -> list[Quantity]:
    """Of each group those that changed, and if there are many only the one that is farthest from its first runs."""
    out = []
    for group in _labels():
        own = [q for q in summary["quantities"] if q["group"] == group]
        away = {q["name"]: abs(last - first) for q in own for first, last in [_ends(summary, q)]}
        few = own if len(own) <= _GROUP_ROWS else [max(own, key=lambda q: away[q["name"]])]
        out += [q for q in own if (group, q["name"]) in changed or q in few]
    return out


def _ends(summary: HistoryContent, quantity: Quantity) -> tuple[float, float]:
    """The median of a quantity's first runs of the last one's kind, and its last value; of a place the distance."""
    import numpy as np

    kind = [summary["runs"][number]["kind"] for number in quantity["runs"]]
    value = np.array(quantity["value"], float)[[each == kind[-1] for each in kind]]
    first = np.median(value[:_FIRST], axis=0)
    if value.shape[1] == 1:
        return float(first[0]), float(value[-1, 0])
    return 0.0, float(np.linalg.norm(value[-1] - first))
