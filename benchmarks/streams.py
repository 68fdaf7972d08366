"""Streams of published models beside models that learn them without physics: "Streams".

    pip install sysidentpy nfoursid
    python benchmarks/streams.py [--seeds 3] [--measured] [--out benchmarks/RESULTS.md]

A muscle, an elastomer, two tanks and a tendon (`_streams/sets.py`), each one record of one input and one output with
white noise. labrig names what its base lacks and fits a formula; beside it a NARX polynomial (FROLS, free run), a
linear state space (N4SID) and SINDy with the input. All are scored on the same twelve stretches, each left out of the
fit in turn, and run freely over it; the others learn from what is left, joined, or from its longest piece, whichever is
better. `--measured` takes excerpts of public measured sets instead (`_streams/measured/`);
they have the noise they were measured with, so one seed is all there is.
"""

import argparse
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import labrig
from benchmarks._streams.measured import MEASURED
from benchmarks._streams.sets import SETS, Record, StreamSet
from labrig.arrays import Floats, Ints
from labrig.bench._report import write_section

BLOCKS = 12
SECONDS = {"muscle": 150.0, "elastomer": 300.0, "tanks": 3000.0, "tendon": 150.0}
MADE = "records that are made from published equations"
PUBLIC = "excerpts of public measured sets (`benchmarks/_streams/measured/README.md`)"
SCORED = (
    "held-out root mean square errors over twelve stretches left out in turn, in the output's unit, medians over the "
    "seeds"
)
MAPPING = """\
table: table.csv
time: {{column: t, unit: s}}
actuation: [{{column: u, name: {0[0]}, unit: {0[1]}}}]
observables: [{{column: y, name: {1[0]}, unit: {1[1]}}}]
"""


def measured(one: StreamSet, seed: int) -> Record:
    """A record with its noise."""
    random = np.random.default_rng(seed)
    true = one.make(random, SECONDS.get(one.name, np.inf))
    return Record(true.time_s, true.input, true.output + one.noise * random.normal(size=len(true.output)))


def named(one: StreamSet, record: Record) -> dict[str, Any]:
    """What labrig says of a record as a person would import it."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        table = {"t": record.time_s, "u": record.input, "y": record.output}
        pd.DataFrame(table).to_csv(folder / "table.csv", index=False)
        (folder / "map.yaml").write_text(MAPPING.format(one.input, one.output), encoding="utf-8")
        (folder / "model.yaml").write_text(one.model, encoding="utf-8")
        run = labrig.import_table(folder / "map.yaml", folder / "run")
        found = labrig.diagnose(run, folder / "model.yaml")
        return {"verdict": found.verdict, "names": [*found.summary["effects"]], "error": found.error}


Learner = Callable[[Floats, Floats], Callable[[Floats, float], Floats]]


def held_out(record: Record, learn: Learner) -> float:
    """Root mean square error over blocks, each predicted by what was learnt without it, running freely.

    A model that learns from the last samples sees a jump where a block is left out: it may also learn from the longest
    piece alone, and the better of the two counts.
    """
    n = len(record.input)
    block = np.arange(n) * BLOCKS // n
    joined, longest = np.empty(n), np.empty(n)
    for b in range(BLOCKS):
        own = block == b
        before, after = np.flatnonzero(block < b), np.flatnonzero(block > b)
        joined[own] = _left(record, learn, np.concatenate([before, after]))[own]
        longest[own] = _left(record, learn, max(before, after, key=len))[own]
    spread = 10 * record.output.std()
    sizes = [np.clip(np.nan_to_num(left, nan=spread), -spread, spread) for left in (joined, longest)]
    return float(min(np.sqrt(np.mean(size**2)) for size in sizes))


def _left(record: Record, learn: Learner, train: Ints) -> Floats:
    """What is left of the output (n,) when a model learns some of its rows, and runs freely over all of them."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            predicted = learn(record.input[train], record.output[train])(record.input, record.output[0])
        except (ValueError, np.linalg.LinAlgError, FloatingPointError):
            predicted = np.full(len(record.input), record.output[train].mean())
    return record.output - predicted


def scaled(u: Floats, y: Floats) -> tuple[Callable[[Floats], Floats], float, float]:
    """The input in units of its spread, and the output's middle and spread."""
    middle, spread = u.mean(), u.std()
    return (lambda x: (x - middle) / spread), float(y.mean()), float(y.std())


