"""Long work: what is known of it lies in files."""

import json
import signal
import subprocess
import sys

import psutil
import pytest

from labrig._errors import LabrigError
from labrig.workbench import open_desk
from labrig.workbench._jobs import KEPT
from labrig.workbench._locked import hold, is_held
from tests.waiting import wait_for


@pytest.fixture
def desk(tmp_path):
    """A desk without a server, whose jobs are ended with the test."""
    desk = open_desk(tmp_path)
    yield desk
    for job in desk.jobs.all():
        desk.jobs.cancel(job, harder=True)
    assert desk.jobs.wait(20)


@pytest.fixture
def long_job(desk):
    """A job that would go on for minutes: a command of labrig that serves a page until it is ended."""
    job = desk.jobs.start(["workbench", ".", "--no-browser"], "long", "a/run")
    wait_for(lambda: "http://" in job.output())
    return job


def test_a_job_is_a_labrig_command(desk):
    """A job runs the command that it shows, keeps its output, and is done."""
    job = desk.jobs.start(["effects", "list"], "list")
    wait_for(lambda: job.state != "running")
    assert (job.state, job.command) == ("done", "labrig effects list")
    assert "creep" in job.output()
    assert desk.jobs.usual_s(["effects", "list", "--out", "other"]) > 0
    assert desk.jobs.usual_s(["effects", "show", "creep"]) is None  # another run may take ten times as long
    assert desk.jobs.usual_s(["compare"]) is None


@pytest.mark.parametrize(
    "text",
    ["{}", "[]", "null", '{"words": null, "title": "x", "run": "", "started_s": 1}', '{"words": ["x"]}'],
)
def test_a_job_of_another_form_hides_no_other(desk, text):
    """What another release wrote, or nobody's hand, is passed over, and how a job ended as well."""
    job = desk.jobs.start(["--version"], "version")
    wait_for(lambda: job.state != "running")
    other = desk.jobs.folder / "99990101-000000-000000000-abcd"
    other.mkdir()
    (other / "job.json").write_text(text)
    assert [each.id for each in desk.jobs.all()] == [job.id]
    (job.folder / "ended.json").write_text(text)
    assert desk.jobs.get(job.id).facts()["state"] == "failed"


def test_a_failed_job_says_why(desk):
    """The last line of a job that failed is the command's one line."""
    job = desk.jobs.start(["show", "nothing"], "show")
    wait_for(lambda: job.state != "running")
    assert job.state == "failed"
    assert job.facts()["last"].startswith("labrig: ")


def test_a_job_can_be_cancelled(desk, long_job):
    """A cancelled job ends by itself, as with Ctrl-C, and is called cancelled or done, not failed."""
    assert long_job.state == "running"
    desk.jobs.cancel(long_job)
    wait_for(lambda: long_job.state != "running")
    assert long_job.ended is not None
    assert long_job.state in ("cancelled", "done")


