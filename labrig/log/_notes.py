"""What people say of a run, in notes.yaml in its folder, so that it goes where the run goes."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_serializer

from labrig._errors import LabrigError
from labrig._fields import check_fields
from labrig._text import listed, with_sessions
from labrig._yaml import read_yaml
from labrig.log._segments import segment_paths

NOTES = "notes.yaml"


class Notes(BaseModel):
    """The content of notes.yaml."""

    model_config = ConfigDict(extra="forbid", coerce_numbers_to_str=True)

    tags: list[str] = Field(default_factory=list)
    notes: list[str] = Field(default_factory=list)
    ruled_out: dict[str, list[str]] = Field(default_factory=dict)
    """Effects that somebody saw to it cannot act, each with the sessions in which; empty: in all of the run."""

    @property
    def ruled_out_in_words(self) -> str:
        """What is ruled out, `contact, frame (in s1)`; empty where nothing is."""
        return ", ".join(with_sessions(name, own) for name, own in sorted(self.ruled_out.items()))

    @field_validator("ruled_out", mode="before")
    @classmethod
    def _names_alone(cls, value: Any) -> Any:
        """Names alone are effects that cannot act in all of the run; a session may stand without brackets."""
        if value is None or isinstance(value, str):
            value = [] if value is None else [value]
        if isinstance(value, list) and all(isinstance(name, str) for name in value):
            return {name: [] for name in value}
        if not isinstance(value, dict):
            return value
        return {
            name: [] if own is None else own if isinstance(own, list) else [own]
            for name, own in value.items()
        }

    @field_validator("ruled_out")
    @classmethod
    def _named(cls, value: dict[str, list[str]]) -> dict[str, list[str]]:
        for name in value:
            if not name.isidentifier():
                raise ValueError(f"{name!r} is no name of an effect; labrig effects list has them")
        return value

    @model_serializer(mode="wrap")
    def _said(self, handler: Any) -> dict[str, Any]:
        content: dict[str, Any] = handler(self)
        return content if content["ruled_out"] else {k: v for k, v in content.items() if k != "ruled_out"}


def read_notes(run: Path) -> Notes:
    """What people say of a run folder; raises `LabrigError` if its notes.yaml is damaged."""
    path = run / NOTES
    if not path.exists():
        return Notes()
    return check_fields(Notes, read_yaml(path, "file of notes", begins="tags: [...]"), str(path), path)


def ruled_out_in(run: Path, sessions: Sequence[str]) -> list[str] | None:
    """The effects that were ruled out in each capture, of captures in these sessions, a text each with spaces between
    names; None where none was.

    `run` is a run folder, or a log file in one. Raises `LabrigError` where its notes.yaml is damaged, or names a
    session that the run does not have.
    """
    folder = run if run.is_dir() else run.parent
    if folder is not run and run.name not in {path.name for _, path in segment_paths(folder)}:
        return None
    notes, there = read_notes(folder), list(dict.fromkeys(sessions))
    for name, own in notes.ruled_out.items():
        for session in own:
            if session not in there:
                raise LabrigError(
                    f"{folder / NOTES}: {name} is ruled out in session {session!r}, and the run has "
                    f"{listed(there, 'and')}; labrig rule-out {folder} {name} --remove takes it back"
                )
    if not notes.ruled_out:
        return None
    return [
        " ".join(name for name, own in notes.ruled_out.items() if not own or session in own)
        for session in sessions
    ]
