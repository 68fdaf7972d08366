"""The room of the report for what was asked of the chambers, and what they reached."""

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from labrig.view._page import Page, table

if TYPE_CHECKING:
    from xarray import Dataset

_ABOUT = (
    "The mean of what each chamber's sensor read in the hold, against its set-point. Captures whose pressures did not "
    "follow within the rig's tolerance are not among these."
)


def pressures(page: Page, fields: "Dataset") -> None:
    """A table of the chambers: how far each was from what was asked for; nothing where no pressure was measured."""
    if "reached" not in fields:
        return
    unit = escape(str(fields["commanded"].attrs.get("units", "")))
    commanded, reached = fields["commanded"].to_numpy(), fields["reached"].to_numpy()
    rows = []
    for index, name in enumerate(fields["chamber"].to_numpy().tolist()):
        off = reached[:, index] - commanded[:, index]
        known = np.isfinite(off)
        if not known.any():
            rows.append([escape(str(name)), "0", "not measured", "", ""])
            continue
        worst = int(np.nanargmax(np.abs(off)))
        capture = fields["capture"].to_numpy()[worst]
        where = f"capture {capture}: {reached[worst, index]:.2f} of {commanded[worst, index]:.2f}"
        rows.append(
            [
                escape(str(name)),
                str(int(known.sum())),
                f"{off[known].mean():+.2f}",
                f"{np.sqrt((off[known] ** 2).mean()):.2f}",
                where,
            ]
        )
    page.section("Pressures asked for and reached", _ABOUT)
    header = [
        "chamber",
        "captures",
        f"off on the mean, {unit}",
        f"root mean square, {unit}",
        f"farthest off, {unit}",
    ]
    page.add(table(header, rows, ["", "number", "number", "number"]))
