"""Physics that is named against a warp that absorbs it, inside and outside the data: "Physics against warp".

    python benchmarks/extrapolate.py [--seeds 3] [--out benchmarks/RESULTS.md]

A shell whose sheet is not the simulator's (its pre-stretch, or its stiffening by strain) is solved exactly and seen
through markers with 0.1 mm of noise, at pressures up to 60 % of the range. From these captures alone come the
diagnosis with the simulator as base, and two warps of the forward model: the source paper's network and labrig's.
Errors are rms distances at set-points that nobody saw, within those pressures and beyond them (60-100 %).
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import xarray as xr
import yaml

from labrig.bench._report import write_section
from labrig.diagnosis import diagnose
from labrig.effects import rows_of
from labrig.model import Model
from labrig.physics import Shell, load_shell, simulate
from labrig.surrogate import ForwardModel, Frames, train_forward, train_warp, training_set

SHELL = "membrane4"
INSIDE, BEYOND = (0.0, 36.0), (36.0, 60.0)
CAPTURES, HELD_OUT = 40, 12
NOISE_MM = 0.1
HOLD_S = np.array([3.0, 3.5, 4.0])
HIDDEN = {"pre-stretch + 0.04": {"prestretch_1": 0.04}, "strain stiffening + 0.6": {"stiffening_1": 0.6}}
WAYS = ("as simulated", "the paper's warp (N_rbf)", "labrig's warp", "the named effect inside")


def positions(known: Shell, true: Shell, pressure_kpa: np.ndarray) -> np.ndarray:
    """Marker positions of exact solves, mm, (F, M, 3)."""
    at = known.spline.basis(known.marker_uv)
    return np.array([at @ true.solve(p).control_mm.reshape(-1, 3) for p in pressure_kpa])


def campaign(shell: Shell, pressure_kpa: np.ndarray, position_mm: np.ndarray) -> xr.Dataset:
    """Captures of three rows each, as a run holds them; `position_mm` (F, T, M, 3)."""
    n = len(pressure_kpa)
    start = 10.0 * np.arange(n)
    rest = shell.spline.basis(shell.marker_uv) @ shell.control_rest_mm.reshape(-1, 3)
    return xr.Dataset(
        {
            "commanded": (("capture", "chamber"), pressure_kpa, {"units": "kPa"}),
            "hold_s": (("capture", "time"), np.tile(HOLD_S, (n, 1))),
            "time_s": (("capture", "time"), start[:, None] + HOLD_S),
            "event_time_s": ("event", start),
            "event_commanded": (("event", "chamber"), pressure_kpa),
            "position_mm": (("capture", "time", "marker", "axis"), position_mm),
            "rest_mm": (("marker", "axis"), rest),
        },
        coords={
            "chamber": list(shell.chamber_names),
            "chamber_min": ("chamber", 0.0 * shell.max_kpa),
            "chamber_max": ("chamber", shell.max_kpa),
            "session": ("capture", ["s"] * n),
            "event_session": ("event", ["s"] * n),
            "event_of": ("capture", np.arange(n)),
            "repeat": ("capture", [""] * n),
            "marker": list(shell.marker_names),
            "axis": list("xyz"),
        },
    )


def rms_mm(predicted: np.ndarray, right: np.ndarray) -> float:
    """Root mean square distance of markers (F, M, 3)."""
    return float(np.sqrt(((predicted - right) ** 2).sum(axis=-1).mean()))


def errors(
    folder: Path, forward: ForwardModel, change: dict[str, float], seed: int
) -> tuple[str, np.ndarray]:
    """What was named, and the errors (ways, 2) within and beyond the captured pressures."""
    known = load_shell(SHELL)
    true = known.changed(**{name: known.parameters[name].value + by for name, by in change.items()})
    rng = np.random.default_rng(seed)
    pressure = rng.uniform(*INSIDE, (CAPTURES, len(known.max_kpa)))
    clean = positions(known, true, pressure)
    seen = clean[:, None] + NOISE_MM * rng.normal(size=(CAPTURES, len(HOLD_S), *clean.shape[1:]))
    run = campaign(known, pressure, seen)
    result = diagnose(run, Model.load(folder / "model.yaml"))
    named = f"{result.summary['verdict']}: {', '.join(result.summary['effects'])}"
    frames = Frames(known.marker_names, pressure, seen.mean(axis=1))
    warps = [
        train_warp(forward, frames, method=way, seed=seed, calibrate=False).model
        for way in ("function", "ours")
    ]
    uv = forward.markers(known.marker_names)
    out = np.zeros((len(WAYS), 2))
    for column, span in enumerate((INSIDE, BEYOND)):
        asked = rng.uniform(*span, (HELD_OUT, len(known.max_kpa)))
        right = positions(known, true, asked)
        rows = rows_of(campaign(known, asked, np.repeat(right[:, None], len(HOLD_S), axis=1)))
        first = np.searchsorted(rows.capture, np.arange(HELD_OUT))

        def shape(base: np.ndarray, first: np.ndarray = first, right: np.ndarray = right) -> np.ndarray:
            return base[first].reshape(right.shape)

        out[0, column] = rms_mm(positions(known, known, asked), right)
        out[1, column] = rms_mm(warps[0].points(asked, uv), right)
        out[2, column] = rms_mm(warps[1].points(asked, uv), right)
        better = result.improved or Model.load(folder / "model.yaml")
        out[3, column] = rms_mm(shape(better.context(rows).base), right)
    return named, out


def main() -> None:
    """Measure, print, and write the section."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--simulations", type=int, default=250)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "RESULTS.md")
    asked = parser.parse_args()
    lines = [
        "| hidden | what was named | way | within the captured pressures, mm | beyond them, mm |",
        "|---|---|---|---|---|",
    ]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shell = load_shell(SHELL)
        rig = {
            "name": "membrane",
            "chambers": [
                {"name": c, "max_kpa": float(p)}
                for c, p in zip(shell.chamber_names, shell.max_kpa, strict=True)
            ],
            "pressure": {"kind": "simulated"},
            "mocap": {"kind": "simulated"},
            "simulated": {"shell": SHELL},
        }
        (folder / "rig.yaml").write_text(yaml.safe_dump(rig))
        (folder / "model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
        forward = train_forward(
            training_set(simulate(shell, folder / "set", asked.simulations, workers=1))
        ).model
        for hidden, change in HIDDEN.items():
            each = [errors(folder, forward, change, seed) for seed in range(asked.seeds)]
            table = np.median([found for _, found in each], axis=0)
            said = "; ".join(dict.fromkeys(said for said, _ in each))
            for way, (within, beyond) in zip(WAYS, table, strict=True):
                lines.append(f"| {hidden} | {said} | {way} | {within:.3f} | {beyond:.3f} |")
                print(lines[-1], flush=True)
    lines += [
        "",
        f"Medians of {asked.seeds} seeds; {CAPTURES} captures with {NOISE_MM} mm of noise at pressures up to 60 % of "
        f"the range, {HELD_OUT} set-points held out in each band, errors against the exact solve without noise.",
    ]
    write_section(asked.out, "## Physics against warp", lines)


if __name__ == "__main__":
    main()
