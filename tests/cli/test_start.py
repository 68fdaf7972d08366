"""The command starts quickly, and from a wheel."""

import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
HEAVY = {
    "numpy", "scipy", "pandas", "xarray", "pyarrow", "rerun", "plotly", "matplotlib", "sklearn", "torch", "open3d",
    "pydantic", "google", "mcap", "yaml", "labrig.diagnosis", "labrig.view", "labrig.campaign", "labrig.log",
}  # fmt: skip


def test_help_imports_nothing_heavy():
    """`labrig --help` answers at once because no library that takes long to import is touched."""
    script = (
        "import sys\nfrom labrig.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit as end:\n    code = end.code\n"
        "print('\\n'.join(sys.modules), file=sys.stderr)\nsys.exit(code)"
    )
    ran = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=180, check=False
    )
    assert ran.returncode == 0
    assert "diagnose" in ran.stdout
    imported = {name for name in ran.stderr.splitlines() if name in HEAVY}
    assert imported == set()


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of this tree."""
    out = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(out), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True, timeout=100)
    (path,) = out.glob("*.whl")
    return path


def test_wheel_holds_the_packages_and_nothing_else(wheel):
    """The wheel installs names that are labrig's own and collide with nobody's, with their data files, and no tests."""
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info/" not in name} == {
        "labrig",
        "labrig_drivers",
        "labrig_procedures",
        "labrig_schema",
    }
    assert any(name.endswith("licenses/LICENSE") for name in names)


def test_wheel_gives_the_command_anywhere(wheel, tmp_path):
    """Installed from its wheel, `labrig` runs from any folder and brings its own modules, not those of this tree."""
    venv.create(tmp_path / "venv", with_pip=False)
    scripts = "Scripts" if sys.platform == "win32" else "bin"
    python = tmp_path / "venv" / scripts / ("python.exe" if sys.platform == "win32" else "python")
    install = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        str(python),
        "install",
        "--no-deps",
        "--no-index",
        str(wheel),
    ]
    subprocess.run(install, check=True, capture_output=True, timeout=100)
    place = [str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    packages = Path(
        subprocess.run(place, check=True, capture_output=True, text=True, timeout=180).stdout.strip()
    )
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    command = python.with_name("labrig.exe" if sys.platform == "win32" else "labrig")
    shown = subprocess.run(
        [str(command), "--help"], cwd=tmp_path, check=True, capture_output=True, text=True, timeout=180
    )
    assert "Run a soft-robotics rig" in shown.stdout
    where = [
        str(python),
        "-c",
        "import labrig, labrig_drivers, labrig_procedures, labrig_schema.pressure_pb2; print(labrig.__file__)",
    ]
    found = subprocess.run(where, cwd=tmp_path, check=True, capture_output=True, text=True, timeout=180)
    assert Path(found.stdout.strip()).is_relative_to(packages)
