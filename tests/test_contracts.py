"""What may import what, and how long a file may be."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_import_contracts():
    """The layers are kept: drivers know no analysis, only the view knows rerun, nothing imports upwards."""
    checked = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports_command; lint_imports_command()"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert "0 broken" in checked.stdout


def test_no_file_is_too_long():
    """A file has 400 lines at most: who has more to say makes a second room."""
    folders = ("labrig", "drivers", "procedures", "benchmarks", "tests", "docs")
    files = [p for folder in folders for p in (ROOT / folder).rglob("*.py") if not p.name.endswith("_pb2.py")]
    assert len(files) > 500
    long = {p.as_posix(): n for p in files if (n := len(p.read_text(encoding="utf-8").splitlines())) > 400}
    assert long == {}
