"""How far fitted values are off, in their own standard errors: section "Standard errors".

    python benchmarks/standard_errors.py [--seeds 30] [--first 0] [--workers 2] [--out benchmarks/RESULTS.md]

On the laboratory of the tests: chambers that lose a two-hundredth of their pressure in a second, in holds of up to
60 s, on a body in proportion to the pressure and on one that bends; and the creep of one sensor in a record. What is
hidden has the values that are fitted, so that it is known how far off these are. Before: the time constant is taken for
known.
"""

import tempfile
import warnings
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks._by_hand import options
from labrig.bench._report import write_section
from labrig.diagnosis import prepared
from labrig.diagnosis._amount import two_digits
from labrig.diagnosis._formula import fit_named
from labrig.diagnosis._parameters import entries_of
from labrig.effects import get, rows_of
from labrig.model import Value
from tests.conftest import Lab
from tests.diagnosis.test_records import DT_S, ROWS, model_of, record, swept

HELD_S = (3.0, 10.0, 20.0, 40.0, 60.0)
LEAKS_S, CREEPS_S, SHARE = 200.0, 5.0, 0.4
Off = dict[str, float | None]


def leak(seed: int, bent: float) -> Off:
    """How far the amount and the time constant of a leak are off."""
    with tempfile.TemporaryDirectory() as folder:
        lab = Lab(Path(folder), captures=24, long_s=HELD_S, seed=seed, bent=bent)
        emptied = lab.u * np.exp(-lab.hold_s / LEAKS_S)[:, :, None]
        ready = prepared(rows_of(lab.dataset(lab.predict(emptied) + lab.noise())), lab.model())
        found = entries_of(ready.context, fit_named(ready.regression, ready.context, [get("leak")]))[
            0
        ].parameters
    return {
        "amount, before": _off(found["loss"], 1.0, given_shape=True),
        "amount": _off(found["loss"], 1.0),
        "time constant": _off(found["tau_s"], LEAKS_S),
    }


def creep(seed: int) -> Off:
    """How far the time constant of one sensor's creep is off in a record."""
    x, t = 5.0 * swept(seed), np.arange(ROWS) * DT_S
    behind = np.convolve(np.diff(x, prepend=0.0), np.exp(-t / CREEPS_S))[:ROWS]
    y = 12.0 * (x - SHARE * behind) + 0.3 * np.random.default_rng(seed).normal(size=ROWS)
    with tempfile.TemporaryDirectory() as folder:
        ready = prepared(rows_of(record(x, y, "kPa", "mm")), model_of(Path(folder)))
        found = entries_of(ready.context, fit_named(ready.regression, ready.context, [get("creep")]))[
            0
        ].parameters
    return {"time constant": _off(found["tau_s"], CREEPS_S)}


def _off(value: Value, true: float, given_shape: bool = False) -> float | None:
    sd = value.sd_given_shape if given_shape else value.sd
    return (float(np.ravel(value.value)[0]) - true) / float(np.ravel(sd)[0]) if sd else None


def main() -> None:
    """Measure and write the section."""
    asked = options(30, 0)
    warnings.simplefilter("ignore")
    seeds = range(asked.first, asked.first + asked.seeds)
    kinds = {
        "leak, body in proportion": partial(leak, bent=0.0),
        "leak, body that bends": partial(leak, bent=0.8),
        "creep in a record": creep,
    }
    lines = ["| | value | off by, root mean square | within two of them |", "|---|---|---|---|"]
    with ProcessPoolExecutor(asked.workers) as pool:
        for kind, draw in kinds.items():
            each = list(pool.map(draw, seeds))
            for name in each[0]:
                off = np.array([one[name] for one in each if one[name] is not None])
                size = two_digits(float(np.sqrt(np.mean(off**2))))
                lines.append(f"| {kind} | {name} | {size} | {(np.abs(off) < 2).sum()} of {len(off)} |")
    how = (
        f"`python benchmarks/standard_errors.py --first {asked.first} --seeds {asked.seeds}`: how far fitted values "
        "are from what is true, in their own standard errors. Before: the time constant was taken for known."
    )
    write_section(asked.out, "## Standard errors", [how, "", *lines])


if __name__ == "__main__":
    main()
