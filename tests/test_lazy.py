"""Packages whose public names are imported when they are first asked for."""

import json
import subprocess
import sys
from importlib import import_module

import pytest


@pytest.mark.parametrize("package", ["physics", "surrogate", "view", "workbench"])
def test_every_public_name_is_there(package):
    """Each name is found where the package says that it is; another is an attribute error that names it."""
    module = import_module(f"labrig.{package}")
    for name in module.__all__:
        assert getattr(module, name) is not None
    with pytest.raises(
        AttributeError, match=rf"^module 'labrig\.{package}' has no attribute 'nothing_of_the_kind'$"
    ):
        _ = module.nothing_of_the_kind


def test_a_reduced_surface_waits_for_no_compiler():
    """A simulated rig with a reduced surface is made without what only shells need."""
    code = (
        "import sys; from pathlib import Path; from labrig.physics import load_surface; "
        "from labrig_drivers.simulated import build_plant; "
        "rig = {'name': 'bench', 'simulated': {'surface': 'membrane'}}; "
        "build_plant(rig, Path()); load_surface(rig); "
        "print([name for name in ('numba', 'scipy.optimize', 'scipy.sparse') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_the_server_of_the_workbench_computes_nothing(tmp_path):
    """It answers, and vents, before what computes is imported: that is another process's business."""
    code = (
        "import sys; from pathlib import Path; from labrig.workbench import open_desk, start; "
        "running = start(open_desk(Path()), port=0); "
        "print([name for name in ('labrig.diagnosis', 'labrig.model', 'pandas', 'xarray', 'scipy') "
        "if name in sys.modules]); running.stop()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"


def test_a_campaign_waits_for_nothing_that_computes(tmp_path):
    """Its set-points are found, it is run, and what it lost is said, without what only a diagnosis needs."""
    rig = {
        "name": "bench",
        "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "simulated": {"surface": "membrane"},
    }
    (tmp_path / "rig.yaml").write_text(json.dumps(rig), encoding="utf-8")
    code = (
        "import sys; from labrig.cli import main\n"
        "words = 'run capture --rig rig.yaml --captures 2 --repeated 0 --out run'\n"
        "try:\n    main(words.split())\n"
        "finally:\n    print([name for name in ('pandas', 'xarray', 'numba') if name in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]", done.stdout
    assert "2 captures in " in done.stdout


def test_a_diagnosis_waits_for_no_statistics_that_it_does_not_use(tmp_path):
    """SciPy's come with a hundred distributions, and take as long as all else that a diagnosis imports."""
    code = "import sys, labrig.diagnosis; print('scipy.stats' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout == "False\n"
