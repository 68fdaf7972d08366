"""Workbooks: Excel's old and new files, and OpenDocument."""

from pathlib import Path

from labrig._errors import LabrigError
from labrig.tables._header import distinct, joined
from labrig.tables._mapping import Format
from labrig.tables._table import Table


def sheets(path: Path) -> dict[str, int]:
    """The sheets of a workbook and their rows, headers included."""
    book = _open(path)
    return {name: len(_cells(book, name)) for name in book.sheet_names}


def read_workbook(path: Path, how: Format) -> Table:
    """Read one sheet: `part`, else the first that has rows; raises `LabrigError` where there is none."""
    import pandas as pd

    book = _open(path)
    names = list(book.sheet_names)
    if how.part is not None and how.part not in names:
        raise LabrigError(f"{path}: has no sheet {how.part!r}; it has {', '.join(names)}")
    chosen = [how.part] if how.part is not None else names
    cells = next((found for name in chosen if (found := _cells(book, name))), [])
    if max(how.groups, default=0) > how.skip_rows:
        raise LabrigError(f"{path}: there is no row {max(how.groups)} above its names: see 'format: groups:'")
    over = [cells[how.skip_rows - i] for i in how.groups if how.skip_rows < len(cells)]
    cells = cells[how.skip_rows :]
    if not cells:
        raise LabrigError(f"{path}: has no rows")
    above = how.skip_rows
    doubled: frozenset[str] = frozenset()
    header = None
    if how.header:
        header, doubled = distinct(joined([[str(name).strip() for name in row] for row in (*over, cells[0])]))
        below = 1 + how.units_row
        cells, above = cells[below:], above + below
    frame = pd.DataFrame(cells, columns=header)
    frame = frame.map(lambda v: None if v == "" else v).infer_objects()
    return Table(path, frame, above + 1, how.decimal, "row", doubled)


def _cells(book: object, name: str) -> list[list[object]]:
    return book.get_sheet_by_name(name).to_python(skip_empty_area=False)  # type: ignore[attr-defined]


def _open(path: Path):
    from python_calamine import CalamineError, CalamineWorkbook

    try:
        return CalamineWorkbook.from_path(str(path))
    except CalamineError as error:
        raise LabrigError(f"{path}: can't be read as a workbook ({error})") from None
