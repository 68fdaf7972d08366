"""Commands: view."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app

_RUN = "A run folder, an .mcap log, an .rrd recording, or a folder that `labrig demo` made."
_MODEL = "A model file: shows its predictions and errors beside the measurements."
_SAVE = "Write the recording to this .rrd file and open nothing."
_WEB = "Serve a page for a browser on this machine, until Ctrl-C."


@app.command()
def view(
    run: Annotated[Path, typer.Argument(metavar="RUN", help=_RUN)],
    model: Annotated[Path | None, typer.Option("--model", help=_MODEL)] = None,
    save: Annotated[Path | None, typer.Option("--save", metavar="FILE", help=_SAVE)] = None,
    serve: Annotated[bool, typer.Option("--serve", help=_WEB)] = False,
) -> None:
    """Show a finished run in rerun: the surface in 3D, the pressures, and what a model makes of it."""
    from labrig.cli._view_steps import show

    show(run, model, save, serve)
