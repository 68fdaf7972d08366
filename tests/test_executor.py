"""The executor: the same results from this process, from processes and from a cluster, whoever dies."""

import importlib
import subprocess
import sys

import pytest

from labrig._errors import LabrigError
from labrig._executor import Executor
from tests.waiting import wait_for

TASKS = """
import os
import signal
import time
from pathlib import Path

from labrig._errors import LabrigError

KILL = signal.SIGTERM if os.name == "nt" else signal.SIGKILL


def square(number):
    return number * number


def killed_once(task):
    mark, number = task
    if number == 3 and not Path(mark).exists():
        Path(mark).touch()
        os.kill(os.getpid(), KILL)
    time.sleep(0.02)
    return number * number


def killed_always(number):
    os.kill(os.getpid(), KILL)


def fails(number):
    raise LabrigError(f"task {number} is wrong")


def stays(folder):
    Path(folder, str(os.getpid())).touch()
    time.sleep(120)
"""
LEFT = """
import sys
from labrig._executor import Executor
from labrig.workbench._worker import Worker
from labrig_test_tasks import stays

if __name__ == "__main__":
    if sys.argv[1] == "executor":
        list(Executor(2).map(stays, [sys.argv[2]] * 2))
    Worker().ask(stays, sys.argv[2])
"""


@pytest.fixture
def tasks(tmp_path, monkeypatch):
    """A module of functions that other processes can import."""
    (tmp_path / "labrig_test_tasks.py").write_text(TASKS, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield importlib.import_module("labrig_test_tasks")
    sys.modules.pop("labrig_test_tasks")


@pytest.fixture
def cluster():
    """Two Dask workers on this computer; yields the scheduler's address."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as running:
        yield running.scheduler_address


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_with_their_numbers(tasks, workers):
    """Every task is done once, here or in processes."""
    with Executor(workers) as executor:
        assert dict(executor.map(tasks.square, range(7))) == {k: k * k for k in range(7)}
        assert dict(executor.map(tasks.square, [3])) == {0: 9}
        assert dict(executor.map(tasks.square, [])) == {}


def test_a_killed_process_costs_nothing(tasks, tmp_path):
    """What a killed process was doing is done again by another."""
    with Executor(2) as executor:
        found = dict(executor.map(tasks.killed_once, [(str(tmp_path / "mark"), k) for k in range(8)]))
    assert (tmp_path / "mark").exists()
    assert found == {k: k * k for k in range(8)}


def test_work_that_kills_every_process_is_given_up(tasks):
    """A task that loses its worker again and again ends the work with one line."""
    with (
        Executor(2) as executor,
        pytest.raises(LabrigError, match=r"^the work was given up: task \d lost its worker"),
    ):
        dict(executor.map(tasks.killed_always, range(3)))


def test_an_error_reaches_the_caller(tasks):
    """An exception of a task is raised where the results are awaited."""
    with Executor(2) as executor, pytest.raises(LabrigError, match=r"^task \d is wrong$"):
        dict(executor.map(tasks.fails, range(3)))


def test_a_cluster_does_the_same_even_when_a_worker_is_killed(tasks, tmp_path, cluster):
    """On Dask workers, one of which is killed at work, every task is done and errors come through."""
    with Executor(cluster=cluster) as executor:
        found = dict(executor.map(tasks.killed_once, [(str(tmp_path / "mark"), k) for k in range(8)]))
        assert (tmp_path / "mark").exists()
        assert found == {k: k * k for k in range(8)}
        with pytest.raises(LabrigError, match=r"^task \d is wrong$"):
            dict(executor.map(tasks.fails, range(3)))


def test_a_cluster_that_is_not_there(monkeypatch):
    """An address where nobody answers is one line, and so is a computer without Dask."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("labrig._executor._CONNECT_S", 0.3)
    with pytest.raises(LabrigError, match=r"^--cluster tcp://127.0.0.1:9: no Dask scheduler answers there"):
        Executor(cluster="tcp://127.0.0.1:9")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(LabrigError, match=r"^--cluster needs packages .* pip install '\.\[cluster\]'$"):
        Executor(cluster="tcp://127.0.0.1:9")


def test_workers_are_counted():
    """A negative number of workers is refused; none means one per core."""
    with pytest.raises(LabrigError, match=r"^--workers -1: a number of processes, or 0 for one per core$"):
        Executor(-1)
    assert Executor().workers >= 1


@pytest.mark.parametrize(("who", "count"), [("executor", 2), ("workbench", 1)])
def test_workers_end_with_who_is_killed(who, count, tasks, tmp_path):
    """Where the process that asked is killed, its workers do not stay behind with what they hold."""
    pytest.importorskip("psutil")
    script, pids = tmp_path / "left.py", tmp_path / "pids"
    script.write_text(LEFT, encoding="utf-8")
    pids.mkdir()
    asking = subprocess.Popen([sys.executable, str(script), who, str(pids)])
    try:
        wait_for(lambda: len(list(pids.iterdir())) == count, "the workers did not begin")
    finally:
        asking.kill()
        asking.wait()
    workers = [int(file.name) for file in pids.iterdir()]
    wait_for(lambda: all(ended(pid) for pid in workers), "the workers stay")


def ended(pid):
    """Whether a process is over, also where nobody has asked yet how it ended."""
    import psutil

    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def test_a_script_without_a_guard_is_told_of_it(tmp_path):
    """Workers read a script anew: one that asks for processes at its top level hears why they end."""
    script = tmp_path / "mine.py"
    script.write_text(
        "from labrig._executor import Executor\nprint(dict(Executor(2).map(abs, [1, -2, 3])))\n"
    )
    ran = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60, check=False)
    guard = '`if __name__ == "__main__":`'
    lines = ran.stderr.splitlines()
    assert ran.returncode == 1
    assert lines[0] == f"labrig: several processes need {guard} around what a script does: each reads it anew"
    assert lines[-1].endswith(
        f"(killed, or out of memory, or no {guard} around what mine.py does?); what is done is kept"
    )
