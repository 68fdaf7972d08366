"""compare, diagnose, improve, import, effects: from measurements to what the model lacks."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labrig.cli._app import app
from labrig.cli._group import Group
from labrig.cli._places import check_file, check_folder, replaced

if TYPE_CHECKING:
    from labrig.api._answer import Answer
    from labrig.api._diagnose import Diagnosis
    from labrig.contents import Summary

Runs = Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders or .mcap files.")]
ModelOption = Annotated[Path, typer.Option("--model", help="The model file (model.yaml).")]
ModelsOption = Annotated[
    list[Path], typer.Option("--model", help="The model file (model.yaml); give two to compare them.")
]
OutOption = Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")]


@app.command()
def compare(runs: Runs, model: ModelsOption, out: OutOption = Path("compare")) -> None:
    """Compare a model, as it stands, with measurements and show where it fails; or two models with each other."""
    import labrig

    check_folder(out)
    if len(model) > 2:
        raise labrig.LabrigError(f"--model was given {len(model)} times; compare takes one model or two")
    if len(model) == 1:
        found = labrig.compare(runs, model[0])
        report = _saved(found, out)
        _table(found.summary, "compare")
    else:
        from labrig.cli._tables import print_versus

        found = labrig.compare(runs, model)
        report = _saved(found, out)
        print_versus(found.summary)
    _say(report)


@app.command()
def diagnose(
    runs: Runs,
    model: ModelOption,
    tolerance: Annotated[
        float | None, typer.Option(help="The smallest effect that matters, in the units of the run.")
    ] = None,
    out: OutOption = Path("diagnosis"),
) -> None:
    """Identify the physical effect that the model lacks, or report that none is missing or the data cannot decide."""
    import labrig

    if tolerance is not None and not tolerance > 0:
        raise labrig.LabrigError(f"--tolerance {tolerance:g}: must be larger than 0")
    check_folder(out)
    found = labrig.diagnose(runs, model, tolerance=tolerance)
    report = _saved(found, out)
    _table(found.summary, "diagnosis")
    _values(found)
    _say(report)
    for line in _to_add(found, runs, model):
        _say(line)


def _to_add(found: "Diagnosis", runs: Sequence[Path], model: Path) -> list[str]:
    """The commands that add what is sure, or the only name that is left, and confirm it; none where that helps not."""
    from labrig.effects import is_family
    from labrig.view import confirmed_by, has_improved, only_perhaps

    names = found.possible if only_perhaps(found.summary) else found.sure
    if found.improved is None or not names or not has_improved(found.summary):
        return []
    added = " ".join(f"--add {name}" for name in names)
    bent = [e.name for e in found.improved.file.effects if e.name in names and is_family(e.form)]
    library = found.improved.library()
    what = "see whether it predicts better" if bent else "confirm it"
    lines = [f"to add it: labrig improve {' '.join(map(str, runs))} --model {model} {added} -o improved.yaml"]
    happened = [name for name in names if library[name].of_one_rig]
    if happened:  # at a moment of these runs: another one cannot confirm it
        return [
            *lines,
            *(f"to confirm {name.replace('_', ' ')}: {library[name].experiment}" for name in happened),
        ]
    return [
        *lines,
        f"to {what}, on a run with other set-points: labrig compare NEW_RUN --model improved.yaml",
        *(
            f"to confirm that it is {name.replace('_', ' ')}, whose weights follow other laws as well: "
            f"{confirmed_by(library[name])}"
            for name in bent
        ),
    ]


@app.command()
def improve(
    runs: Runs,
    model: ModelOption,
    output: Annotated[Path, typer.Option("-o", "--output", help="The new model file.")],
    add: Annotated[list[str], typer.Option("--add", help="Effect to add; repeat the option for several.")],
    prior: Annotated[
        list[Path] | None,
        typer.Option(
            help="A model that has it, fitted on another rig or day; repeat the option for several."
        ),
    ] = None,
    spread: Annotated[
        float | None,
        typer.Option(
            help="How much it may differ from place to place, as a share of it (0.3); needs --prior."
        ),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Add it even if it does not help.")] = False,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("improve"),
) -> None:
    """Add effects to a model, fitted to the runs, and show the error before and after.

    With --prior, what other models have of them counts too, as far as it is sure; where the runs contradict it, it is
    refused.
    """
    import labrig

    if output.exists():
        raise labrig.LabrigError(f"{output}: already exists; choose another name for the new model")
    check_file(output)
    check_folder(out)
    better = labrig.improve(runs, model, add, force=force, prior=prior or None, spread=spread)
    report = _saved(better, out)
    better.model.save(output)  # last of the files, and said at once: who ends it before has no new model
    _say(f"new model: {output}")
    _table(better.summary, "improve")
    _values(better)
    if told := better.summary.get("prior"):
        _say(f"prior: {', '.join(told['sources'])}; the runs are {told['z']:.1f} standard deviations from it")
    _say(report)


effects_app = typer.Typer(cls=Group, help="The physical effects that a model can lack.")
app.add_typer(effects_app, name="effects")


@effects_app.callback(invoke_without_command=True)
def _effects(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        list_effects()


@effects_app.command("list")
def list_effects() -> None:
    """List the effects: labrig's own and those in ./effects."""
    from rich.table import Table

    from labrig.cli._console import new_console
    from labrig.effects import library

    table = Table("effect", "acts on", "signature")
    for name, effect in sorted(library().items()):
        table.add_row(name, effect.acts_on, effect.signature)
    new_console().print(table)


@effects_app.command("show")
def show_effect(name: Annotated[str, typer.Argument(metavar="NAME", help="The effect's name.")]) -> None:
    """Show one effect: meaning, parameters, signature, the experiment that isolates it."""
    from labrig.effects import get

    effect = get(name)
    _say(f"{effect.name} (acts on {effect.acts_on})\n\n{effect.meaning}\n")
    for p in effect.parameters:
        bounds = f"{p.low:g} .. {p.high:g}" if p.low > -1e300 or p.high < 1e300 else "any"
        each = "" if p.per == "one" else f", per {p.per}"
        _say(f"  {p.name} [{p.unit}], {bounds}{each}: {p.meaning}")
    _say(f"\nsignature:  {effect.signature}\nexperiment: {effect.experiment}")
    if effect.ruled_out_by:
        _say(f"ruled out:  {effect.ruled_out_by}, and measure again")
    _say(f"reference:  {effect.reference}")


@effects_app.command("new")
def new_effect(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new effect, such as humidity.")],
) -> None:
    """Write a file of your own effect that works at once; edit its formula."""
    from labrig.effects import write_template

    _say(f"{write_template(name, Path.cwd())}: edit its formula; labrig effects list shows it")


def _saved(found: "Answer[Any]", out: Path) -> str:
    """Save the results before anything is printed, which may end early (`| head`), and the line that says where."""
    said = replaced(out / "report.html")
    return f"report: {found.save(out)}{said}"


def _table(summary: "Summary", title: str) -> None:
    from labrig.cli._tables import print_summary

    print_summary(summary, title)


def _values(found: "Answer[Any]") -> None:
    for line in found.values:
        _say(line)


def _say(text: str) -> None:
    typer.echo(text)
