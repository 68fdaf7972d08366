"""import_table: somebody's own table as a run."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._durable import in_place_of
from labrig._errors import LabrigError
from labrig._paths import check_parent, path_of, paths_of
from labrig.api._inputs import AnyPath

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

_MAPPINGS = {".yaml", ".yml"}
_KEPT = b"labrig"
"""What the metadata of a Parquet file have that labrig wrote of a DataFrame."""


def import_table(
    mapping: "AnyPath | DataFrame", output: AnyPath, tables: Any = (), *, replace: bool = False
) -> "Dataset":
    """Make a run folder of your own tables, as a MAP.yaml says what their columns mean; returns the opened run.

    Args:
        mapping: the file that says what the columns mean; or a table, whose mapping is then guessed and written beside
            the run, OUTPUT.map.yaml. A DataFrame is a table, too: it is kept beside the run, OUTPUT.frame-1.parquet.
        output: the run folder to make.
        tables: one file or several (CSV, Excel, Parquet, MAT, HDF5, NPZ, TDMS, C3D, MCAP, ROS bags) in place of those
            that the mapping names, or DataFrames; beside a table, more of its kind, each a session.
        replace: put it in the place of an imported run of that name. A guess replaces only what came from a guess, and
            no mapping that somebody edited.

    Raises:
        LabrigError: a file, a column or a unit does not exist, a value is no number, or the output exists; nothing
            is left behind then.

    Examples:
        >>> run = labrig.import_table("map.yaml", "runs/mine")
        >>> run.sizes["capture"] > 0
        True
        >>> frame = pandas.read_csv("campaign.csv")
        >>> labrig.import_table(frame, "runs/from_frame").sizes["capture"] == run.sizes["capture"]
        True
    """
    from labrig import log

    output = path_of(output, "an output", "the path of the run folder to make")
    several = list(tables) if isinstance(tables, list | tuple) else [tables]
    frames = sum(_is_frame(one) for one in [mapping, *several])
    with _kept([mapping, *several], output, replace) as (mapping, *several):
        mapping = path_of(mapping, "a mapping", "the path of a MAP.yaml or of a table, or a DataFrame")
        given = (
            paths_of(several, "a table", "its file (CSV, Parquet, C3D, ...), or a DataFrame")
            if several
            else []
        )
        if mapping.suffix.lower() not in _MAPPINGS:
            use = _use(output, frames, replace)
            return log.import_guessed([mapping, *given], output, replace=replace, use=use)[0]
        return log.import_table(mapping, output, given, replace=replace)


def _is_frame(given: Any) -> bool:
    return type(given).__name__ == "DataFrame" and hasattr(given, "to_parquet")


def _use(output: Path, frames: int, replace: bool) -> str:
    """How a guessed mapping is imported with, in Python."""
    tables = ("", ", frame", ", [frame, ...]")[min(frames, 2)]
    again = ", replace=True" if replace else ""
    return f'labrig.import_table("{output.as_posix()}.map.yaml", "{output.as_posix()}"{tables}{again})'


@contextmanager
def _kept(given: list[Any], output: Path, replace: bool) -> Iterator[list[Any]]:
    """The same with each DataFrame in a file beside the run, which goes again where nothing came of it; what it was
    to replace comes back then.
    """
    if output.exists() and not replace:
        raise LabrigError(f"{output} exists already; choose another name, or say replace=True")
    out, files = [], []
    try:
        with ExitStack() as stack:
            for one in given:
                if _is_frame(one):
                    files.append(_free(output, len(files) + 1))
                    stack.enter_context(in_place_of(files[-1]))
                    _write(one, files[-1])
                out.append(files[-1] if _is_frame(one) else one)
            yield out
    except LabrigError as error:
        raise LabrigError(_of_frames(str(error), files)) from error


def _free(output: Path, number: int) -> Path:
    """Where a DataFrame is kept; raises `LabrigError` where a file is that is none of labrig's."""
    check_parent(output)
    path = output.with_name(f"{output.name}.frame-{number}.parquet")
    if path.exists() and not _is_kept(path):
        raise LabrigError(
            f"{path} exists already, and labrig did not write it: choose another name for the run"
        )
    return path


def _of_frames(said: str, files: list[Path]) -> str:
    """What was said of the files of DataFrames that are gone again, said of the DataFrames."""
    for i, path in enumerate(files):
        frame = "the DataFrame" if len(files) == 1 else f"DataFrame {i + 1}"
        for name in (str(path.resolve()), str(path), path.name):
            said = said.replace(name, frame)
    return said


def _write(frame: "DataFrame", path: Path) -> None:
    from pyarrow import Table
    from pyarrow.parquet import write_table

    from labrig.tables import plain

    try:
        table = Table.from_pandas(plain(frame), preserve_index=False)
        write_table(table.replace_schema_metadata({**(table.schema.metadata or {}), _KEPT: b"frame"}), path)
    except LabrigError:
        raise
    except Exception as error:
        raise LabrigError(
            f"the DataFrame can't be kept as a table: {' '.join(str(error).split())}"
        ) from error


def _is_kept(path: Path) -> bool:
    """Whether a file is a DataFrame that labrig wrote beside a run."""
    from pyarrow.parquet import read_schema

    try:
        return _KEPT in (read_schema(path).metadata or {})
    except (OSError, ValueError):
        return False
