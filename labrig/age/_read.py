"""All that one run says, read once and kept beside the run."""

import hashlib
import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from labrig._errors import LabrigError
from labrig._json import write_json
from labrig.age._known import Beside, Known
from labrig.age._places import place_readings
from labrig.age._reading import Reading, ReadingContent, reading
from labrig.age._scales import GAIN, scales
from labrig.age._sensors import lost_readings, sensor_readings
from labrig.effects import rows_of
from labrig.log import open_run, read_notes, read_run_yaml, run_id, segment_paths
from labrig.model import Model, model_text

if TYPE_CHECKING:
    from xarray import Dataset

KEPT = "readings.json"
_VERSION = 3
_MOST_MODELS = 6


class Kept(TypedDict, total=False):
    """What is kept beside a run for one model: what was read of it, or why it `failed`, from which state of the log."""

    stamp: str
    began: str
    kind: str
    readings: list[ReadingContent]
    failed: str


@dataclass(frozen=True)
class RunReadings:
    """What a run says: `run` is its name in the catalogue, `time_s` when it began (s since 1970, UTC).

    Runs of one `kind` did the same programme: what a model gets wrong is the same in all of them.
    """

    run: str
    time_s: float
    kind: str
    readings: tuple[Reading, ...]

    @property
    def date(self) -> str:
        """When it began, in UTC."""
        return datetime.fromtimestamp(self.time_s, UTC).isoformat(sep=" ", timespec="minutes")[:16]

    @property
    def procedure(self) -> str:
        """What was run."""
        return self.kind.split(" ")[0]


def model_key(model: Model, reference: str = "") -> str:
    """What the readings of a run depend on beside the run: model, the files it names, the run its base is fitted to."""
    digest = hashlib.sha256(f"{_VERSION} {reference} {model_text(model.file)}".encode())
    names = [getattr(model.file.base, field, None) for field in ("file", "rig")]
    own = [f"effects/{entry.name}.py" for entry in model.file.effects]
    for name in [n for n in names if n] + own:
        path = model.folder / name
        if path.is_file():
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def read_run(folder: Path, name: str, known: Known, key: str) -> RunReadings:
    """A run's readings, from beside the run where they are kept; raises `LabrigError` where it can't be read."""
    stamp = _stamp(folder)
    content = kept(folder)
    found = content.get(key)
    if found is None or found.get("stamp") != stamp:
        found = _read(folder, known, stamp)
        _keep(folder, {**{k: v for k, v in content.items() if k != key}, key: found})
    if "failed" in found:
        raise LabrigError(str(found["failed"]))
    return from_content(name, found)


def _read(folder: Path, known: Known, stamp: str) -> Kept:
    try:
        return _content(open_run(folder), folder, known, stamp)
    except LabrigError as error:
        return {"stamp": stamp, "failed": str(error)}


def from_content(name: str, found: Kept) -> RunReadings:
    """Readings from what is kept beside a run."""
    readings = tuple(Reading.of(each) for each in found["readings"])
    began = datetime.fromisoformat(str(found["began"]))
    return RunReadings(name, began.timestamp(), str(found["kind"]), readings)


def kept(folder: Path) -> dict[str, Kept]:
    """What is kept beside a run, by `model_key`; empty where there is nothing that can be read."""
    try:
        content = json.loads((folder / KEPT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def is_current(folder: Path, found: Kept) -> bool:
    """Whether what is kept was read from the log as it is now."""
    return found.get("stamp") == _stamp(folder) and "failed" not in found


def _keep(folder: Path, content: dict[str, Kept]) -> None:
    """Write what is kept, whole or not at all; a folder that can't be written to is read again the next time."""
    newest = dict(list(content.items())[-_MOST_MODELS:])
    with suppress(OSError):
        write_json(newest, folder / KEPT)


def _stamp(folder: Path) -> str:
    """A run as it is: what it is recognised by, how long each file of its log is, and what was ruled out in it, or why
    nobody can tell; the same for a copy.
    """
    sizes = " ".join(f"{path.name} {path.stat().st_size}" for _, path in segment_paths(folder))
    try:
        without = read_notes(folder).ruled_out_in_words
    except LabrigError as error:
        without = str(error)
    return f"{run_id(folder)} {sizes}" + (f" without {without}" if without else "")


def _content(run: "Dataset", folder: Path, known: Known, stamp: str) -> Kept:
    facts = read_run_yaml(folder) if (folder / "run.yaml").exists() else {}
    return {
        "stamp": stamp,
        "began": datetime.fromtimestamp(_began_s(run, facts), UTC).isoformat(),
        "kind": _kind(run, facts),
        "readings": [each.content() for each in readings_of(run, known) if each is not None],
    }


def _began_s(run: "Dataset", facts: dict[str, Any]) -> float:
    """When a run began; raises `LabrigError` where nothing says it, since it has no place in a history then."""
    start_s = float(run.attrs.get("start_s", np.nan))
    if np.isfinite(start_s):
        return start_s
    given = facts.get("started")
    try:
        moment = given if isinstance(given, datetime) else datetime.fromisoformat(str(given))
    except ValueError:
        raise LabrigError("nothing says when it was recorded") from None
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _kind(run: "Dataset", facts: dict[str, Any]) -> str:
    name = str(facts.get("procedure") or run.attrs.get("procedure") or "import")
    parameters = json.dumps(facts.get("parameters") or {}, sort_keys=True, default=str)
    return f"{name} {hashlib.sha256(parameters.encode()).hexdigest()[:6]}"


def readings_of(run: "Dataset", known: Known) -> Iterator[Reading | None]:
    """Every reading of a run; raises `LabrigError` where the run and the model do not fit together."""
    beside = known.beside(rows_of(run))
    unit = beside.context.rows.unit[0]
    found = scales(beside)
    gain, gain_sd = found.pop(GAIN, (np.nan, np.nan))
    for name, (value, sd) in found.items():
        yield reading("effect", name, value, sd, "× model")
    yield reading("gain", "displacement", 100.0 * gain, 100.0 * gain_sd, "% of the base's")
    yield _error(beside, unit)
    fitted = beside.refitted({name: value for name, (value, _) in found.items()})
    yield _floor(fitted, unit)
    yield from sensor_readings(run)
    yield from lost_readings(run)
    yield from place_readings(fitted)


def _floor(beside: Beside, unit: str) -> Reading | None:
    """What repeats differ by that no effect of the model explains."""
    own = np.array([each == unit for each in beside.context.rows.unit])
    size = float(np.sqrt((beside.floor.mean[own] ** 2).mean()))
    freedom = int(beside.floor.freedom[own][0])
    return reading("floor", "floor", size, size / np.sqrt(2.0 * freedom) if freedom else np.nan, unit)


def _error(beside: Beside, unit: str) -> Reading | None:
    """The root mean square of what the model as it stands leaves, captures counting alike; its standard deviation is
    that by the noise of a capture, which all observables may share.
    """
    own = np.array([each == unit for each in beside.context.rows.unit])
    square = beside.residual[:, own] ** 2
    captures, index = np.unique(beside.context.rows.capture, return_inverse=True)
    rows = np.array([np.nanmean(s) if np.isfinite(s).any() else np.nan for s in square])
    each = np.array(
        [np.nanmean(rows[index == c]) for c in range(len(captures)) if np.isfinite(rows[index == c]).any()]
    )
    if not len(each):
        return None
    noise = float(np.sqrt((beside.floor.mean[own] ** 2).mean()))
    return reading("error", "error", float(np.sqrt(each.mean())), noise / np.sqrt(len(each)), unit)
