"""Makes a whole run of a damaged one: a copy in which every file is complete and indexed."""

import json
import os
import shutil
import tempfile
from pathlib import Path

from labrig._errors import LabrigError
from labrig.log._layout import unpack_metadata
from labrig.log._segments import LoadedSegment, load_segments, segment_path
from labrig.log._topics import Topic
from labrig.log._writer import LogWriter


def recover(source: Path, target: Path) -> list[str]:
    """Copy everything that is whole in `source` (a run or an .mcap file) to the new run `target`.

    Returns what was lost, one line each; nothing, if `source` was whole. The original stays as it is. `target`
    appears whole or not at all. Raises `LabrigError` when nothing can be read or `target` exists.
    """
    if target.exists():
        raise LabrigError(f"{target} exists already; choose another name or remove it")
    segments, lost = load_segments(source)
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=f".{target.name}.", suffix=".partial", dir=target.parent))
    try:
        for number, loaded in enumerate(segments):
            _copy_segment(loaded, segment_path(partial, number))
        if source.is_dir():
            _copy_rest(source, partial)
        partial.chmod(0o755)
        os.rename(partial, target)  # noqa: PTH104  (replaces nothing: a folder that appeared meanwhile stays)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    return lost


def _copy_segment(loaded: LoadedSegment, path: Path) -> None:
    writer = LogWriter(path, loaded.layout, loaded.run)
    try:
        order = sorted(
            (time_ns, topic, index)
            for topic, messages in loaded.segment.topics.items()
            if topic != Topic.PLAN  # the writer has written that already
            for index, time_ns in enumerate(messages.time_ns)
        )
        for time_ns, topic, index in order:
            writer.raw(topic, time_ns, loaded.segment.topics[topic].payload[index])
    finally:
        end = unpack_metadata(loaded.segment.metadata.get("labrig.end", {}), str(path))
        writer.close(json.loads(end)["reason"] if end is not None else "recovered")


def _copy_rest(source: Path, target: Path) -> None:
    """run.yaml, scans and whatever else lies in the run, but for the log itself."""
    for path in source.iterdir():
        if path.is_dir():
            shutil.copytree(path, target / path.name)
        elif not path.name.startswith("log.") and not path.name.endswith(".partial"):
            shutil.copyfile(path, target / path.name)
