"""The picture of a validation in the docs: three bodies on the simulated torso, the report as a browser shows it.

    python benchmarks/validation_picture.py [--out docs/pictures/validation.png]

Uses what benchmarks/ik.py keeps in benchmarks/out/ik, and a Chromium or Chrome that is installed.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

from _ik.setup import EXAMPLES, Bench, asked_for
from PIL import Image

from labrig.campaign import run
from labrig.cli._validate import report
from labrig.rig import connect, load_rig
from labrig_drivers import SimulatedClock
from labrig_procedures import Validate

BODIES = (2, 6, 8)
SIZE = (1060, 1850)
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


def main() -> None:
    """Run the validation and take the picture."""
    parser = asked_for(__doc__.splitlines()[0], "not used here")
    parser.set_defaults(out=Path("docs/pictures/validation.png"))
    given = parser.parse_args()
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if browser is None:
        sys.exit(f"validation_picture: no browser found (looked for {', '.join(BROWSERS)})")
    given.folder.mkdir(parents=True, exist_ok=True)
    bench = Bench(given.folder, given.bodies, given.workers)
    assert bench.warped is not None  # learned if it was not there
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made) / "three-bodies"
        targets = tuple(str(EXAMPLES / f"body-{number}.ply") for number in BODIES)
        chosen = Validate(targets=targets, model=str(bench.folder / "sim2real.pt"), unit="mm", refine=2)
        clock = SimulatedClock(0.0)
        with connect(load_rig(bench.rig_file()), clock) as rig:
            run(chosen, rig, folder, clock)
        report(folder)
        shot = Path(made) / "shot.png"
        command = [
            browser, "--headless", "--no-sandbox", "--hide-scrollbars", "--enable-unsafe-swiftshader",
            "--virtual-time-budget=20000", f"--window-size={SIZE[0]},{SIZE[1]}", f"--screenshot={shot}",
            (folder / "report.html").as_uri(),
        ]  # fmt: skip
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        Image.open(shot).convert("RGB").quantize(256).save(given.out, optimize=True)
    print(given.out)


if __name__ == "__main__":
    main()
