"""What there is in a run, in short: for lists and for `labrig show`."""

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from labrig.log._layout import unpack_metadata
from labrig.log._segments import LoadedSegment, load_segments, read_run_yaml, segment_paths
from labrig.log._topics import Topic
from labrig.run_contents import StepResult


@dataclass
class RunSummary:
    """A run in short. `state` is `completed`, why it stopped, or that it was not closed; times in s.

    `missed` captures do not count because their pressures did not follow; `off_kpa` is how far each chamber was from
    its set-point at worst in those that do. `frames` arrived in all recordings, `frames_lost` were taken and did not.
    """

    folder: Path
    run: dict[str, Any]
    state: str
    captures: int
    steps_done: int
    sessions: int
    duration_s: float
    size_bytes: int
    warnings: list[str] = field(default_factory=list)
    step_kinds: dict[str, int] = field(default_factory=dict)
    stillness_mm_s: list[float] = field(default_factory=list)
    missed: int = 0
    off_kpa: dict[str, float] = field(default_factory=dict)
    frames: int = 0
    frames_lost: int = 0
    messages: dict[str, int] = field(default_factory=dict)
    events: list[tuple[float, str]] = field(default_factory=list)


def summarise(folder: Path) -> RunSummary:
    """Read a run's log and sum it up; raises `LabrigError` when there is nothing to read."""
    segments, warnings = load_segments(folder)
    steps = [step for loaded in segments for step in _done_steps(loaded)]
    kinds = Counter(kind for _, kind, _ in steps)
    captured = [session for loaded in segments for session in _table_captures(loaded)]
    messages: Counter[str] = Counter()
    for loaded in segments:
        for topic, of_topic in loaded.segment.topics.items():
            messages[topic.name.lower()] += len(of_topic.payload)
    times = [of.time_ns for loaded in segments for of in loaded.segment.topics.values() if of.time_ns]
    files = [folder] if folder.is_file() else [path for _, path in segment_paths(folder)]
    return RunSummary(
        folder=folder,
        run=segments[0].run or (read_run_yaml(folder) if folder.is_dir() else {}),
        state=state_of(segments[-1]),
        captures=sum(kind == "record" and not values.get("missed") for _, kind, values in steps)
        + len(captured),
        steps_done=len({index for index, _, _ in steps}),
        sessions=len(set(captured) or {loaded.layout.session for loaded in segments}),
        duration_s=(max(t[-1] for t in times) - min(t[0] for t in times)) * 1e-9 if times else 0.0,
        size_bytes=sum(path.stat().st_size for path in files),
        warnings=warnings,
        step_kinds=dict(kinds),
        stillness_mm_s=[values["speed_mm_s"] for _, kind, values in steps if kind == "settle"],
        missed=sum(kind == "record" and bool(values.get("missed")) for _, kind, values in steps),
        off_kpa=_off_kpa(segments[0].layout.chambers, [values for _, _, values in steps]),
        frames=sum(values.get("frames", 0) for _, _, values in steps),
        frames_lost=sum(values.get("frames_lost", 0) for _, _, values in steps),
        messages=dict(messages),
        events=[event for loaded in segments for event in _events(loaded)],
    )


def _table_captures(loaded: LoadedSegment) -> list[str]:
    """The session of each capture of an imported table, whichever way it was written; none for any other run."""
    from labrig.log._table_blocks import read_blocks
    from labrig_schema.step_pb2 import Capture

    captures = loaded.messages(Topic.CAPTURE).payload
    if captures:
        return [Capture.FromString(payload).session for payload in captures]
    return [str(session) for session in read_blocks(loaded).get("session", ())]


def _off_kpa(chambers: Sequence[str], results: list[StepResult]) -> dict[str, float]:
    """The largest difference of what each chamber reached and was asked for, over the captures that count."""
    worst: dict[str, float] = {}
    for values in results:
        if values.get("missed") or "reached_kpa" not in values:
            continue
        for name, asked, reached in zip(
            chambers, values["commanded_kpa"], values["reached_kpa"], strict=True
        ):
            if reached is not None:
                worst[name] = max(worst.get(name, 0.0), abs(reached - asked))
    return worst


def _done_steps(loaded: LoadedSegment) -> list[tuple[int, str, StepResult]]:
    from labrig_schema.step_pb2 import Step

    steps = [Step.FromString(payload) for payload in loaded.messages(Topic.STEP).payload]
    return [
        (step.index, step.kind, json.loads(step.result_json) if step.result_json else {})
        for step in steps
        if step.state == Step.DONE
    ]


def _events(loaded: LoadedSegment) -> list[tuple[float, str]]:
    from foxglove_schemas_protobuf.Log_pb2 import Log

    messages = loaded.messages(Topic.EVENTS)
    texts = [Log.FromString(payload).message for payload in messages.payload]
    return [
        (time_ns * 1e-9 - loaded.layout.start_s, text)
        for time_ns, text in zip(messages.time_ns, texts, strict=True)
    ]


def state_of(last: LoadedSegment) -> str:
    """Why the last session ended."""
    if last.layout.table:
        return "imported"
    text = unpack_metadata(last.segment.metadata.get("labrig.end", {}), str(last.segment.path))
    if text is not None:
        return str(json.loads(text)["reason"])
    return "closed" if last.segment.closed else "not closed (killed, or still going on)"
