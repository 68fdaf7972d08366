"""`labrig import` of tables that nobody described: the mapping is guessed, and written beside the run."""

import hashlib
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._durable import in_place_of
from labrig._errors import LabrigError
from labrig._paths import check_parent
from labrig.log._import import refuse, write_import
from labrig.log._segments import load_segments, read_run_yaml, segment_paths
from labrig.tables import Guess, check_mapping, guess_mapping, guess_together

if TYPE_CHECKING:
    from xarray import Dataset

_SEAL = re.compile(r"^# As guessed: ([0-9a-f]{16});.*\n", re.MULTILINE)


def import_guessed(
    tables: Sequence[Path], output: Path, *, replace: bool = False, use: str | None = None
) -> tuple["Dataset", Guess, Path]:
    """Make a run folder of foreign tables that nobody described, alike and each a session, or joined by their clocks.

    Returns what `open_run` gives of it, the guess, and the mapping that was written beside the run, OUTPUT.map.yaml, to
    be read and corrected. A mapping that is there as it was guessed is written anew; with `replace`, so is the run that
    came from such a guess. `use` is how a person imports with the mapping, where not on the command line.

    Raises `LabrigError` when the run exists and is not to be replaced, or did not come from a guess, when the mapping
    is somebody's, or when nothing can be made of the tables: then what was to be replaced is as it was, and of a new
    run nothing is left but the mapping, where one could be guessed.
    """
    refuse(output, replace)
    check_parent(output)
    beside_it = mapping_beside(output)
    again = " --replace" if output.exists() else ""
    use = use or f"labrig import --mapping {beside_it} -o {output}{again}"
    if beside_it.exists() and not is_as_guessed(beside_it):
        raise LabrigError(
            f"{beside_it} was edited, or is no guess, and a guess does not replace it: use it ({use}) or remove it"
        )
    if output.exists() and not read_run_yaml(output).get("guessed"):
        raise LabrigError(
            f"{output} was imported with a mapping, and a guess does not replace it: choose another name, or import "
            "with the mapping"
        )
    for table in tables:
        if _is_run(table):
            raise LabrigError(f"{table} is a run already, with nothing to import: labrig show {table}")
    several = len(tables) > 1
    guess = (
        guess_together(tables, beside_it.parent) if several else guess_mapping(tables[0], beside_it.parent)
    )
    mapping = check_mapping(guess.mapping, beside_it)
    try:
        with in_place_of(beside_it):
            _write_guess(guess, beside_it)
            run = write_import(mapping, mapping.files(), beside_it, output, replace, guess)
    except LabrigError as error:
        if output.exists():
            raise LabrigError(
                f"{error}; correct the table and import it again: {output} is as it was"
            ) from error
        _write_guess(guess, beside_it)
        raise LabrigError(
            f"{error}; correct the table and import it again, or what was guessed, which is in {beside_it}, and use "
            f"it: {use}"
        ) from error
    return run, guess, beside_it


def mapping_beside(output: Path) -> Path:
    """Where the mapping of a run lies that was guessed."""
    return output.with_name(f"{output.name}.map.yaml")


def is_as_guessed(path: Path) -> bool:
    """Whether a mapping is what a guess wrote, and nobody edited it."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return False
    found = _SEAL.search(text)
    return found is not None and found[1] == _sum(_SEAL.sub("", text, count=1))


def _write_guess(guess: Guess, path: Path) -> None:
    """Write a guess as a mapping, with what it assumed, and with a sum that no longer fits once somebody edits it."""
    import yaml

    head = "# Guessed by labrig import: read it, correct it, and import again with it (--mapping).\n"
    notes = "".join(f"# {remark}\n" for remark in guess.remarks)
    text = yaml.safe_dump(
        guess.mapping, sort_keys=False, default_flow_style=None, allow_unicode=True, width=110
    )
    seal = (
        f"# As guessed: {_sum(head + notes + text)}; once this file is edited, no other guess replaces it.\n"
    )
    path.write_text(head + seal + notes + text, encoding="utf-8")


def _sum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _is_run(path: Path) -> bool:
    """Whether this is a run folder, or a log of labrig's own."""
    if path.is_dir():
        return bool(segment_paths(path))
    if path.suffix.lower() != ".mcap" or not path.is_file():
        return False
    try:
        load_segments(path)
    except LabrigError:
        return False
    return True
