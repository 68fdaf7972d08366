"""A run of simulations that was torn by a power cut: what is whole counts, what is not is solved again."""

import shutil

import numpy as np
import pytest

from labrig.physics import load_shell, simulate


@pytest.fixture(scope="module")
def membrane():
    """A quick shell of four chambers."""
    return load_shell("membrane4").changed(count=(8, 8))


@pytest.fixture(scope="module")
def begun(membrane, tmp_path_factory):
    """The whole of a run, and the folder of one that was stopped half way."""
    folder = tmp_path_factory.mktemp("torn")
    whole = simulate(membrane, folder / "whole", 24, workers=1)

    def stop(done, total):
        if done >= 16:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(membrane, folder / "stopped", 24, workers=1, progress=stop)
    return whole, folder / "stopped"


@pytest.mark.parametrize(
    "how", ["cut short", "empty", "of other shapes", "without its states", "not a file of arrays"]
)
def test_a_part_that_cannot_be_read_is_solved_again(membrane, begun, tmp_path, how):
    """A torn, empty or foreign part is solved anew at --resume, and all comes out as if it had never been."""
    whole, stopped = begun
    folder = shutil.copytree(stopped, tmp_path / "sims")
    part, other = sorted(folder.glob("parts/part-*.npz"))[:2]
    if how == "of other shapes":
        shutil.copy(other, part)
    elif how == "without its states":
        with np.load(part) as arrays:
            some = {name: arrays[name] for name in arrays.files if name != "state"}
        np.savez(part, **some)
    else:
        content = part.read_bytes()
        part.write_bytes(
            {"cut short": content[:1000], "empty": b"", "not a file of arrays": b"?" * 2000}[how]
        )
    steps = []
    made = simulate(
        membrane, folder, 24, workers=1, resume=True, progress=lambda done, count: steps.append(done)
    )
    assert steps[0] == 8
    np.testing.assert_array_equal(made.control_mm, whole.control_mm)


def test_a_plan_that_cannot_be_read_is_made_again(membrane, begun, tmp_path):
    """A torn plan is drawn again: the same seed gives the same pressures, and the parts still count."""
    whole, stopped = begun
    folder = shutil.copytree(stopped, tmp_path / "sims")
    plan = folder / "parts" / "plan.npz"
    plan.write_bytes(plan.read_bytes()[:100])
    steps = []
    made = simulate(
        membrane, folder, 24, workers=1, resume=True, progress=lambda done, count: steps.append(done)
    )
    assert steps[0] == 16
    np.testing.assert_array_equal(made.control_mm, whole.control_mm)