def narx(u: Floats, y: Floats) -> Callable[[Floats, float], Floats]:
    """A NARX polynomial of second degree, its terms by FROLS and the Bayesian criterion (SysIdentPy)."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS
    from sysidentpy.parameter_estimation import LeastSquares

    of, middle, spread = scaled(u, y)
    model = FROLS(
        ylag=3,
        xlag=3,
        basis_function=Polynomial(degree=2),
        info_criteria="bic",
        n_info_values=20,
        estimator=LeastSquares(),
    )
    model.fit(X=of(u)[:, None], y=((y - middle) / spread)[:, None])

    def run(x: Floats, first: float) -> Floats:
        start = np.full((model.max_lag, 1), (first - middle) / spread)
        return model.predict(X=of(x)[:, None], y=start)[: len(x), 0] * spread + middle

    return run


def state_space(u: Floats, y: Floats) -> Callable[[Floats, float], Floats]:
    """A linear state space of fourth order by subspaces (N4SID, nfoursid)."""
    from nfoursid.nfoursid import NFourSID

    of, middle, spread = scaled(u, y)
    frame = pd.DataFrame({"u": of(u), "y": (y - middle) / spread})
    found = NFourSID(frame, output_columns=["y"], input_columns=["u"], num_block_rows=12)
    found.subspace_identification()
    system, _ = found.system_identification(rank=4)

    def run(x: Floats, first: float) -> Floats:
        state, out = np.zeros((system.a.shape[0], 1)), np.empty(len(x))
        for i, value in enumerate(of(x)):
            out[i] = float((system.c @ state + system.d * value)[0, 0])
            state = system.a @ state + system.b * value
        return out * spread + middle

    return run


def sindy(u: Floats, y: Floats) -> Callable[[Floats, float], Floats]:
    """Sparse regression of the output's rate on polynomials of output and input (pysindy), stepped by Euler."""
    import pysindy as ps

    of, middle, spread = scaled(u, y)
    model = ps.SINDy(
        optimizer=ps.STLSQ(threshold=0.005, alpha=1e-3),
        feature_library=ps.PolynomialLibrary(degree=3),
        differentiation_method=ps.SmoothedFiniteDifference(),
    )
    model.fit(((y - middle) / spread)[:, None], t=1.0, u=of(u)[:, None])

    def run(x: Floats, first: float) -> Floats:
        out, now = np.empty(len(x)), (first - middle) / spread
        for i, value in enumerate(of(x)):
            out[i] = now
            now = float(np.clip(now + model.predict(np.array([[now]]), u=np.array([[value]]))[0, 0], -20, 20))
        return out * spread + middle

    return run


WAYS = {"NARX (SysIdentPy)": narx, "state space (nfoursid)": state_space, "SINDy (pysindy)": sindy}


def row(one: StreamSet, seeds: int) -> list[str]:
    """A line of the table: medians over the seeds."""
    said, errors = [], {way: [] for way in ("base", "labrig", *WAYS)}
    for seed in range(seeds):
        record = measured(one, seed)
        found = named(one, record)
        said.append(f"{found['verdict']} {' + '.join(found['names'])}".strip())
        errors["base"].append(found["error"]["base"])
        errors["labrig"].append(found["error"]["model"])
        for way, learn in WAYS.items():
            errors[way].append(held_out(record, learn))
        print(one.name, seed, said[-1], {way: round(e[-1], 3) for way, e in errors.items()}, flush=True)
    counted = "; ".join(f"{said.count(s)} x {s}" for s in dict.fromkeys(said))
    middle = [f"{np.median(e):.3g}" for e in errors.values()]
    noise = f"{one.noise:g} {one.output[1]}" if one.noise else f"as measured, {one.output[1]}"
    return [f"{one.name} ({one.source})", counted, noise, *middle]


def main() -> None:
    """Measure and write the section."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/RESULTS.md"))
    parser.add_argument("--measured", action="store_true", help="measured public sets, one seed")
    asked = parser.parse_args()
    seeds = 1 if asked.measured else asked.seeds
    rows = [row(one, seeds) for one in (MEASURED if asked.measured else SETS)]
    head = ["set", "labrig says", "noise", "base", "labrig, formula", *WAYS]
    table = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    table += ["| " + " | ".join(r) + " |" for r in rows]
    of, section = MADE, "## Streams"
    if asked.measured:
        of, section = PUBLIC, "## Streams, measured"
    command = f"python benchmarks/streams.py{' --measured' if asked.measured else ''} --seeds {seeds}"
    how = f"`{command}`: {of}; {SCORED}."
    write_section(asked.out, section, [how, "", *table])


if __name__ == "__main__":
    main()
