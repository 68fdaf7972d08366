"""import_table: somebody's own table as a run."""

from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import path_of, paths_of
from labrig.api._inputs import Place

if TYPE_CHECKING:
    from xarray import Dataset

_MAPPINGS = {".yaml", ".yml"}


def import_table(mapping: Place, output: Place, tables: Any = (), *, replace: bool = False) -> "Dataset":
    """Make a run folder of your own tables, as a MAP.yaml says what their columns mean; returns the opened run.

    Args:
        mapping: the file that says what the columns mean; or a table, whose mapping is then guessed and written beside
            the run, OUTPUT.map.yaml.
        output: the run folder to make.
        tables: one file or several (CSV, Excel, Parquet, MAT, HDF5, NPZ, TDMS, C3D, MCAP, ROS bags) in place of those
            that the mapping names; beside a table, more of its kind, each a session.
        replace: put it in the place of an imported run of that name; needs a mapping.

    Raises:
        LabrigError: a file, a column or a unit does not exist, a value is no number, or the output exists; nothing
            is left behind then.

    Examples:
        >>> run = labrig.import_table("map.yaml", "runs/mine")
        >>> run.sizes["capture"] > 0
        True
    """
    from labrig import log

    mapping = path_of(mapping, "a mapping", "the path of a MAP.yaml, or of a table")
    output = path_of(output, "an output", "the path of the run folder to make")
    given = [] if tables == () else paths_of(tables, "a table", "its file (CSV, Parquet, C3D, ...)")
    if mapping.suffix.lower() not in _MAPPINGS and mapping.exists():
        if replace:
            raise LabrigError("replace: say what the columns mean with a MAP.yaml; a guess replaces nothing")
        return log.import_guessed([mapping, *given], output)[0]
    return log.import_table(mapping, output, given, replace=replace)
