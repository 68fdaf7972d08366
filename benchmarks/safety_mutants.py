"""Is there a test that notices when the code that keeps the rig safe is broken?

    python benchmarks/safety_mutants.py [--only TEXT] [--workers 1] [--out benchmarks/RESULTS.md]

`safety_mutants.yaml` lists changes that a careless editor might make. Each is made in a copy of the tree, in a
temporary folder, and the tests beside the code run there until the first one fails. Before that, the tests must pass
on the unchanged copy. A change whose text is not found exactly once is an error, and nothing is run. Writes the section
"Safety net" of the results; with --only, runs the changes whose description contains the text, and writes nothing.
"""

import argparse
import os
import platform
import queue
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import yaml

from labrig.bench._report import write_section

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
PACKAGES = ("", "drivers", "procedures", "logs_schema")
"""Where the packages lie in a tree: else the tests would run on those that are installed."""
LIST = HERE / "safety_mutants.yaml"
HEADING = "## Safety net"
LIMIT_S = 600.0
LEFT_OUT = shutil.ignore_patterns(
    ".git", ".venv", "__pycache__", ".hypothesis", ".*_cache", "build", "dist", "node_modules", "pictures"
)
_FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", re.MULTILINE)


@dataclass(frozen=True)
class Change:
    """One change: `before` becomes `after` in `file`; `hurts` says what for, `tests` lie beside the code."""

    change: str
    hurts: str
    file: str
    before: str
    after: str
    tests: tuple[str, ...]

    def apply(self, tree: Path) -> str:
        """Make the change in a tree; returns the text as it was."""
        path = tree / self.file
        text = path.read_text(encoding="utf-8")
        path.write_text(text.replace(self.before, self.after), encoding="utf-8")
        return text

    def problem(self, tree: Path) -> str | None:
        """Why the change cannot be made in a tree; None if it can."""
        path = tree / self.file
        if not path.is_file():
            return f"{self.change}: there is no file {self.file}"
        text = path.read_text(encoding="utf-8")
        if (count := text.count(self.before)) != 1:
            return (
                f"{self.change}: its text stands {count} times in {self.file}, not once; correct {LIST.name}"
            )
        try:
            compile(text.replace(self.before, self.after), self.file, "exec")
        except SyntaxError as error:
            return f"{self.change}: {self.file} would be no Python any more, line {error.lineno}"
        absent = [test for test in self.tests if not (tree / test).exists()]
        return f"{self.change}: there are no tests {absent[0]}" if absent else None


@dataclass(frozen=True)
class Outcome:
    """What the tests said to a change: which one failed (None: all passed), and how long it took."""

    change: Change
    noticed_by: str | None
    took_s: float


def load_changes(path: Path) -> list[Change]:
    """The list of changes."""
    entries = yaml.safe_load(path.read_text(encoding="utf-8"))
    return [Change(**{**entry, "tests": tuple(entry["tests"])}) for entry in entries]


def run_tests(tree: Path, tests: tuple[str, ...]) -> tuple[str | None, float]:
    """Run tests in a tree until the first failure; returns its name (None: all passed) and the seconds it took.

    Raises `RuntimeError` when the tests could not be run at all.
    """
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-m", "not slow", "-p", "no:cacheprovider", *tests]
    path = os.pathsep.join(str(tree / folder) for folder in PACKAGES)
    env = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"}
    began = time.monotonic()
    try:
        done = subprocess.run(
            command, cwd=tree, env=env, capture_output=True, text=True, timeout=LIMIT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return f"no end within {LIMIT_S:g} s", time.monotonic() - began
    took_s = time.monotonic() - began
    if done.returncode == 0:
        return None, took_s
    failed = _FAILED.search(done.stdout)
    if done.returncode != 1 or failed is None:
        raise RuntimeError(f"pytest {' '.join(tests)} ended with {done.returncode}:\n{done.stdout[-3000:]}")
    return failed[1], took_s


def try_change(tree: Path, change: Change) -> Outcome:
    """Make a change in a copy, run its tests, take it back."""
    text = change.apply(tree)
    try:
        noticed_by, took_s = run_tests(tree, change.tests)
    finally:
        (tree / change.file).write_text(text, encoding="utf-8")
    return Outcome(change, noticed_by, took_s)


def measure(changes: list[Change], workers: int) -> list[Outcome]:
    """Try every change, some at a time, each worker in a copy of its own; raises `RuntimeError` as `run_tests`."""
    with tempfile.TemporaryDirectory() as name:
        trees: queue.Queue[Path] = queue.Queue()
        for worker in range(workers):
            tree = Path(name) / str(worker)
            shutil.copytree(ROOT, tree, ignore=LEFT_OUT)
            trees.put(tree)

        def unchanged(test: str) -> None:
            tree = trees.get()
            try:
                failed, took_s = run_tests(tree, (test,))
            finally:
                trees.put(tree)
            if failed is not None:
                raise RuntimeError(f"{failed} fails without any change; mend that first")
            print(f"{took_s:5.0f} s  {test} passes without a change", flush=True)

        def work(change: Change) -> Outcome:
            tree = trees.get()
            try:
                outcome = try_change(tree, change)
            finally:
                trees.put(tree)
            by = outcome.noticed_by or "NOT NOTICED"
            print(f"{outcome.took_s:5.0f} s  {change.file}: {change.change}: {by}", flush=True)
            return outcome

        with ThreadPoolExecutor(workers) as pool:
            list(pool.map(unchanged, sorted({test for change in changes for test in change.tests})))
            return list(pool.map(work, changes))


def lines_of(outcomes: list[Outcome]) -> list[str]:
    """The section of the results."""
    noticed = sum(outcome.noticed_by is not None for outcome in outcomes)
    system = f"{os.cpu_count()} cores, Python {platform.python_version()}"
    lines = [
        f"`python benchmarks/safety_mutants.py` on {system}: changes that could hurt a rig or lose data, made to a "
        "copy, and the first test beside the code that fails then "
        f"(at most {max(outcome.took_s for outcome in outcomes):.0f} s each).",
        "",
        f"**{noticed} of {len(outcomes)} noticed.** The tests were written against this list: it says that none of "
        "these goes unnoticed, not how many others would.",
        "",
        "| Change | in | noticed by |",
        "|---|---|---|",
    ]
    for outcome in outcomes:
        by = f"`{outcome.noticed_by}`" if outcome.noticed_by else "**nothing**"
        lines.append(f"| {outcome.change.change} | `{outcome.change.file}` | {by.replace('|', '/')} |")
    return lines


def main() -> int:
    """Try the changes, write the section; 1 if a change cannot be made, or is not noticed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", default="")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path, default=HERE / "RESULTS.md")
    options = parser.parse_args()
    changes = load_changes(LIST)
    if problems := [problem for change in changes if (problem := change.problem(ROOT)) is not None]:
        print("\n".join(problems), file=sys.stderr)
        return 1
    changes = [change for change in changes if options.only in change.change]
    if not changes:
        print(f"no change is described with {options.only!r}", file=sys.stderr)
        return 1
    try:
        outcomes = measure(changes, options.workers)
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    lines = lines_of(outcomes)
    if not options.only:
        write_section(options.out, HEADING, lines)
    print("\n".join(lines))
    return int(any(outcome.noticed_by is None for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(main())
