"""Pictures of the workbench's steps, for the documents.

    labrig demo --hide creep --out lab && python benchmarks/workbench_pictures.py lab [--out docs/pictures]

Opens the folder's workbench in the system's Chromium, without a window, and keeps a picture of each step.
"""

import argparse
import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

from labrig.workbench import open_desk, start

ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
STEPS = {
    "choose": ("#/choose", "[data-drawn]"),
    "compare": ("#/run/run/compare?capture=35", "[data-drawn='35']"),
    "where": ("#/run/run/where?kind=marker&name=m16&group=marker", "[data-drawn='marker m16']"),
    "which": ("#/run/run/which", ".detail .chart .main-svg"),
    "add": ("#/run/run/add?effects=creep", "[data-refined=true]"),
}


def main() -> None:
    """Take the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="a folder that labrig demo made")
    parser.add_argument("--out", type=Path, default=Path(__file__).parents[1] / "docs" / "pictures")
    options = parser.parse_args()
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        sys.exit("no Chromium here: .ci/system-libraries browser installs it")
    running = start(open_desk(options.folder), port=0)
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=chromium, args=ARGUMENTS)
            page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
            page.set_default_timeout(120_000)
            page.goto(running.address)
            for name, (address, drawn) in STEPS.items():
                page.evaluate("hash => location.hash = hash", address)
                page.wait_for_selector(drawn)
                page.wait_for_timeout(3000)
                page.screenshot(path=options.out / f"workbench-{name}.png")
            browser.close()
    finally:
        running.stop()


if __name__ == "__main__":
    main()
