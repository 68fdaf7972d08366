"""import_table: somebody's own table as a run."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import check_parent, path_of, paths_of
from labrig.api._inputs import Place

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

_MAPPINGS = {".yaml", ".yml"}


def import_table(
    mapping: "Place | DataFrame", output: Place, tables: Any = (), *, replace: bool = False
) -> "Dataset":
    """Make a run folder of your own tables, as a MAP.yaml says what their columns mean; returns the opened run.

    Args:
        mapping: the file that says what the columns mean; or a table, whose mapping is then guessed and written beside
            the run, OUTPUT.map.yaml. A DataFrame is a table, too: it is kept beside the run, OUTPUT.frame-1.parquet.
        output: the run folder to make.
        tables: one file or several (CSV, Excel, Parquet, MAT, HDF5, NPZ, TDMS, C3D, MCAP, ROS bags) in place of those
            that the mapping names, or DataFrames; beside a table, more of its kind, each a session.
        replace: put it in the place of an imported run of that name; needs a mapping.

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
    with _kept([mapping, *several], output, replace) as (mapping, *several):
        mapping = path_of(mapping, "a mapping", "the path of a MAP.yaml or of a table, or a DataFrame")
        given = (
            paths_of(several, "a table", "its file (CSV, Parquet, C3D, ...), or a DataFrame")
            if several
            else []
        )
        if mapping.suffix.lower() not in _MAPPINGS and mapping.exists():
            if replace:
                raise LabrigError(
                    "replace: say what the columns mean with a MAP.yaml; a guess replaces nothing"
                )
            return log.import_guessed([mapping, *given], output)[0]
        return log.import_table(mapping, output, given, replace=replace)


@contextmanager
def _kept(given: list[Any], output: Path, replace: bool) -> Iterator[list[Any]]:
    """The same with each DataFrame in a file beside the run, which goes again where no mapping came to name it,
    and whose former content comes back where nothing came of the new one."""
    if output.exists() and not replace:
        raise LabrigError(f"{output} exists already; choose another name or remove it")
    files: list[Path] = []
    try:
        out = []
        for one in given:
            if type(one).__name__ == "DataFrame" and hasattr(one, "to_parquet"):
                check_parent(output)
                path = output.with_name(f"{output.name}.frame-{len(files) + 1}.parquet")
                if path.exists() and not replace:
                    raise LabrigError(f"{path} exists already: choose another name for the run, or remove it")
                files.append(path)
                if path.exists():
                    path.replace(_before(path))
                _write(one, path)
                one = path
            out.append(one)
        yield out
    except BaseException:
        from labrig.log import mapping_beside

        for file in files:
            if _before(file).exists():
                _before(file).replace(file)
            elif not mapping_beside(output).exists():
                file.unlink(missing_ok=True)
        raise
    for file in files:
        _before(file).unlink(missing_ok=True)


def _before(file: Path) -> Path:
    """Where the table of a run that is being replaced waits, until the new one is in its place."""
    return file.with_name(f".{file.name}.before")


def _write(frame: "DataFrame", path: Path) -> None:
    if frame.index.name or frame.index.dtype.kind in "mM":
        frame = frame.reset_index()
    try:
        frame.rename(columns=str).to_parquet(path, index=False)
    except Exception as error:
        path.unlink(missing_ok=True)
        raise LabrigError(
            f"the DataFrame can't be kept as a table: {' '.join(str(error).split())}"
        ) from error
