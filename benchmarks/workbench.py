"""How long the workbench takes to show a run of 300 captures, and to follow a switch; and which packages it adds.

    python benchmarks/workbench.py [--folder FOLDER] [--out benchmarks/RESULTS.md]

In the system's Chromium, without a window and drawing in software. FOLDER holds `run` and `model.yaml` that were
measured before; without it a campaign on a simulated rig is run, and its shapes solved, which takes minutes. Beside a
switch stands what else would show the same: `labrig improve`, a process of its own. Writes the section "Workbench".
"""

import argparse
import json
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from labrig.bench._report import write_section
from labrig.cli._demo_steps import MODEL, RIG
from labrig.workbench import open_desk, start
from labrig_drivers.simulated import hide, seal

CAPTURES = 300
REPEATS, FIRSTS = 5, 3
LOOK_S = 5.0  # a person looks at the list of runs before opening one
PAINT_S, SWITCH_S = 2.0, 0.5
SWITCHED = ("drift", "regulator", "hysteresis", "tension")


def labrig(folder: Path, *words: str) -> float:
    """Seconds that a command takes."""
    began = time.perf_counter()
    subprocess.run([sys.executable, "-m", "labrig", *words], cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - began


def campaign(folder: Path) -> None:
    """A run of 300 captures on a simulated rig that creeps, and the model that does not know it."""
    folder.mkdir(parents=True)
    (folder / "rig.yaml").write_text(RIG.replace("SEED", "0"), encoding="utf-8")
    (folder / "model.yaml").write_text(MODEL, encoding="utf-8")
    seal(folder, hide("creep", seed=0))
    words = ["--rig", "rig.yaml", "--captures", str(CAPTURES), "--highest", "0.75", "--out", "run"]
    labrig(folder, "run", "capture", *words)


def prepared(folder: Path) -> None:
    """What the page finds when it is opened: a comparison and a diagnosis."""
    for word in ("compare", "diagnose"):
        if not (folder / "run" / "model" / f"{'diagnosis' if word == 'diagnose' else word}.json").exists():
            labrig(folder, word, "run", "--model", "model.yaml", "--out", "run/model")


def shown_s(page: Page, address: str) -> dict[str, float]:
    """Seconds from the address to a surface that is on the screen, with verdict and error; that can be turned; to its
    last name.

    The first is the page's own mark, from where the browser began to go there: while plotly's script begins, the page
    answers nobody.
    """
    page.goto("about:blank")
    began = time.perf_counter()
    page.goto(address)
    page.wait_for_selector("[data-drawn='-1']")
    space = time.perf_counter() - began
    page.wait_for_selector(".surface[data-names=all]")
    flat = page.evaluate("performance.getEntriesByName('surface')[0].startTime") / 1000
    return {"flat": flat, "space": space, "names": time.perf_counter() - began}


def switched_s(page: Page, effect: str) -> float:
    """Seconds from the click on a switch to everything that follows it."""
    page.click(f"[data-effect={effect}]")
    on = page.locator(".toggle input:checked").evaluate_all("all => all.map(each => each.dataset.effect)")
    page.wait_for_selector(f'[data-drawn="{",".join(_in_order(page, on))}"]')
    return float(page.get_attribute(".step", "data-took") or "nan") / 1000


def _in_order(page: Page, on: list[str]) -> list[str]:
    """The effects as the address has them: in the order in which they were switched on."""
    asked = re.search(r"effects=([^&]*)", page.url)
    names = asked[1].replace("%2C", ",").split(",") if asked else []
    return [name for name in names if name in on]


DRAWING = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@contextmanager
def opened(folder: Path, chromium: str, step: str = "") -> Iterator[tuple[Page, str]]:
    """A page of a workbench that has kept nothing yet, and the address of the run; gone when that is done."""
    shutil.rmtree(folder / ".workbench", ignore_errors=True)
    running = start(open_desk(folder), port=0)
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=chromium, args=DRAWING)
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            page.set_default_timeout(300_000)
            page.goto(f"{running.address}{step}")
            time.sleep(LOOK_S)
            yield page, f"http://127.0.0.1:{running.port}/#/run/run"
            browser.close()
    finally:
        running.stop()


