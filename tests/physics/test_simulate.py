"""Sets of simulations: which pressures, in which folder, with how many workers, however often interrupted."""

import json
import os
import re
import signal

import numpy as np
import pytest

from labrig._errors import LabrigError
from labrig._executor import Executor
from labrig.ik._outcome import simulated_plant
from labrig.physics import load_model_shell, load_shell, open_simulations, simulate
from labrig.physics._cache import ArrayCache, cache_folder
from labrig.physics._samples import corners, sample_pressures


@pytest.fixture(scope="module")
def membrane():
    """A quick shell of four chambers."""
    return load_shell("membrane4").changed(count=(10, 10))


def test_corners_come_in_gray_order():
    """All corners, each one chamber away from the one before; a sample of them where they are too many."""
    every = corners(9, 1000, 0)
    assert every.shape == (512, 9)
    assert len(np.unique(every, axis=0)) == 512
    assert (np.abs(np.diff(every.astype(int), axis=0)).sum(1) == 1).all()
    assert corners(9, 100, 0).shape == (50, 9)
    assert len(np.unique(corners(12, 200, 1), axis=0)) == 100
    many = corners(70, 200, 0)
    assert len(np.unique(many, axis=0)) == 100
    assert (many.mean(axis=0) > 0.2).all()
    assert (many.mean(axis=0) < 0.8).all()


def test_pressures_spread_by_inflation(membrane):
    """Half of the spread pressures inflate a chamber less than half way: low pressures, where it moves most."""
    with Executor(1) as executor:
        pressure, kind = sample_pressures(membrane, 400, 0, executor)
    assert kind == ["corner"] * 16 + ["halton"] * 384
    spread = pressure[16:] / membrane.max_kpa
    assert ((spread >= 0) & (spread <= 1)).all()
    assert (np.median(spread, axis=0) < 0.45).all()
    with Executor(1) as executor:
        other, _ = sample_pressures(membrane, 400, 1, executor)
    np.testing.assert_array_equal(other[:16], pressure[:16])
    assert np.abs(other[16:] - pressure[16:]).max(axis=1).min() > 0
    start = membrane.solve([0, 0, 0, 0])
    full, half = (
        (membrane.solve([p, 0, 0, 0]).control_mm - start.control_mm)[..., 1].mean()
        for p in (60.0, 60.0 * np.median(spread[:, 0]))
    )
    assert half / full == pytest.approx(0.5, abs=0.06)


def test_a_folder_holds_what_was_asked_for(membrane, tmp_path):
    """Pressures, shapes, Jacobians and the shell come back as they were solved."""
    seen = []

    def report(done, total):
        seen.append((done, total))

    made = simulate(
        membrane,
        tmp_path / "sims",
        40,
        jacobians=True,
        workers=1,
        progress=report,
    )
    found = open_simulations(tmp_path / "sims")
    assert seen[0] == (0, 40)
    assert seen[-1] == (40, 40)
    np.testing.assert_array_equal(made.control_mm, found.control_mm)
    assert found.converged.all()
    assert (found.residual <= 1e-5).all()
    assert found.chamber_names == membrane.chamber_names
    assert found.spline == membrane.spline
    assert list(found.kind).count("corner") == 16
    assert load_shell(found.shell).content() == membrane.content()
    alone = membrane.solve(found.pressure_kpa[20])
    assert np.abs(alone.control_mm - found.control_mm[20]).max() < 2e-3
    np.testing.assert_allclose(membrane.jacobian(alone), found.jacobian[20], atol=2e-3)
    assert sorted(path.name for path in (tmp_path / "sims").iterdir()) == [
        "failures.json", "plan.json", "shell.yaml", "simulations.npz",
    ]  # fmt: skip
    assert json.loads((tmp_path / "sims" / "failures.json").read_text()) == []


