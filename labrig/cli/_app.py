"""The typer application, and how errors reach a person: one line, exit code not 0, no traceback."""

import importlib
import os
import sys
import traceback

import typer

from labrig.cli._complaints import INTERRUPTED, complaint, exit_code
from labrig.cli._group import Group
from labrig.cli._places import check_named

app = typer.Typer(
    name="labrig",
    cls=Group,
    help="Run a soft-robotics rig, log its campaigns, and find the physics its model is missing.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

_COMMAND_MODULES = (
    "_diagnosis",
    "_import",
    "_next",
    "_investigate",
    "_campaign",
    "_history",
    "_rig",
    "_demo",
    "_view",
    "_bench",
    "_simulate",
    "_train",
    "_ik",
    "_validate",
    "_workbench",
)
_DEBUG = "--debug"


def _version(asked: bool) -> None:
    if asked:
        from labrig import __version__

        typer.echo(f"labrig {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    debug: bool = typer.Option(
        False, _DEBUG, help="Show the traceback of an error; also behind the command."
    ),
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Show the version and exit."
    ),
) -> None:
    """Options that go before the command; `main` takes --debug wherever it stands."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit; the only place where an exception becomes an exit code."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # small matrices: more threads would wait for each other
    given = sys.argv[1:] if arguments is None else arguments
    words = [word for word in given if word != _DEBUG]
    for module in _COMMAND_MODULES:
        importlib.import_module(f"labrig.cli.{module}")
    try:
        check_named(words)
        code = app(args=words, standalone_mode=False, prog_name="labrig")
        sys.stdout.flush()
        if code == INTERRUPTED:  # what typer makes of Ctrl-C, and says nothing
            print("labrig: interrupted", file=sys.stderr)
    except typer.Exit as error:
        code = error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        print("labrig: interrupted", file=sys.stderr)
        code = INTERRUPTED
    except BrokenPipeError:  # whoever read the output has ended, as in `labrig runs | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    except Exception as error:
        if len(words) < len(given):
            traceback.print_exc()
        print(f"labrig: {complaint(error)}", file=sys.stderr)
        code = exit_code(error)
    sys.exit(code if isinstance(code, int) else 0)
