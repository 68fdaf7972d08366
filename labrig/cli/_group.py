"""A group of commands whose help is whole: it is shown where no command is named, and cuts no sentence."""

from typing import Any

import typer
from typer.core import TyperGroup


class Group(TyperGroup):
    """Commands with the first paragraph of their help, folded where a line ends."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Without any word: the whole help, and exit code 2."""
        if not args and not self.invoke_without_command:
            typer.echo(ctx.get_help())
            raise typer.Exit(2)
        return super().parse_args(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """One entry for each command, none of them cut."""
        commands = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        rows = [
            (name, " ".join((command.help or "").split("\n\n")[0].split()))
            for name, command in commands
            if command is not None and not command.hidden
        ]
        with formatter.section("Commands"):
            formatter.write_dl(rows)
