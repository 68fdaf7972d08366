"""The typer application, and how errors reach a person: one line, exit code not 0, no traceback."""

import importlib
import os
import sys

import typer

app = typer.Typer(
    name="labrig",
    help="Run a soft-robotics rig, log its campaigns, and find the physics its model is missing.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

_COMMAND_MODULES = (
    "_diagnosis",
    "_next",
    "_campaign",
    "_rig",
    "_demo",
    "_view",
    "_bench",
    "_simulate",
    "_train",
    "_ik",
    "_validate",
)


@app.callback()
def _options(debug: bool = typer.Option(False, "--debug", help="Show the traceback of an error.")) -> None:
    """Options that go before the command."""
    global _debug
    _debug = debug


_debug = False


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit; the only place where an exception becomes an exit code."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # small matrices: more threads would wait for each other
    for module in _COMMAND_MODULES:
        importlib.import_module(f"labrig.cli.{module}")
    try:
        code = app(args=arguments, standalone_mode=False)
    except typer.Exit as error:
        code = error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        print("labrig: interrupted", file=sys.stderr)
        code = 130
    except Exception as error:
        if _debug:
            raise
        exit_code = getattr(error, "exit_code", None)
        if exit_code is None:
            print(
                f"labrig: unexpected {type(error).__name__}: {error} (run again with --debug and report it)",
                file=sys.stderr,
            )
            exit_code = 1
        else:
            format_message = getattr(error, "format_message", None)
            text = format_message() if format_message else str(error)
            print(f"labrig: {' '.join(text.splitlines())}", file=sys.stderr)
        code = exit_code
    sys.exit(code if isinstance(code, int) else 0)
