"""A made-up result: 40 captures of the mannequin that creep, and a model that learned most of it."""

import numpy as np
import pytest
import xarray as xr

from labrig.diagnosis import Result, Signature
from labrig.physics import load_surface

CHAMBERS = [{"name": f"c{i}", "min_kpa": 0, "max_kpa": 60} for i in range(1, 10)]
MARKERS = [f"m{i:02d}" for i in range(1, 35)]


def make_fields(captures=40, seed=0):
    """Fields of a campaign on the mannequin: creep of a few mm in the measured, 8 % of it left in the model."""
    random = np.random.default_rng(seed)
    surface = load_surface({"chambers": CHAMBERS, "markers": MARKERS, "simulated": {"surface": "mannequin"}})
    pressure = random.uniform(0, 60, (captures, 9)) * (random.random((captures, 9)) < 0.6)
    base = surface.predict(pressure)
    moved = base - surface.rest_mm
    history = np.convolve(pressure.mean(axis=1) / 60, [0.5, 0.3, 0.2])[:captures]
    creep = 0.12 * history[:, None, None] * moved
    noise = random.normal(0, 0.1, base.shape)
    measured = base + creep + noise
    measured[random.random(measured.shape[:2]) < 0.03] = np.nan
    model = base + 0.92 * creep
    axes = ["x", "y", "z"]
    flat = (captures, len(MARKERS) * 3)
    return xr.Dataset(
        {
            "measured": (("capture", "observable"), measured.reshape(flat)),
            "base": (("capture", "observable"), base.reshape(flat)),
            "model": (("capture", "observable"), model.reshape(flat)),
            "commanded": (("capture", "chamber"), pressure, {"units": "kPa"}),
            "rest_mm": (("marker", "axis"), surface.rest_mm),
        },
        coords={
            "capture": np.arange(captures),
            "observable": [f"{m}.{a}" for m in MARKERS for a in axes],
            "unit": ("observable", ["mm"] * flat[1]),
            "marker_of": ("observable", [m for m in MARKERS for _ in axes]),
            "axis_of": ("observable", axes * len(MARKERS)),
            "chamber": [c["name"] for c in CHAMBERS],
            "marker": MARKERS,
            "axis": axes,
            "repeat": ("capture", ["a" if i % 10 == 0 else "" for i in range(captures)]),
            "session": ("capture", ["s1"] * captures),
        },
    )


def _parameters(**values):
    return {name: {"value": v, "sd": sd, "unit": unit} for name, (v, sd, unit) in values.items()}


def considered(size=2.0, **probabilities):
    """Rows of effects_considered by name and probability, surest first, of one size each, in mm and floors of 0.1."""
    return [
        {
            "effect": name,
            "probability": p,
            "call": "sure" if p >= 0.9 else "possible" if p >= 0.1 else "not it",
            "size": size if p else 0.0,
            "size_sd": size / 20 if p else 0.0,
            "size_floors": 10 * size if p else 0.0,
            "size_sd_floors": size / 2 if p else 0.0,
        }
        for name, p in sorted(probabilities.items(), key=lambda item: -item[1])
    ]


SUMMARY = {
    "verdict": "identified",
    "effects": ["creep"],
    "probability": 0.97,
    "rivals": [],
    "effects_considered": considered(creep=0.98, drift=0.2, leak=0.03, delay=0.0),
    "unnamed": {},
    "units": "mm",
    "error": {"base": 1.92, "model": 0.31, "floor": 0.12, "ceiling": 0.15},
    "where": [
        {"group": "marker", "name": "m17", "error": 4.1, "share": 0.22, "clear": True},
        {"group": "time in hold", "name": "30 to 60 s", "error": 2.6, "share": 0.4, "clear": True},
    ],
    "ranking": [
        {
            "effect": "creep",
            "heldout_error": 0.31,
            "drop": 0.91,
            "se": 0.03,
            "probability": 0.97,
            "parameters": _parameters(amplitude=(0.21, 0.01, "1"), tau_s=(12.0, 1.5, "s")),
        },
        {
            "effect": "drift",
            "heldout_error": 1.1,
            "drop": 0.46,
            "se": 0.08,
            "probability": 0.02,
            "parameters": _parameters(rate=(0.4, 0.1, "mm/h")),
        },
        *(
            {
                "effect": name,
                "heldout_error": 1.9 + 0.01 * i,
                "drop": 0.01 - 0.005 * i,
                "se": 0.05,
                "probability": 0.001,
                "parameters": {},
            }
            for i, name in enumerate(
                [
                    "hysteresis",
                    "leak",
                    "coupling",
                    "marker_slip",
                    "frame",
                    "stiffening",
                    "gravity",
                    "friction",
                ]
            )
        ),
    ],
    "next_experiment": None,
    "warnings": ["Markers m03 and m29 were seen in fewer than half of the captures."],
}


def make_where(random):
    """Rows of every group, the smaller errors not clear of the floor."""
    names = {
        "marker": MARKERS,
        "region": [f"over {c['name']}" for c in CHAMBERS],
        "chamber": [f"{c['name']} above half" for c in CHAMBERS],
        "pressure band": ["0 to 15 kPa", "15 to 30 kPa", "30 to 45 kPa", "45 to 60 kPa"],
        "direction": ["mostly up", "mostly down"],
        "time in hold": ["0 to 10 s", "10 to 30 s", "30 to 60 s"],
    }
    return [
        {
            "group": group,
            "name": name,
            "error": float(error),
            "share": float(error / 40),
            "clear": bool(error > 0.6),
        }
        for group, members in names.items()
        for name, error in zip(members, random.gamma(2.0, 0.8, len(members)), strict=True)
    ]


def make_signatures(random):
    """A creep that rises with the time in hold, and a hysteresis whose strokes lie apart."""
    hold, load = random.uniform(1, 60, 800), random.uniform(0, 60, 800)
    above = random.random(800) < 0.5
    creep, loop = 8 * np.log1p(hold / 3), np.where(above, 2.0, -2.0)
    noise, weight = random.normal(0, 0.4, 800), np.ones(800)
    return [
        Signature(
            "creep", "error that grows with the time in hold", "time in hold", "s", "share of the last move", "%",
            hold, creep + noise, creep, weight, np.full(800, ""),
        ),
        Signature(
            "hysteresis", "up and down strokes apart", "pressure of the chamber", "kPa", "error as a pressure", "kPa",
            load, loop + noise, loop, weight, np.where(above, "from above", "from below"),
        ),
    ]  # fmt: skip


@pytest.fixture(scope="session")
def fields():
    """Fields of 40 captures on the mannequin."""
    return make_fields()


@pytest.fixture(scope="session")
def make_result(fields):
    """Make a result; keyword arguments replace keys of the summary."""

    def make(fields=fields, **changes):
        random = np.random.default_rng(1)
        return Result(
            summary={**SUMMARY, **changes},
            fields=fields,
            waterfall=[("base", 1.92), ("creep", 0.31), ("ceiling", 0.15), ("floor", 0.12)],
            signatures=make_signatures(random),
            where=make_where(random),
        )

    return make


@pytest.fixture
def make_considered():
    """Make rows of effects_considered from probabilities by name."""
    return considered
