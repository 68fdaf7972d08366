"""Tables of one pressure and one force, cut by the plateaus of the pressure."""

from pathlib import Path

import pandas as pd
import xarray as xr
import yaml

import labrig


def run_of(frame: pd.DataFrame, **more: object) -> xr.Dataset:
    """The run of columns t (s), p (kPa) and F (N); `more` goes into the mapping, and None takes a field out of it."""
    frame.to_csv("t.csv", index=False)
    mapping = {
        "table": "t.csv",
        "time": {"column": "t", "unit": "s"},
        "capture": {"per": "segment"},
        "actuation": [{"column": "p", "name": "p", "unit": "kPa"}],
        "observables": [{"column": "F", "name": "F", "unit": "N"}],
        **more,
    }
    Path("map.yaml").write_text(yaml.safe_dump({k: v for k, v in mapping.items() if v is not None}))
    return labrig.import_table("map.yaml", "run")
