"""The segments of a run: which there are, what they say of themselves, and all their messages together."""

import json
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from labrig._errors import LabrigError
from labrig.log._layout import Layout, layout_from_text, unpack_metadata
from labrig.log._scan import Messages, Segment, read_segment
from labrig.log._topics import Topic

_NAME = re.compile(r"log\.(\d{3,})\.mcap")


@dataclass
class LoadedSegment:
    """A segment and its layout."""

    number: int
    segment: Segment
    layout: Layout
    run: dict[str, Any]

    def messages(self, topic: Topic) -> Messages:
        """The messages of a topic; none is an empty record."""
        return self.segment.topics.get(topic, Messages())


def sessions(segments: list[LoadedSegment]) -> list[LoadedSegment]:
    """The segments of each session as one: a long session is spread over several files."""
    merged: list[LoadedSegment] = []
    for loaded in segments:
        if merged and merged[-1].layout.session == loaded.layout.session:
            merged[-1] = _joined(merged[-1], loaded)
        else:
            merged.append(loaded)
    return merged


def _joined(first: LoadedSegment, second: LoadedSegment) -> LoadedSegment:
    topics = dict(first.segment.topics)
    for topic, more in second.segment.topics.items():
        old = topics.get(topic, Messages())
        topics[topic] = Messages(
            old.time_ns + more.time_ns, old.payload + more.payload, old.sequence + more.sequence
        )
    return replace(first, segment=replace(first.segment, topics=topics, closed=second.segment.closed))


def last_logged_s(folder: Path) -> float:
    """The time of the last message of a run on the run's clock, s; 0 if there is none."""
    segments, _ = load_segments(folder)
    times = [of.time_ns[-1] for loaded in segments for of in loaded.segment.topics.values() if of.time_ns]
    return max(times, default=0) * 1e-9


def segment_paths(folder: Path) -> list[tuple[int, Path]]:
    """The segments of a run folder by their numbers."""
    found = [(int(match[1]), path) for path in folder.iterdir() if (match := _NAME.fullmatch(path.name))]
    return sorted(found)


def is_segment(name: str) -> bool:
    """Whether a file is a segment, by its name."""
    return _NAME.fullmatch(name) is not None


def segment_path(folder: Path, number: int) -> Path:
    """The name of a segment."""
    return folder / f"log.{number:03d}.mcap"


def load_segments(path: Path) -> tuple[list[LoadedSegment], list[str]]:
    """Read every segment of a run folder, or one .mcap file; returns them and what was lost.

    Raises `LabrigError` when there is nothing to read.
    """
    path = Path(path)
    if not path.exists():
        raise LabrigError(f"{path} does not exist; name a run folder or an .mcap file")
    numbered = [(0, path)] if path.is_file() else segment_paths(path)
    if not numbered:
        below = next((one for one in sorted(path.glob("*/")) if one.is_dir() and segment_paths(one)), None)
        hint = f"; did you mean {below}?" if below is not None else ""
        raise LabrigError(f"{path} is not a run: it holds no log.000.mcap{hint}")
    warnings = [] if path.is_file() else _missing(path, [number for number, _ in numbered])
    loaded, unreadable = [], []
    for number, file in numbered:
        try:
            segment = read_segment(file)
        except LabrigError as error:
            unreadable.append(str(error))
            continue
        loaded.append(_with_layout(number, segment, path))
        warnings += segment.warnings
    if not loaded:
        raise LabrigError(unreadable[0])
    return loaded, warnings + unreadable


def _missing(folder: Path, numbers: list[int]) -> list[str]:
    absent = sorted(set(range(numbers[-1] + 1)) - set(numbers))
    return [f"{segment_path(folder, number).name} is missing; what it held is lost" for number in absent]


def _with_layout(number: int, segment: Segment, path: Path) -> LoadedSegment:
    run_text = unpack_metadata(segment.metadata.get("labrig.run", {}), str(segment.path))
    layout_text = unpack_metadata(segment.metadata.get("labrig.layout", {}), str(segment.path))
    if layout_text is None:
        layout_text = _spare_layout(segment)
        segment.warnings.append(f"{segment.path.name}: its first record is damaged; its copy was used")
    run = json.loads(run_text) if run_text is not None else {}
    if not run and path.is_dir():
        run = read_run_yaml(path)
    return LoadedSegment(number, segment, layout_from_text(layout_text), run)


def _spare_layout(segment: Segment) -> str:
    """The second copy of the layout, which stands in /plan, inside a chunk with a checksum."""
    from labrig_schema.step_pb2 import Plan

    for payload in segment.topics.get(Topic.PLAN, Messages()).payload:
        if text := Plan.FromString(payload).layout_json:
            return text
    raise LabrigError(
        f"{segment.path} is an MCAP file, but no log of labrig's that can be read (it names no chambers); "
        "use `labrig import` for tables of other tools"
    )


def read_run_yaml(folder: Path) -> dict[str, Any]:
    """What run.yaml says; empty when it is absent or damaged."""
    try:
        content = yaml.safe_load((folder / "run.yaml").read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return {}
    return content if isinstance(content, dict) else {}
