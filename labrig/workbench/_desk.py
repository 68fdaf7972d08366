"""What all parts of the workbench share: the folder it is about, its secrets, its jobs, what it tells its pages."""

import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePath, PurePosixPath

from labrig._errors import LabrigError
from labrig.rig import RigConfig, load_rig
from labrig.workbench._events import Events
from labrig.workbench._jobs import Jobs, command_line
from labrig.workbench._vent_button import VentButton
from labrig.workbench._worker import Worker

OWN = ".workbench"
"""The folder below the desk's in which the workbench keeps what is its own: jobs, dropped files."""


@dataclass(frozen=True)
class Desk:
    """A folder of runs that is worked on.

    `token` opens its pages; `rig_token` goes only to the page that was opened for the rig, and moves it. `planner`
    makes plans while `worker` fits; `at_end` is called when the server ends. `rig` is what `rig_file` said at first.
    """

    folder: Path
    jobs: Jobs
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)
    rig_token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)
    rig_file: Path | None = None
    rig: RigConfig | None = field(default=None, repr=False)
    events: Events = field(default_factory=Events, repr=False)
    vent: VentButton | None = field(default=None, repr=False)
    worker: Worker = field(default_factory=Worker, repr=False)
    planner: Worker = field(default_factory=Worker, repr=False)
    at_end: list[Callable[[], None]] = field(default_factory=list, repr=False)

    def path(self, relative: str) -> Path:
        """The file or folder of this name below the desk's folder, there or not.

        Raises `LabrigError` for a name that leads out of it, by `..`, as an absolute path or by a link, and for one
        that commands take for an option.
        """
        if "\0" in relative:  # which no file's name has, and `resolve` does not take
            raise LabrigError(f"{relative!r}: is no name of a file")
        parts = PurePosixPath(relative.replace("\\", "/"))
        if str(parts).startswith("-"):
            raise LabrigError(f"{relative}: begins with -, as options of commands do; give it another name")
        if parts.is_absolute() or self.leads_out(parts):
            raise LabrigError(f"{relative}: lies outside the workbench's folder {self.folder}")
        return (self.folder / parts).resolve()

    def leads_out(self, relative: PurePath | str) -> bool:
        """Whether a path below the folder leads out of it, by `..` or by a link."""
        return not (self.folder / relative).resolve().is_relative_to(self.folder)

    def known_rig(self) -> RigConfig | None:
        """The rig as its file says now, or as it said at first where somebody has broken it since.

        To see and to end what goes on, which a slip in the file must not prevent; nothing is begun with it.
        """
        try:
            return self.rig_file and load_rig(self.rig_file)
        except LabrigError:
            return self.rig

    def command(self, words: Sequence[object]) -> str:
        """A labrig command as it is typed in the folder."""
        return command_line(words)

    def existing(self, relative: str) -> Path:
        """As `path`, of what there is; raises `LabrigError` where there is none."""
        found = self.path(relative)
        if not found.exists():
            raise LabrigError(f"there is no {relative} in {self.folder}")
        return found

    def name(self, path: Path) -> str:
        """A path below the folder as its pages and commands call it, with `/`."""
        return path.resolve().relative_to(self.folder).as_posix()


def open_desk(folder: Path, rig_file: Path | None = None) -> Desk:
    """The desk of a folder; raises `LabrigError` where there is none, or a rig file is none."""
    if not folder.is_dir():
        raise LabrigError(f"{folder}: there is no such folder; name one with runs in it, or an empty one")
    if rig_file is not None and not rig_file.is_file():
        raise LabrigError(f"{rig_file}: there is no such rig file")
    rig = rig_file and load_rig(rig_file)
    folder = folder.resolve()
    jobs = Jobs(folder, folder / OWN / "jobs")
    return Desk(folder, jobs, rig_file=rig_file and rig_file.resolve(), rig=rig)
