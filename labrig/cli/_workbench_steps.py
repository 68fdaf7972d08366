"""What `labrig workbench` does: serve the page until a signal ends it, and open it in the browser."""

import importlib.util
import ipaddress
import webbrowser
from pathlib import Path

import typer

from labrig._extras import missing
from labrig.cli._signals import ending_on_signals

_LOOK_S = 1.0


def serve(folder: Path, host: str, port: int | None, rig: Path | None, browser: bool) -> None:
    """Serve the workbench of a folder; raises `LabrigError` where it cannot begin."""
    if any(importlib.util.find_spec(name) is None for name in ("starlette", "uvicorn")):
        raise missing("labrig workbench", "workbench")
    from labrig.workbench import open_desk, start

    desk = open_desk(folder, rig)
    with ending_on_signals() as ended:
        running = start(desk, host, port)
        try:
            typer.echo(f"workbench of {desk.folder}; open, or keep open in the browser:\n  {running.address}")
            if not _is_loopback(host):
                typer.echo(
                    "whoever has this address can work in the folder; it goes over the network unencrypted"
                )
            typer.echo("Ctrl-C ends")
            if browser:
                webbrowser.open(running.address)
            while not ended.wait(_LOOK_S):
                pass
        finally:
            running.stop()
    left = [job.command for job in desk.jobs.all() if job.state == "running"]
    if left:
        typer.echo(f"still at work: {'; '.join(left)}; the next workbench here shows it")


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
