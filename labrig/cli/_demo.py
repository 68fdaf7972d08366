"""Commands: demo."""

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli._app import app

_HIDE = "What the simulated rig hides: an effect, or nothing. Without it the seed chooses."
_OUT = "Folder to make; another name is chosen where it exists."


@app.command()
def demo(
    hide: Annotated[str, typer.Option(help=_HIDE)] = "",
    seed: Annotated[int, typer.Option(min=0, help="Seed of everything that is random.")] = 0,
    out: Annotated[Path, typer.Option(help=_OUT)] = Path("labrig-demo"),
) -> None:
    """Run a campaign on a simulated rig that hides something, and find what its model lacks."""
    from labrig.cli._demo_steps import run_demo

    run_demo(hide, seed, out)