def test_workers_and_interruptions_change_nothing(membrane, tmp_path):
    """In processes, or stopped half way and resumed, the same bits come out."""
    whole = simulate(membrane, tmp_path / "whole", 60, workers=1)
    parallel = simulate(membrane, tmp_path / "parallel", 60, workers=2)
    np.testing.assert_array_equal(whole.control_mm, parallel.control_mm)

    def stop(done, total):
        if done > 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(membrane, tmp_path / "stopped", 60, workers=1, progress=stop)
    with pytest.raises(
        LabrigError, match=r"its simulations are not complete: labrig simulate \.\.\. --resume"
    ):
        open_simulations(tmp_path / "stopped")
    before = {p: p.stat().st_mtime_ns for p in (tmp_path / "stopped" / "parts").glob("part-*.npz")}
    assert before
    steps = []
    resumed = simulate(
        membrane,
        tmp_path / "stopped",
        60,
        workers=1,
        resume=True,
        progress=lambda done, total: steps.append(done),
    )
    assert steps[0] >= 24
    np.testing.assert_array_equal(whole.control_mm, resumed.control_mm)
    again = simulate(membrane, tmp_path / "stopped", 60, workers=1, resume=True)
    np.testing.assert_array_equal(whole.control_mm, again.control_mm)


def test_a_cluster_whose_worker_is_killed_changes_nothing(membrane, tmp_path):
    """On two Dask workers, one of which is killed at work, the same bits come out as in this process."""
    distributed = pytest.importorskip("distributed")
    whole = simulate(membrane, tmp_path / "whole", 60, workers=1)
    kill = signal.SIGTERM if os.name == "nt" else signal.SIGKILL
    killed = []
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:

        def murder(done, total):
            if done > 0 and not killed:
                killed.append(cluster.workers[0].pid)
                os.kill(killed[0], kill)

        found = simulate(
            membrane, tmp_path / "cluster", 60, cluster=cluster.scheduler_address, progress=murder
        )
    assert killed
    np.testing.assert_array_equal(whole.control_mm, found.control_mm)


def test_folders_in_use_are_not_touched(membrane, tmp_path):
    """Without --resume a folder with simulations is refused, and with it one that belongs to others."""
    simulate(membrane, tmp_path, 20, workers=1)
    with pytest.raises(
        LabrigError, match=r"holds simulations already; --resume goes on, or name another folder$"
    ):
        simulate(membrane, tmp_path, 20, workers=1)
    with pytest.raises(LabrigError, match="was begun with another shell, count, seed or --jacobians"):
        simulate(membrane, tmp_path, 21, workers=1, resume=True)
    with pytest.raises(LabrigError, match="holds no simulations"):
        open_simulations(tmp_path / "nothing")


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        (
            "control_mm",
            lambda x: np.where(np.arange(x.size).reshape(x.shape) == 4000, np.nan, x),
            "of number 13 has",
        ),
        (
            "pressure_kpa",
            lambda x: np.where(np.arange(x.size).reshape(x.shape) == 9, np.inf, x),
            "of number 2 has",
        ),
        ("pressure_kpa", lambda x: x[:, :3], "is (14, 3), and (14, 4)"),
        ("pressure_kpa", lambda x: x[:12], "is (12, 4), and (14, 4)"),
        ("control_mm", lambda x: x.astype(str), "is of <U32, not of real numbers"),
    ],
)
def test_simulations_that_do_not_belong_together_are_refused(membrane, tmp_path, name, change, said):
    """What was changed from outside, or is no number, is named before anything is learnt from it."""
    simulate(membrane, tmp_path / "sims", 14, workers=1)
    file = tmp_path / "sims" / "simulations.npz"
    with np.load(file) as arrays:
        content = dict(arrays)
    np.savez(file, **{**content, name: change(content[name])})
    with pytest.raises(LabrigError, match=re.escape(f"{name} {said}")):
        open_simulations(tmp_path / "sims")


def test_what_does_not_converge_is_listed(tmp_path):
    """Shapes without an equilibrium are NaN and listed with the reason; if there is none at all, that is an error."""
    weak = load_shell("membrane4").changed(count=(10, 10), modulus_1_kpa=2.0, stiffening_1=0.05)
    made = simulate(weak, tmp_path / "some", 20, workers=1)
    listed = json.loads((tmp_path / "some" / "failures.json").read_text())
    assert 0 < len(listed) < 20
    assert [failure["number"] for failure in listed] == list(np.flatnonzero(~made.converged))
    assert np.isnan(made.control_mm[~made.converged]).all()
    assert listed[0]["reason"].startswith("shell membrane4: no equilibrium at c1 ")