def measured(folder: Path, chromium: str) -> dict[str, list[float]]:
    """Seconds by what was done."""
    out: dict[str, list[float]] = {
        key: [] for key in ("other", "first", "flat", "space", "names", "on", "off")
    }
    for _ in range(FIRSTS):
        with opened(folder, chromium, "#/watch") as (page, at):  # a page that does not list the runs
            out["other"].append(shown_s(page, f"{at}/compare")["flat"])
    for _ in range(FIRSTS - 1):
        with opened(folder, chromium) as (page, at):
            out["first"].append(shown_s(page, f"{at}/compare")["flat"])
    with opened(folder, chromium) as (page, at):
        out["first"].append(shown_s(page, f"{at}/compare")["flat"])
        for _ in range(REPEATS):
            for key, took in shown_s(page, f"{at}/compare").items():
                out[key].append(took)
        page.goto(f"{at}/add?effects=creep")
        page.wait_for_selector("[data-refined=true]")
        time.sleep(20)  # the forms of the effects are found while a person looks
        for effect in SWITCHED:
            for key in ("on", "off"):
                out[key].append(switched_s(page, effect))
                page.wait_for_selector("[data-refined=true]")
    return out


def closure(names: tuple[str, ...]) -> set[str]:
    """Packages that these need, themselves included, as they are installed here."""
    found: set[str] = set()
    left = list(names)
    while left:
        name = left.pop().lower().replace("_", "-")
        if name in found:
            continue
        try:
            needs = requires(name) or []
        except PackageNotFoundError:
            continue
        found.add(name)
        left += [re.split(r"[^\w.-]", need)[0] for need in needs if "extra ==" not in need]
    return found


def lines_of(took: dict[str, list[float]], improve_s: float) -> list[str]:
    """The section."""
    own = closure(("starlette", "uvicorn"))
    base = closure(("labrig",)) - {"labrig"}
    middle = {name: statistics.median(values) for name, values in took.items()}
    switch = statistics.median([*took["on"], *took["off"]])

    def row(words: str, value: float, goal: str, values: list[float]) -> str:
        return f"| {words} | {value:.2f} s | {goal} | {min(values):.2f}-{max(values):.2f} s |"

    return [
        f"`python benchmarks/workbench.py` on {platform.machine()}, {os.cpu_count()} cores shared with other work "
        f"(load average {os.getloadavg()[0]:.1f}), Python {platform.python_version()}, Chromium drawing in software; "
        f"{CAPTURES} captures of 34 markers.",
        "",
        "| | median | goal | least-most |",
        "|---|---|---|---|",
        row(
            "verdict, error and surface on the screen, a run looked at before",
            middle["flat"],
            f"{PAINT_S:g} s",
            took["flat"],
        ),
        row(
            "the first time, the newest run of the list, after 5 s there",
            middle["first"],
            f"{PAINT_S:g} s",
            took["first"],
        ),
        row("the first time, another run", middle["other"], f"{PAINT_S:g} s", took["other"]),
        row("the same run: a surface that can be turned", middle["space"], "", took["space"]),
        row("the same run: the last name on it", middle["names"], "", took["names"]),
        row("an effect switched on, until all has followed", middle["on"], f"{SWITCH_S:g} s", took["on"]),
        row("switched off", middle["off"], f"{SWITCH_S:g} s", took["off"]),
        "",
        f"The same by `labrig improve` takes {improve_s:.1f} s, {improve_s / switch:.0f} times a switch; its values, "
        "with times and widths moved off the grid, are what the page shows a moment after the switch, and saves.",
        "",
        f"Packages that starlette and uvicorn bring: {len(own)} ({', '.join(sorted(own))}), of which "
        f"{len(own - base)} are not labrig's already.",
    ]


def main() -> None:
    """Measure, print and write the section."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "RESULTS.md")
    options = parser.parse_args()
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        sys.exit("no Chromium here: .ci/system-libraries browser installs it")
    with tempfile.TemporaryDirectory() as name:
        folder = (options.folder or Path(name) / "lab").resolve()
        if options.folder is None:
            campaign(folder)
        prepared(folder)
        took = measured(folder, chromium)
        words = ("improve", "run", "--model", "model.yaml", "--add", "creep", "--add", "drift", "--force")
        improve_s = labrig(folder, *words, "-o", f"{name}/better.yaml", "--out", f"{name}/improve")
        lines = lines_of(took, improve_s)
    print(json.dumps(took))
    print("\n".join(lines))
    write_section(options.out, "## Workbench", lines)


if __name__ == "__main__":
    main()
