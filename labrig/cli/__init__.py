"""The commands; thin: they parse, call and print. Heavy imports happen inside each command."""

from labrig.cli._app import app, main

__all__ = ["app", "main"]
