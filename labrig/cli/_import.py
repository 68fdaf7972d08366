"""`labrig import`: somebody's own tables become a run, with their mapping or with a guess at it."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig._text import counted
from labrig.cli._app import app
from labrig.cli._places import check_folder

if TYPE_CHECKING:
    from labrig.tables import Guess


@app.command("import")
def import_(
    table: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="TABLE...",
            help="CSV, Excel, Parquet, MAT, HDF5, NPZ, TDMS, C3D, MCAP or a ROS bag; else the mapping's.",
        ),
    ] = None,
    mapping: Annotated[
        Path | None,
        typer.Option("--mapping", help="What the columns mean (MAP.yaml); left out: it is guessed."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", help="The run folder to make [default: the table's name]."),
    ] = None,
    replace: Annotated[
        bool,
        typer.Option(
            "--replace",
            help="Replace an imported run of that name; a guess, only one that came from a guess.",
        ),
    ] = False,
) -> None:
    """Make a run of somebody's own tables: sessions with the same columns, or what is joined by its clocks."""
    import labrig
    from labrig.log import import_guessed, import_table

    first = mapping or next(iter(table or ()), None)
    if first is None:
        raise labrig.LabrigError("name a table, or a mapping with --mapping")
    output = output or Path(first.stem)
    check_folder(output, "-o")
    said: list[str] = []
    if mapping is not None:
        run = import_table(mapping, output, tables=table or (), replace=replace)
    else:
        assert table is not None
        run, guess, written = import_guessed(table, output, replace=replace)
        _show(guess, written)
        said = guess.remarks
    for remark in run.attrs["warnings"]:
        if not any(remark.endswith(line) for line in said):
            typer.echo(f"note: {remark}")
    sizes = run.sizes
    observables = 3 * sizes.get("marker", 0) + sizes.get("observable", 0)
    captures, observed = counted(sizes["capture"], "capture"), counted(observables, "observable")
    sessions = counted(len(set(run["session"].values)), "session")
    typer.echo(f"{output}: {captures}, {sizes['chamber']} actuated, {observed}, {sessions}")


def _show(guess: "Guess", written: Path) -> None:
    """The guess as it was written, with what was assumed."""
    import yaml

    text = yaml.safe_dump(
        guess.mapping, sort_keys=False, default_flow_style=None, allow_unicode=True, width=110
    )
    typer.echo(f"guessed, and written to {written}:")
    for line in text.splitlines():
        typer.echo(f"  {line}")
    for remark in guess.remarks:
        typer.echo(f"note: {remark}")
