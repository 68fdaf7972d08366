"""Make a CSV of the static set: it comes as a pickled array, which labrig does not open by itself.

python static_table.py blackframe_25mbarIntervals.npy static.csv
"""

import sys

import numpy as np
import pandas as pd

MARKERS = ("base1", "base2", "base3", "base4", "tip1", "tip2", "tip3")
FRAME_S = 0.01


def main(source: str, target: str) -> None:
    """Write one row per frame: capture, time in hold, pressure, and the markers' coordinates in m."""
    content = np.load(source, allow_pickle=True).item()
    pressure, position = np.ravel(content["p"]), np.asarray(content["data"])
    captures, frames = position.shape[:2]
    columns = {
        "capture": np.repeat(np.arange(captures), frames),
        "t": (np.arange(captures)[:, None] * 60 + np.arange(frames) * FRAME_S).ravel().round(3),
        "h": np.tile(3.0 + np.arange(frames) * FRAME_S, captures).round(3),
        "p_mbar": np.repeat(pressure, frames),
    }
    for m, name in enumerate(MARKERS):
        for a, axis in enumerate("xyz"):
            columns[f"{name}_{axis}"] = position[:, :, m, a].ravel()
    pd.DataFrame(columns).to_csv(target, index=False)


if __name__ == "__main__":
    main(*sys.argv[1:3])
