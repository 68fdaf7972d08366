"""Commands: workbench."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app

_FOLDER = "The folder with your runs and models."
_RIG = "A rig to run experiments on from the page that opens."
_HOST = "Listen here instead of on this computer only; whoever has the address can then work in the folder."


@app.command()
def workbench(
    folder: Annotated[Path, typer.Argument(metavar="[FOLDER]", help=_FOLDER)] = Path(),
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Else the first free one from 8765.")
    ] = None,
    host: Annotated[str, typer.Option(help=_HOST)] = "127.0.0.1",
    rig: Annotated[Path | None, typer.Option("--rig", metavar="RIG.YAML", help=_RIG)] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
) -> None:
    """Compare, find the missing effect, add it and watch the error fall, in the browser."""
    from labrig.cli._workbench_steps import serve

    serve(folder, host, port, rig, browser=not no_browser)
