"""A drawn campaign as plain files, as another laboratory would hand them over."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from labrig.bench._draw import Campaign

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_BASE_FILE = '''"""The base model of this campaign: what the laboratory believes before it has measured."""

from labrig.bench import make_base

predict = make_base({recipe})
'''


def write_campaign(campaign: Campaign, folder: Path) -> None:
    """Write table.csv, map.yaml, base.py (unless the base is static), model.yaml, truth.json; and fresh.csv,
    fresh.yaml.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for stem, mapping, dataset in (("table", "map", campaign.dataset), ("fresh", "fresh", campaign.fresh)):
        _replace(
            folder / f"{stem}.csv",
            table(dataset).to_csv(index=False, float_format="%.8g", lineterminator="\n"),
        )
        _replace(folder / f"{mapping}.yaml", _yaml(mapping_of(dataset, f"{stem}.csv")))
    write_model(campaign, folder)
    _replace(folder / "truth.json", json.dumps(campaign.truth, indent=1) + "\n")


def write_model(campaign: Campaign, folder: Path) -> Path:
    """Write model.yaml, and base.py if the base is a Python function; returns the path of model.yaml."""
    base: dict[str, str | int] = {"kind": "static", "degree": 1}
    if campaign.base is not None:
        _replace(folder / "base.py", _BASE_FILE.format(recipe=repr(campaign.base)))
        base = {"kind": "python", "file": "base.py", "function": "predict"}
    path = folder / "model.yaml"
    _replace(path, _yaml({"base": base, "effects": []}))
    return path


def table(dataset: "xr.Dataset") -> "pd.DataFrame":
    """One row per moment of a hold; actuations at which nothing was recorded are rows without observables."""
    import pandas as pd

    hold = dataset["hold_s"].values
    capture, row = np.nonzero(np.isfinite(hold))
    columns: dict[str, np.ndarray | list[str] | list[int]] = {
        "t": np.round(dataset["time_s"].values[capture, row], 3),
        "capture": capture + 1,
        "h": np.round(hold[capture, row], 3),
        "session": dataset["session"].values[capture],
        "setpoint": dataset["repeat"].values[capture],
    }
    chambers = list(dataset["chamber"].values)
    for c, name in enumerate(chambers):
        columns[f"set_{name}"] = np.round(dataset["commanded"].values[capture, c], 4)
    if "measured" in dataset:
        for c, name in enumerate(chambers):
            columns[f"read_{name}"] = np.round(dataset["measured"].values[capture, row, c], 3)
    for column, value in _observables(dataset):
        columns[column] = np.round(value[capture, row], 6)
    if "covariates" in dataset:
        for k, name in enumerate(dataset["covariate"].values):
            columns[str(name)] = dataset["covariates"].values[capture, row, k]
    frame = pd.concat([pd.DataFrame(columns), _silent_events(dataset)], ignore_index=True)
    return frame.sort_values(["t", "capture"], kind="stable", ignore_index=True)


def _observables(dataset: "xr.Dataset") -> list[tuple[str, np.ndarray]]:
    if "position_mm" in dataset:
        position = dataset["position_mm"].values
        return [
            (f"{marker}_{axis}", position[:, :, m, a])
            for m, marker in enumerate(dataset["marker"].values)
            for a, axis in enumerate("xyz")
        ]
    return [
        (str(name), dataset["observed"].values[:, :, k])
        for k, name in enumerate(dataset["observable"].values)
    ]


def _silent_events(dataset: "xr.Dataset") -> "pd.DataFrame":
    import pandas as pd

    heard = set(dataset["event_of"].values.tolist())
    silent = [e for e in range(dataset.sizes["event"]) if e not in heard]
    columns: dict[str, np.ndarray | list[str] | list[int]] = {
        "t": np.round(dataset["event_time_s"].values[silent], 3),
        "capture": [dataset.sizes["capture"] + 1 + k for k in range(len(silent))],
        "h": np.zeros(len(silent)),
        "session": dataset["event_session"].values[silent],
        "setpoint": ["" for _ in silent],
    }
    for c, name in enumerate(dataset["chamber"].values):
        columns[f"set_{name}"] = np.round(dataset["event_commanded"].values[silent, c], 4)
    return pd.DataFrame(columns)


def mapping_of(dataset: "xr.Dataset", name: str) -> dict[str, Any]:
    """The content of the mapping file that makes a run of the table `name`."""
    chambers = [str(c) for c in dataset["chamber"].values]
    low, high = dataset["chamber_min"].values, dataset["chamber_max"].values
    mapping: dict[str, Any] = {
        "table": name,
        "time": {"column": "t", "unit": "s"},
        "capture": {"column": "capture"},
        "hold": {"column": "h", "unit": "s"},
        "session": {"column": "session"},
        "between_sessions": dataset.attrs["between_sessions"],
        "repeat": {"column": "setpoint"},
        "actuation": [
            {"column": f"set_{c}", "name": c, "unit": "kPa", "min": float(low[k]), "max": float(high[k])}
            for k, c in enumerate(chambers)
        ],
    }
    if "measured" in dataset:
        mapping["measured"] = [{"column": f"read_{c}", "name": c, "unit": "kPa"} for c in chambers]
    if "position_mm" in dataset:
        markers = [str(m) for m in dataset["marker"].values]
        mapping["observables"] = [
            {"column": f"{m}_{a}", "name": f"{m}.{a}", "unit": "mm", "marker": m, "axis": a}
            for m in markers
            for a in "xyz"
        ]
        rest = dataset["rest_mm"].values
        mapping["markers"] = {
            m: {"rest": [round(float(x), 4) for x in rest[k]]} for k, m in enumerate(markers)
        }
    else:
        mapping["observables"] = [_single(dataset, k) for k in range(dataset.sizes["observable"])]
    if "covariates" in dataset:
        mapping["covariates"] = [
            {"column": str(name), "name": str(name), "unit": str(unit)}
            for name, unit in zip(dataset["covariate"].values, dataset["covariate_unit"].values, strict=True)
        ]
    return mapping


def _single(dataset: "xr.Dataset", k: int) -> dict[str, str]:
    """How a mapping has the k-th observable of a campaign without whole positions."""
    name, unit, marker, axis = (
        str(dataset[c].values[k]) for c in ("observable", "unit", "marker_of", "axis_of")
    )
    # the px of units is a length on paper (1/96 inch), which an import would turn into millimetres
    entry = {"column": name, "name": name, "unit": "pixel" if unit == "px" else unit}
    return {**entry, "marker": marker, "axis": axis} if marker else entry


def _yaml(content: dict[str, Any]) -> str:
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=110)


def _replace(path: Path, text: str) -> None:
    partial = path.with_name(path.name + ".part")
    partial.write_text(text, encoding="utf-8", newline="\n")
    partial.replace(path)