def test_the_command_simulates(labrig, membrane, tmp_path):
    """`labrig simulate` takes a shell's file, says what it made, and refuses what is there already."""
    (tmp_path / "own.yaml").write_text(json.dumps(membrane.content()), encoding="utf-8")
    code, out, err = labrig(
        "simulate", tmp_path / "own.yaml", "-o", tmp_path / "sims", "--count", 18, "--workers", 1
    )
    assert (code, err) == (0, "")
    assert out.endswith("18 simulations of membrane4\n")
    code, _, err = labrig("simulate", tmp_path / "own.yaml", "-o", tmp_path / "sims", "--count", 18)
    assert code == 2
    assert err.endswith("holds simulations already; --resume goes on, or name another folder\n")


def test_a_seed_that_no_sequence_has_is_refused(labrig, membrane, tmp_path):
    """A seed above the largest is one line, and no folder is begun."""
    (tmp_path / "own.yaml").write_text(json.dumps(membrane.content()), encoding="utf-8")
    code, _, err = labrig("simulate", tmp_path / "own.yaml", "-o", tmp_path / "sims", "--seed", 10**20)
    assert code == 2
    assert err.startswith(
        "labrig: Invalid value for '--seed': Input should be less than or equal to 2147483647"
    )
    assert not (tmp_path / "sims").exists()


def test_a_rigs_plant_goes_as_far_as_the_rig(membrane, tmp_path):
    """What a simulated rig with a shell could do is looked for between the rig's own limits, vacuum among them."""
    (tmp_path / "own.yaml").write_text(json.dumps(membrane.content()), encoding="utf-8")
    rig = {
        "name": "rig",
        "chambers": [{"name": f"p{k}", "min_kpa": -2, "max_kpa": 80} for k in range(4)],
        "pressure": {"kind": "simulated"},
        "simulated": {"shell": "own.yaml"},
    }
    plant = simulated_plant(rig, tmp_path, np.full(4, -2.0), np.full(4, 80.0))
    assert plant is not None
    assert (set(plant.low_kpa), set(plant.high_kpa)) == ({-2.0}, {80.0})


def test_a_rig_names_its_shell(membrane, tmp_path):
    """A rig's file leads to its shell, with the rig's chambers and ranges; one without a shell is refused."""
    (tmp_path / "own.yaml").write_text(json.dumps(membrane.content()), encoding="utf-8")
    rig = {
        "name": "rig",
        "chambers": [{"name": f"p{k}", "max_kpa": 40 + k} for k in range(4)],
        "pressure": {"kind": "simulated"},
        "simulated": {"shell": "own.yaml"},
    }
    (tmp_path / "rig.yaml").write_text(json.dumps(rig), encoding="utf-8")
    shell = load_model_shell(tmp_path / "rig.yaml")
    assert shell.chamber_names == ("p0", "p1", "p2", "p3")
    assert shell.max_kpa.tolist() == [40.0, 41.0, 42.0, 43.0]
    assert load_model_shell("membrane4").chamber_names[0] == "c1"
    assert load_model_shell(tmp_path / "own.yaml").content() == membrane.content()
    (tmp_path / "bare.yaml").write_text(
        json.dumps({**rig, "simulated": {"surface": "membrane"}}), encoding="utf-8"
    )
    with pytest.raises(
        LabrigError, match=r"a rig with a reduced `simulated: \{surface: \.\.\.\}`: there is no"
    ):
        load_model_shell(tmp_path / "bare.yaml")


@pytest.mark.parametrize(
    ("platform", "variable", "folder"),
    [
        ("linux", "XDG_CACHE_HOME", "labrig"),
        ("win32", "LOCALAPPDATA", "labrig/cache"),
        ("linux", "LABRIG_CACHE", ""),
    ],
)
def test_the_cache_lies_where_the_system_wants_it(monkeypatch, tmp_path, platform, variable, folder):
    """$LABRIG_CACHE comes first, then the system's own place for such things."""
    monkeypatch.delenv("LABRIG_CACHE", raising=False)
    monkeypatch.setattr("sys.platform", platform)
    monkeypatch.setenv(variable, str(tmp_path))
    assert cache_folder() == tmp_path / folder


def test_a_full_disk_leaves_no_half_of_what_is_kept(tmp_path, monkeypatch):
    """What cannot be written is worked out again, and its beginning does not stay behind."""

    def full(file, **arrays):
        file.write(b"some")
        raise OSError(28, "No space left on device")

    cache = ArrayCache(tmp_path)
    monkeypatch.setattr(np, "savez", full)
    cache.write("key", np.arange(3.0))
    assert list(tmp_path.iterdir()) == []
    assert cache.read("key") is None
