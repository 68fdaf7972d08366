"""The naming on laws that nothing was learnt from: each law of the development half left out of its own spectrum.

    python benchmarks/left_out.py OUT [--learn 330] [--third 180] [--seed 740000] [--n 24] [--workers 2]

What a choice of constants or families is judged by. OUT keeps what every law changes, the spectra without each law, and
a record of each campaign; what is there is not done again. The laws are those that spectra are learnt from; the exam is
not among them.
"""

import argparse
import json
import pickle
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from labrig.bench._draw import draw
from labrig.bench._files import write_model
from labrig.bench._intervals import wilson
from labrig.bench._judge import is_right, wrongly_sure
from labrig.bench._learn import drawn_example, learn
from labrig.diagnosis import _spectra, diagnose
from labrig.model import Model

CLASSES = ("single", "pair", "structural", "outside")


def keep_example(out: Path, task: tuple[str, int]) -> None:
    """Lay out one law, once."""
    half, seed = task
    path = out / "examples" / f"{half}-{seed}.pkl"
    if not path.exists():
        partial_path = path.with_suffix(".part")
        partial_path.write_bytes(pickle.dumps(drawn_example(seed, half)))
        partial_path.replace(path)


def spectra_without(out: Path, effect: str, law: str) -> dict[str, dict]:
    """What the other laws of an effect say of its spectra, learnt once."""
    path = out / "spectra" / f"{effect}-{law}.json"
    if not path.exists():
        known = (pickle.loads(p.read_bytes()) for p in sorted((out / "examples").glob("*.pkl")))
        others = [e for name, e in known if name == effect and e is not None and e.law != law]
        path.write_text(json.dumps(learn(others) if others else {}), encoding="utf-8")
    return json.loads(path.read_text(encoding="utf-8"))


def judged(out: Path, task: tuple[str, int]) -> dict[str, Any]:
    """One campaign of the development half, diagnosed with spectra that never saw its laws."""
    name, seed = task
    campaign = draw(name, seed, "development")
    truth = campaign.truth
    known = json.loads(_spectra.FILE.read_text(encoding="utf-8"))["spectra"]
    for effect, law in zip(truth["effects"], truth["laws"], strict=False):
        known |= spectra_without(out, effect, law)
    _spectra.shipped = lambda: known  # each process has its own; what is shipped stays as it is
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        model = Model.load(write_model(campaign, Path(folder)))
        answer = diagnose(campaign.dataset, model, without=truth["without"]).summary
    return {
        "class": name,
        "seed": seed,
        "laws": truth["laws"],
        "rig": truth["rig"],
        "verdict": answer["verdict"],
        "effects": answer["effects"],
        "right": is_right(truth, answer),
        "wrong": sorted(wrongly_sure(truth, answer)),
    }


def main() -> None:
    """Learn, leave out, diagnose, and print a table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path)
    parser.add_argument("--learn", type=int, default=330)
    parser.add_argument("--third", type=int, default=180)
    parser.add_argument("--seed", type=int, default=740000)
    parser.add_argument("--n", type=int, default=24)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    for folder in ("examples", "spectra"):
        (asked.out / folder).mkdir(parents=True, exist_ok=True)
    laws = [("development", s) for s in range(asked.learn)] + [("third", s) for s in range(asked.third)]
    kept = asked.out / "campaigns.jsonl"
    records = [json.loads(line) for line in kept.read_text().splitlines()] if kept.exists() else []
    done = {(r["class"], r["seed"]) for r in records}
    tasks = [(c, asked.seed + i) for c in CLASSES for i in range(asked.n) if (c, asked.seed + i) not in done]
    with ProcessPoolExecutor(asked.workers) as pool, kept.open("a", encoding="utf-8") as file:
        list(pool.map(partial(keep_example, asked.out), laws))
        for record in pool.map(partial(judged, asked.out), tasks):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
    print("| class | right | 95 % | wrong name sure |\n|---|---|---|---|")
    for name in CLASSES:
        own = [r for r in records if r["class"] == name]
        right = sum(r["right"] for r in own)
        low, high = wilson(right, max(len(own), 1))
        wrong = sum(bool(r["wrong"]) for r in own)
        print(f"| {name} | {right} of {len(own)} | {100 * low:.0f}-{100 * high:.0f} % | {wrong} |")


if __name__ == "__main__":
    main()
