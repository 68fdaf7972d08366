"""Commands: view."""

from pathlib import Path
from typing import Annotated

import typer

from labrig._durable import put_at
from labrig._errors import LabrigError
from labrig.cli._app import app
from labrig.cli._places import check_file
from labrig.cli._signals import ending_on_signals

_RUN = "A run folder, an .mcap log, an .rrd recording, or a folder that `labrig demo` made."
_MODEL = "A model file: shows its predictions and errors beside the measurements."
_SAVE = "Write the recording to this .rrd file and open nothing."
_LOOK_S = 0.2
_WEB = "Serve a page for a browser on this machine, until Ctrl-C."


@app.command()
def view(
    run: Annotated[Path, typer.Argument(metavar="RUN", help=_RUN)],
    model: Annotated[Path | None, typer.Option("--model", help=_MODEL)] = None,
    save: Annotated[Path | None, typer.Option("--save", metavar="FILE", help=_SAVE)] = None,
    serve: Annotated[bool, typer.Option("--serve", help=_WEB)] = False,
) -> None:
    """Show a finished run in rerun: the surface in 3D, the pressures, and what a model makes of it."""
    show(run, model, save, serve)


def show(run: Path, model: Path | None, save: Path | None, web: bool) -> None:
    """Show `run` in a window or in a browser, or save its recording; raises `LabrigError`."""
    import shutil
    import tempfile

    if not run.exists():
        raise LabrigError(f"{run} does not exist; name a run folder, an .mcap log or an .rrd recording")
    if save is not None:
        if save.exists():
            raise LabrigError(f"{save} exists already; choose another name for the recording")
        check_file(save, "--save")
        _record(run, model, save)
        typer.echo(f"recording: {save}")
        return
    folder = Path(tempfile.mkdtemp(prefix="labrig-view-"))
    try:
        recording = _finished(run) if model is None else None
        if recording is None:
            recording = folder / f"{run.resolve().stem}.rrd"
            _record(run, model, recording)
        _watch(recording.resolve(), web)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _watch(recording: Path, web: bool) -> None:
    """A viewer of a recording, until its window is closed or a signal ends it: it never outlives this command."""
    from labrig.view import start_viewer

    with ending_on_signals() as ended:
        viewer = start_viewer(recording, web=web)
        try:
            typer.echo(f"open {viewer.page} (Ctrl-C ends)" if web else "close the viewer's window to go on")
            while viewer.process.poll() is None and not ended.wait(_LOOK_S):
                pass
        finally:
            viewer.stop()


def _finished(run: Path) -> Path | None:
    """The recording that `run` is or holds already."""
    if run.is_dir():
        found = sorted(run.glob("*.rrd"))
        return found[0] if found else None
    return run if run.suffix == ".rrd" else None


def _record(run: Path, model: Path | None, path: Path) -> None:
    import shutil

    import labrig
    from labrig.view import write_recording

    ready = _finished(run) if model is None else None
    if ready is not None:
        temporary = path.with_name(f".{path.name}.part")
        shutil.copyfile(ready, temporary)
        put_at(temporary, path)
        return
    measured = labrig.open_run(_log_of(run))
    if model is None:
        write_recording(measured, path)
        return
    from labrig.diagnosis import compare
    from labrig.model import Model

    write_recording(compare(measured, Model.load(model)), path)


def _log_of(run: Path) -> Path:
    """The run itself, or the one in the folder that a demo made."""
    inside = run / "run"
    return inside if inside.is_dir() and not any(run.glob("*.mcap")) else run
