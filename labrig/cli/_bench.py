"""Commands: bench."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app
from labrig.cli._group import Group
from labrig.cli._places import check_file, check_folder

bench = typer.Typer(help="Blind campaigns: hide an effect, and see whether it is found.", cls=Group)
app.add_typer(bench, name="bench")


@bench.command("draw")
def draw_campaign(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for table, mapping, model and truth.")],
    class_name: Annotated[
        str, typer.Option("--class", help="Kind of campaign: null, single, ...")
    ] = "single",
    seed: Annotated[int, typer.Option(min=0, help="Another seed is another campaign.")] = 0,
    half: Annotated[
        str,
        typer.Option(help="Whose rigs and laws: development, exam, or a portion, third to twelfth."),
    ] = "development",
    captures: Annotated[int | None, typer.Option(min=8, help="About how many, else chance says.")] = None,
) -> None:
    """Write one blind campaign as plain files: table.csv, map.yaml, base.py, model.yaml, and truth.json."""
    from labrig.bench import draw, write_campaign

    check_folder(out)
    write_campaign(draw(class_name, seed, half, captures=captures), out)
    typer.echo(
        f"{out}: table.csv, map.yaml, model.yaml (import, then diagnose); truth.json says what is hidden"
    )


@bench.command("blind")
def blind(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for records and report.")],
    half: Annotated[
        str,
        typer.Option(help="Whose rigs and laws: development, exam, both, or a portion, third to twelfth."),
    ] = "development",
    classes: Annotated[str, typer.Option(help="Classes, with commas between them, or all.")] = "all",
    count: Annotated[
        int | None, typer.Option("--n", min=1, help="Campaigns of each class; else what its figures need.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="First seed; each campaign has one of its own.")] = 0,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    cluster: Annotated[
        str | None, typer.Option(help="Dask scheduler (tcp://host:8786) in place of processes.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where the folder was left.")] = False,
    without: Annotated[str, typer.Option(help="Effects to delete from the library, with commas.")] = "",
    baselines: Annotated[bool, typer.Option(help="Run the baselines beside it.")] = True,
    reveal: Annotated[
        bool,
        typer.Option("--reveal", help="Say of the exam too what failed, by law and rig: once a release."),
    ] = False,
    results: Annotated[
        Path | None, typer.Option(help="Markdown file whose section 'Blind benchmark' is to be written.")
    ] = None,
    record: Annotated[
        Path | None, typer.Option(help="File to write: how often each verdict was right (track_record.json).")
    ] = None,
) -> None:
    """Hide effects in many drawn campaigns, diagnose each, and report how often the verdict is right."""
    from rich.progress import Progress

    from labrig._errors import LabrigError
    from labrig.bench import (
        CLASSES,
        HALVES,
        lines,
        plan,
        read_records,
        run_blind,
        summarise,
        tables,
        write_report,
        write_results,
        write_track_records,
        wrong_lines,
    )
    from labrig.bench._run import key_of
    from labrig.cli._console import new_console

    check_folder(out)
    _check_results(results)
    if record is not None:
        check_file(record, "--record")
    names = list(CLASSES) if classes == "all" else _names(classes)
    halves = list(HALVES) if half == "both" else [half]
    if not names:
        raise LabrigError(f"bench: --classes {classes}: names no class")
    todo = plan(names, count, seed, halves)
    asked = {key_of(*one) for one in todo}
    console = new_console()
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("campaigns", total=len(todo))
        if resume:
            progress.advance(task, sum(r["key"] in asked for r in read_records(out)))
        for _ in run_blind(todo, out, jobs, resume, baselines, tuple(_names(without)), cluster):
            progress.advance(task)
    records = read_records(out)
    if failed := sum("baselines_failed" in record for record in records):
        console.print(
            f"the baselines failed in {failed} campaigns: see baselines_failed in {out / 'campaigns.jsonl'}"
        )
    summary = summarise(records, reveal)
    write_report(summary, out)
    for part in tables(summary):
        console.print(part)
    for line in [*lines(summary), *wrong_lines(summary)]:
        console.print(line)
    drawn = ", ".join(sorted(path.name for path in out.glob("*confusion.png")))
    console.print(f"{out}: campaigns.jsonl, summary.json" + (f", {drawn}" if drawn else ""))
    which = f" --half {half}" + ("" if classes == "all" else f" --classes {','.join(names)}")
    each = f" --n {count}" if count else ""
    if record is not None:
        write_track_records(records, record, f"labrig bench blind{which}{each} --seed {seed}")
    if results is not None:
        others = {r["truth"]["class"] for r in records if r["key"] not in asked}
        more = f", and more of {', '.join(sorted(others))} with `--resume`" if others else ""
        write_results(summary, results, f"`labrig bench blind{which}{each} --seed {seed}`{more}")


@bench.command("learn")
def learn(
    out: Annotated[Path, typer.Option("--out", "-o", help="The file to write: spectra.json.")],
    count: Annotated[int, typer.Option("--n", min=20, help="Campaigns of one effect each.")] = 400,
    seed: Annotated[int, typer.Option(min=0, help="First seed; each campaign has one of its own.")] = 0,
    portion: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=N", help="Campaigns of a portion beside them: third=180; may be repeated."
        ),
    ] = None,
) -> None:
    """Learn how large which member of each effect's family is, from the laws of the development half."""
    from labrig.bench import learn_all, write_spectra

    check_file(out, "--out")
    beside = _portions(portion or [])
    counts = {"development": count} | beside
    how = f"labrig bench learn --n {count} --seed {seed}"
    how += "".join(f" --portion {name}={n}" for name, n in beside.items())
    write_spectra(learn_all({half: range(seed, seed + n) for half, n in counts.items()}), out, how)
    typer.echo(f"{out}: learnt from {sum(counts.values())} campaigns")


