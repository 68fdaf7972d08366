"""Commands: next."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app
from labrig.cli._places import check_file, check_folder, replaced


@app.command("next")
def next_(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders or .mcap files.")],
    model: Annotated[Path, typer.Option("--model", help="The model file (model.yaml).")],
    rig: Annotated[
        Path | None,
        typer.Option(
            "--rig", help="The rig that will measure it (rig.yaml); else the limits are those of the runs."
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="The procedure file to write, for labrig run.")
    ] = None,
    minutes: Annotated[float, typer.Option(help="The longest that it may take, min.")] = 10.0,
    tolerance: Annotated[
        float | None, typer.Option(help="The smallest effect that matters, in the units of the run.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the procedure file.")] = False,
    out: Annotated[
        Path, typer.Option("--out", help="Folder for next.json, programme.csv and the report.")
    ] = Path("next"),
) -> None:
    """Find the pressure programme that settles what a diagnosis leaves open, within the rig's limits.

    It becomes a table, programme.csv, and with -o a procedure file: labrig run FILE --rig RIG.yaml --dry-run, then
    without --dry-run, then labrig diagnose with the runs so far and the new one.
    """
    import labrig
    from labrig.api._propose import PROGRAMME, check_procedure_file, without_path
    from labrig.cli._tables import print_experiment

    if output is not None:
        check_procedure_file(output)
        if output.exists() and not force:
            raise labrig.LabrigError(f"{output} exists; choose another name, or overwrite it with --force")
        check_file(output)
    check_folder(out)
    proposal = labrig.propose_experiment(runs, model, rig=rig, minutes=minutes, tolerance=tolerance)
    written = {"set-points": out / PROGRAMME, "report": out / "report.html"}
    if output is not None:
        written = {"procedure": output, **written}
    lines = [f"{what}: {path}{replaced(path)}" for what, path in written.items()]
    print_experiment(proposal.summary)  # first: saving may refuse the procedure file
    proposal.save(out, output)
    typer.echo("\n".join(lines))
    if output is not None:
        typer.echo(f"to run it: labrig run {output} --rig {rig or 'RIG.yaml'} --dry-run")
        if back := proposal.summary.get("put_back"):
            typer.echo(
                f"first undo what ruled {back} out; its run is one with {back}, so nothing is ruled out in it"
            )
        for name in proposal.to_rule_out:
            path = output if name == proposal.summary.get("ruled_out") else without_path(output, name)
            run = f"labrig run {path} --rig {rig or 'RIG.yaml'} --out RUN"
            typer.echo(f"once {name} cannot act: {run}, then: labrig rule-out RUN {name}")