@pytest.mark.skipif(sys.platform == "win32", reason="Windows hands no ignored signals down")
def test_a_job_is_cancelled_at_once_by_a_server_that_ignores_ctrl_c(desk):
    """What runs in the background of a shell ignores Ctrl-C, and so does what it starts, until that says otherwise."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        job = desk.jobs.start(["workbench", ".", "--no-browser"], "long")
        desk.jobs.cancel(job)
    finally:
        signal.signal(signal.SIGINT, before)
    wait_for(lambda: job.state != "running")
    assert job.state == "cancelled"


def test_a_job_is_cancelled_between_its_start_and_that_of_its_command(tmp_path):
    """Who cancels as the command is being started is not forgotten."""
    code = (
        "import signal, subprocess, sys; from labrig.workbench import _child; Popen = subprocess.Popen\n"
        "def pressed(*args, **kwargs):\n"
        "    signal.raise_signal(signal.SIGINT)\n"
        "    return Popen(*args, **kwargs)\n"
        "subprocess.Popen = pressed; _child.main()"
    )
    words = ["workbench", ".", "--no-browser"]
    subprocess.run([sys.executable, "-c", code, tmp_path, *words], cwd=tmp_path, check=True, timeout=180)
    assert json.loads((tmp_path / "ended.json").read_text())["code"] != 0


def test_the_same_work_is_not_begun_twice(desk, long_job):
    """A command that runs already is refused."""
    with pytest.raises(LabrigError, match="runs already"):
        desk.jobs.start(long_job.words, "again")


def test_another_server_on_the_folder_knows_the_jobs(desk, long_job, tmp_path):
    """A second workbench, or the next one, sees what runs and can cancel it."""
    other = open_desk(tmp_path)
    (seen,) = other.jobs.all()
    assert (seen.facts(), seen.state, seen.run) == (long_job.facts(), "running", "a/run")
    other.jobs.cancel(seen)
    wait_for(lambda: seen.state != "running")


def test_a_job_that_was_killed_is_not_running(desk, long_job):
    """What was killed with all that watches it counts as ended, without having said so."""
    desk.jobs.cancel(long_job, harder=True)
    wait_for(lambda: long_job.state != "running")
    assert long_job.ended is None
    assert long_job.state == "cancelled"


def test_a_job_outlives_its_server(tmp_path, desk):
    """Work that a server began goes on when the server is gone."""
    code = (
        "import sys; from pathlib import Path; from labrig.workbench import open_desk; "
        "open_desk(Path(sys.argv[1])).jobs.start(['workbench', '.', '--no-browser'], 'long'); import os; os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=True, timeout=180)
    (job,) = desk.jobs.all()
    wait_for(lambda: "http://" in job.output())
    assert job.state == "running"
    desk.jobs.cancel(job)
    wait_for(lambda: job.state != "running")


def test_a_job_that_is_killed_before_it_begins_has_ended(desk):
    """A job is running while its process starts; where that dies before it holds anything, the server writes so."""
    job = desk.jobs.start(["workbench", ".", "--no-browser"], "long")
    process = psutil.Process(int((job.folder / "pid").read_text()))
    process.suspend()
    (job.folder / "alive").write_bytes(b"")  # opened, and not yet held
    assert desk.jobs.get(job.id).state == "running"
    process.kill()
    wait_for(lambda: desk.jobs.get(job.id).state != "running")
    assert job.state == "failed"
    assert job.ended.code != 0


def test_two_that_look_at_once_do_not_take_each_other_for_the_holder(tmp_path):
    """Whether a file is held does not depend on others that look."""
    path = tmp_path / "alive"
    path.write_bytes(b"held")
    with path.open("rb+") as other:
        fcntl = pytest.importorskip("fcntl", reason="Windows has no shared lock in its standard library")
        fcntl.flock(other, fcntl.LOCK_SH)
        assert not is_held(path)
    with hold(path):
        assert is_held(path)


def test_a_job_that_goes_on_stays_in_sight_however_many_began_after_it(desk):
    """A long job can be found and cancelled, and is not begun twice, after any number of short ones."""
    about = {"words": ["run", "capture"], "title": "long", "run": "a", "started_s": 0.0}
    names = [f"{number:03d}" for number in range(KEPT + 2)]
    for name in names:
        (desk.jobs.folder / name).mkdir(parents=True)
        (desk.jobs.folder / name / "job.json").write_text(json.dumps(about))
        (desk.jobs.folder / name / "ended.json").write_text(json.dumps({"code": 0, "ended_s": 1.0}))
    (desk.jobs.folder / names[0] / "ended.json").unlink()
    with hold(desk.jobs.folder / names[0] / "alive") as alive:
        alive.write(b"held")
        alive.flush()
        assert desk.jobs.get(names[0]).state == "running"
        with pytest.raises(LabrigError, match="runs already"):
            desk.jobs.start(["run", "capture"], "again")