@bench.command("calibrate")
def calibrate(
    out: Annotated[Path, typer.Option("--out", "-o", help="The file to write: calibration.json.")],
    count: Annotated[int, typer.Option("--n", min=20, help="Campaigns of each portion.")] = 150,
    seed: Annotated[int, typer.Option(min=0, help="First seed; each campaign has one of its own.")] = 0,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where it was left.")] = False,
) -> None:
    """Count how often names were there, of the laws in no spectrum, and learn how probable that makes them; what is
    said of each campaign's names is kept beside the file (calibration.names.jsonl).
    """
    from rich.progress import track

    from labrig.bench import calibration_plan, run_calibrate, surprise, write_calibration
    from labrig.cli._console import new_console

    check_file(out, "--out")
    todo, said = calibration_plan(count, seed), []
    console = new_console(highlight=False)
    counted = run_calibrate(todo, out.with_name(f"{out.stem}.names.jsonl"), jobs, resume)
    for names in track(counted, "campaigns", len(todo), console=console, transient=True):
        said += names
    write_calibration(said, out, f"labrig bench calibrate --n {count} --seed {seed}")
    alone, left_out = surprise(said)
    console.print(
        f"{out}: {len(said)} names of {len(todo)} campaigns; minus log likelihood of what was there {alone:.0f} by "
        f"evidence alone, {left_out:.0f} with each portion left out"
    )


