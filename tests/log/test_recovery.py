"""A log survives being cut anywhere and any byte being flipped: what is whole is read, what is lost is said."""

from pathlib import Path

import numpy as np
import pytest

from labrig import LabrigError, open_run
from labrig.log import Topic, load_segments

CUTS = 800
FLIPS = 400


def _captures(path: Path) -> tuple[int, list[str]]:
    segments, warnings = load_segments(path)
    return len(segments[0].messages(Topic.STEP).payload), warnings


def test_a_file_cut_at_any_byte_keeps_every_durable_capture(small_log, tmp_path: Path) -> None:
    """Hundreds of cuts: whatever was durable before the cut is read, and that the file is cut is said."""
    whole = (small_log.folder / "log.000.mcap").read_bytes()
    path = tmp_path / "cut.mcap"
    cuts = np.unique(np.linspace(1, len(whole) - 1, CUTS).astype(int))
    assert len(cuts) == CUTS
    for cut in cuts:
        path.write_bytes(whole[:cut])
        durable = sum(end <= cut for end in small_log.durable_bytes)
        if cut < small_log.first_chunk_bytes:
            with pytest.raises(LabrigError, match=r"holds no whole chunk|is not an MCAP file"):
                _captures(path)
            continue
        captures, warnings = _captures(path)
        assert captures >= durable
        assert any("not closed" in warning for warning in warnings)


def test_a_cut_run_opens_with_what_is_left(small_log, tmp_path: Path) -> None:
    """The Dataset of a cut file is that of its whole captures, and its warning names the bytes."""
    whole = (small_log.folder / "log.000.mcap").read_bytes()
    cut = small_log.durable_bytes[3] + 100
    path = tmp_path / "log.000.mcap"
    path.write_bytes(whole[:cut])
    run = open_run(path)
    full = open_run(small_log.folder)
    assert run["position_mm"].equals(full["position_mm"][:4])
    assert len(run.attrs["warnings"]) == 1
    assert run.attrs["warnings"][0].startswith(
        "log.000.mcap: not closed (the run was killed or goes on, or the file was cut); the last "
    )


def test_a_flipped_byte_is_never_silent(small_log, tmp_path: Path) -> None:
    """With any one byte wrong, the Dataset is the same as before or a warning says what is lost."""
    original = open_run(small_log.folder)
    whole = (small_log.folder / "log.000.mcap").read_bytes()
    rng = np.random.default_rng(5)
    folder = tmp_path / "run"
    folder.mkdir()
    silent, kept = 0, []
    for place in np.sort(rng.choice(len(whole), FLIPS, replace=False)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        (folder / "log.000.mcap").write_bytes(damaged)
        run = open_run(folder)
        kept.append(run.sizes["capture"])
        if not run.attrs["warnings"]:
            silent += 1
            assert run.equals(original), f"byte {place}"
    assert 0 < silent < FLIPS
    assert min(kept) >= 5  # one chunk is lost at most, and a chunk is one step here


@pytest.mark.parametrize("what", ["layout", "schemas"])
def test_each_copy_of_the_layout_is_enough(small_log, tmp_path: Path, what: str) -> None:
    """The layout stands in a metadata record and in /plan; either may be destroyed."""
    whole = bytearray((small_log.folder / "log.000.mcap").read_bytes())
    place = (
        whole.index(b"labrig.layout") + 60 if what == "layout" else whole.index(b"\x04\x00\x00\x00zstd") + 60
    )
    whole[place : place + 8] = b"\xff" * 8
    path = tmp_path / "log.000.mcap"
    path.write_bytes(whole)
    run = open_run(path)
    assert run.equals(open_run(small_log.folder))
    assert run.attrs["warnings"][0].startswith("log.000.mcap: ")


def test_a_destroyed_length_costs_one_chunk(small_log, tmp_path: Path) -> None:
    """A record whose length is nonsense is skipped by searching for the next chunk with a right checksum."""
    whole = bytearray((small_log.folder / "log.000.mcap").read_bytes())
    chunk = small_log.durable_bytes[1]
    chunk = whole.index(b"\x04\x00\x00\x00zstd", chunk) - 37
    whole[chunk + 1 : chunk + 9] = b"\xee" * 8
    path = tmp_path / "log.000.mcap"
    path.write_bytes(whole)
    run = open_run(path)
    assert run["commanded"][:, 0].to_numpy().tolist() == [0.0, 10.0, 30.0, 40.0, 50.0]
    assert any("that part is lost" in warning for warning in run.attrs["warnings"])
    assert any("messages on /step are lost" in warning for warning in run.attrs["warnings"])


def test_a_chunk_too_short_to_be_one_is_passed_over(small_log, tmp_path: Path) -> None:
    """What calls itself a chunk at the end of a file that was not closed costs nothing that is whole."""
    whole = (small_log.folder / "log.000.mcap").read_bytes()
    cut = small_log.durable_bytes[-1]
    path = tmp_path / "log.000.mcap"
    path.write_bytes(whole[:cut])
    before = open_run(path)
    path.write_bytes(whole[:cut] + b"\x06" + (3).to_bytes(8, "little") + bytes(3))
    after = open_run(path)
    assert after.equals(before)
    assert any("not closed" in warning for warning in after.attrs["warnings"])
