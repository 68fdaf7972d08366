"""Commands: ik."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app


@app.command()
def ik(
    targets: Annotated[
        list[Path], typer.Argument(metavar="TARGET...", help="Shapes: OBJ, PLY, STL, or points in XYZ.")
    ],
    model: Annotated[
        Path, typer.Option("--model", help="forward.pt, sim2real.pt, or a model file (model.yaml).")
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results.")] = Path("ik"),
    rig: Annotated[Path | None, typer.Option(help="A rig file, for its limits.")] = None,
    unit: Annotated[
        str | None, typer.Option(help="Unit of the targets (mm, cm, m, inch), where it is not clear.")
    ] = None,
    workers: Annotated[int, typer.Option(min=0, help="Processes; 0 for one per core.")] = 1,
    cluster: Annotated[str | None, typer.Option(help="Address of a Dask scheduler, tcp://...")] = None,
) -> None:
    """Find the pressures that bring a surface closest to given shapes, and where it cannot follow them."""
    from labrig.cli._ik_steps import do_ik

    do_ik(targets, model, out, rig, unit, workers, cluster)