@bench.command("rule-out")
def rule_out(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the records; what is there is kept.")],
    count: Annotated[int, typer.Option("--n", min=1, help="Campaigns of each half.")] = 40,
    seed: Annotated[int, typer.Option(min=0, help="First seed; each campaign has one of its own.")] = 0,
    half: Annotated[
        list[str] | None, typer.Option(help="Halves to draw from; by default those in no spectrum.")
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    results: Annotated[
        Path | None, typer.Option(help="Markdown file whose section 'A suspect taken away' is to be written.")
    ] = None,
) -> None:
    """Rule the likeliest suspect of drawn campaigns out and measure again: how often it is sure then, and there."""
    from rich.progress import track
    from rich.table import Table

    from labrig.bench import (
        UNLEARNT,
        ruled_out_plan,
        ruled_out_rows,
        run_ruled_out,
        write_ruled_out,
    )
    from labrig.cli._console import new_console

    check_folder(out)
    _check_results(results)
    todo = ruled_out_plan(count, seed, half or UNLEARNT)
    console = new_console(highlight=False)
    each = track(run_ruled_out(todo, out, jobs), "campaigns", len(todo), console=console, transient=True)
    tried = [one for one in each if one is not None]
    head, rows = ruled_out_rows(tried)
    table = Table(*head, box=None, pad_edge=False)
    for row in rows:
        table.add_row(*row)
    console.print(table)
    console.print(f"{len(tried)} of {len(todo)} campaigns had a suspect that somebody can rule out")
    if results is not None:
        words = " ".join(f" --half {name}" for name in half or ())
        write_ruled_out(
            tried,
            results,
            f"`labrig bench rule-out --n {count} --seed {seed}{words}`: of {len(todo)} campaigns {len(tried)} had a "
            "suspect that somebody can rule out; its set-points once more, six minutes, without it.",
        )


def _portions(given: list[str]) -> dict[str, int]:
    """How many campaigns of each portion are asked for."""
    from labrig._errors import LabrigError
    from labrig.bench import PORTIONS

    counts: dict[str, int] = {}
    for one in given:
        name, _, number = one.partition("=")
        if name not in PORTIONS or not number.isdecimal():
            raise LabrigError(f"bench: --portion {one}: NAME=N, where NAME is one of {', '.join(PORTIONS)}")
        counts[name] = int(number)
    return counts


@bench.command("settle")
def settle(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the records; what is there is kept.")],
    count: Annotated[int, typer.Option("--n", min=1, help="Confounded campaigns.")] = 20,
    seed: Annotated[int, typer.Option(min=0, help="First seed; each campaign has one of its own.")] = 0,
    minutes: Annotated[
        float, typer.Option(min=1, help="Minutes of the rig after which it is given up.")
    ] = 10.0,
    results: Annotated[
        Path | None, typer.Option(help="Markdown file whose section 'Next experiment' is to be written.")
    ] = None,
) -> None:
    """Settle confounded campaigns by proposed experiments, and by set-points at random and evenly spread."""
    from rich.table import Table

    from labrig.bench import compared_rows, run_settle, settle_records, settle_rows, write_settle
    from labrig.cli._console import new_console

    check_folder(out)
    _check_results(results)
    console = new_console(highlight=False)
    for record in run_settle(out, seed, count, minutes):
        end = f"{record['minutes']:.1f} min" if record["settled"] else f"not settled ({record['verdict']})"
        console.print(
            f"{record['seed']:4d}  {record['truth']['effects'][0]:12s} {record['strategy']:8s} {end}"
        )
    records = settle_records(out)
    for head, rows in (settle_rows(records), compared_rows(records, minutes)):
        table = Table(*head)
        for row in rows:
            table.add_row(*row)
        console.print(table)
    if results is not None:
        seeds = sorted({record["seed"] for record in records})
        how = (
            f"`labrig bench settle --n {count} --seed {seed} --minutes {minutes:g}`: {len(seeds)} campaigns, seeds "
            f"{seeds[0]} to {seeds[-1]}."
        )
        write_settle(records, results, how, minutes)


@bench.command("stopping")
def stopping(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the records; what is there is kept.")],
    count: Annotated[int, typer.Option("--n", min=1, help="Campaigns.")] = 200,
    half: Annotated[
        str,
        typer.Option(help="Whose rigs and laws: development, exam, both, or a portion, third to twelfth."),
    ] = "both",
    seed: Annotated[int, typer.Option(min=0, help="First seed; each campaign has one of its own.")] = 910_000,
    jobs: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    results: Annotated[
        Path | None, typer.Option(help="Markdown file whose section 'Stopping' is to be written.")
    ] = None,
) -> None:
    """Diagnose campaigns as they grow, and compare the verdicts where they would be stopped with those at their end."""
    from rich.progress import track
    from rich.table import Table

    from labrig.bench import (
        HALVES,
        HEAD,
        run_stopping,
        stopped_rows,
        stopping_plan,
        stopping_records,
        write_stopping,
    )
    from labrig.cli._console import new_console

    check_folder(out)
    _check_results(results)
    halves = list(HALVES) if half == "both" else [half]
    console = new_console(highlight=False)
    todo = stopping_plan(count, seed, halves)
    for _ in track(run_stopping(todo, out, jobs), "campaigns", len(todo), console=console, transient=True):
        pass
    records = stopping_records(out)
    rows = stopped_rows(records)
    table = Table(HEAD[0], *(row[0] for row in rows))
    for k, name in enumerate(HEAD[1:], 1):
        table.add_row(name, *(row[k] for row in rows))
    console.print(table)
    if results is not None:
        write_stopping(records, results, f"`labrig bench stopping --n {count} --half {half} --seed {seed}`")


@bench.command("speed")
def speed(
    captures: Annotated[str, typer.Option(help="Sizes of campaigns, with commas.")] = "100,300,1000",
    seed: Annotated[int, typer.Option(min=0, help="Another seed is another hidden effect.")] = 0,
    results: Annotated[
        Path | None, typer.Option(help="Markdown file whose section 'Speed of a diagnosis' is to be written.")
    ] = None,
) -> None:
    """Time diagnoses of campaigns of growing size: nine chambers, many markers, the whole library."""
    from labrig._errors import LabrigError
    from labrig.bench import speed_table, time_diagnosis, write_speed
    from labrig.cli._console import new_console

    try:
        sizes = [int(size) for size in _names(captures)]
    except ValueError:
        raise LabrigError(f"bench: --captures {captures}: whole numbers with commas between them") from None
    _check_results(results)
    timed = [time_diagnosis(size, seed) for size in sizes]
    new_console().print(speed_table(timed))
    if results is not None:
        write_speed(timed, results)


def _check_results(path: Path | None) -> None:
    """Raise `LabrigError` for a Markdown file that could not be written in the end."""
    if path is not None:
        check_file(path, "--results")


def _names(text: str) -> list[str]:
    """The names in a list with commas."""
    return [name.strip() for name in text.split(",") if name.strip()]
