"""Commands: bench."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app

bench = typer.Typer(
    help="Blind campaigns: hide an effect, and see whether it is found.", no_args_is_help=True
)
app.add_typer(bench, name="bench")


@bench.command("draw")
def draw_campaign(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for table, mapping, model and truth.")],
    class_name: Annotated[
        str, typer.Option("--class", help="Kind of campaign: null, single-1, ...")
    ] = "single-2",
    seed: Annotated[int, typer.Option(help="Another seed is another campaign.")] = 0,
) -> None:
    """Write one blind campaign as plain files: table.csv, map.yaml, base.py, model.yaml, and truth.json."""
    from labrig.bench import draw, write_campaign

    write_campaign(draw(class_name, seed), out)
    typer.echo(
        f"{out}: table.csv, map.yaml, model.yaml (import, then diagnose); truth.json says what is hidden"
    )
