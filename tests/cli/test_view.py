"""`labrig view`: a run becomes a recording, or the viewer says why it cannot be seen."""

import signal
import subprocess
import sys

import pytest

from labrig.cli import main


def view(capsys, *arguments):
    """Run `labrig view` in this process: exit code, output, errors."""
    with pytest.raises(SystemExit) as ended:
        main(["view", *map(str, arguments)])
    out, err = capsys.readouterr()
    return ended.value.code, out, err


def test_what_does_not_exist(tmp_path, capsys):
    """A run that does not exist is one line and exit code 2."""
    run = tmp_path / "nowhere"
    expected = f"labrig: {run} does not exist; name a run folder, an .mcap log or an .rrd recording\n"
    assert view(capsys, run) == (2, "", expected)


def test_nothing_is_overwritten(tmp_path, capsys):
    """A recording that exists is not overwritten."""
    (tmp_path / "demo.rrd").write_bytes(b"old")
    saved = tmp_path / "saved.rrd"
    saved.write_bytes(b"mine")
    expected = f"labrig: {saved} exists already; choose another name for the recording\n"
    assert view(capsys, tmp_path, "--save", saved) == (2, "", expected)
    assert saved.read_bytes() == b"mine"


def test_a_recording_is_taken_as_it_is(tmp_path, capsys):
    """A folder that holds a recording already is shown by it."""
    (tmp_path / "demo.rrd").write_bytes(b"recorded")
    saved = tmp_path / "saved.rrd"
    assert view(capsys, tmp_path, "--save", saved) == (0, f"recording: {saved}\n", "")
    assert saved.read_bytes() == b"recorded"


def test_a_folder_that_is_not_there_is_not_made(tmp_path, capsys):
    """A misspelt folder for the recording is refused, and is not there afterwards."""
    (tmp_path / "demo.rrd").write_bytes(b"recorded")
    saved = tmp_path / "none" / "saved.rrd"
    expected = f"labrig: {saved}: the folder {saved.parent} does not exist\n"
    assert view(capsys, tmp_path, "--save", saved) == (2, "", expected)
    assert not saved.parent.exists()


def test_a_folder_without_a_run(tmp_path, capsys):
    """A folder that holds no log is told apart from a run, and no recording is left."""
    code, out, err = view(capsys, tmp_path, "--save", tmp_path / "saved.rrd")
    assert (code, out) == (2, "")
    assert err.startswith("labrig: ")
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a screen")
def test_without_a_screen(tmp_path):
    """Where there is no screen, one line says how to watch all the same."""
    (tmp_path / "demo.rrd").write_bytes(b"")
    ran = subprocess.run(
        [sys.executable, "-c", "from labrig.cli import main; main()", "view", str(tmp_path)],
        env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (
        2,
        "",
        "labrig: the rerun viewer found no screen; use --serve to watch in a browser, "
        "or open the .rrd file elsewhere\n",
    )


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT", "SIGHUP"])
def test_no_viewer_is_left_behind(tmp_path, name):
    """However `labrig view --serve` is told to end, the viewer that it started ends with it, and so does its port."""
    psutil = pytest.importorskip("psutil")
    (tmp_path / "demo.rrd").write_bytes(b"")
    command = [sys.executable, "-m", "labrig", "view", str(tmp_path), "--serve"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as serving:
        line = serving.stdout.readline()
        assert line.startswith("open http://127.0.0.1:"), serving.stderr.read()
        viewers = psutil.Process(serving.pid).children(recursive=True)
        assert viewers
        serving.send_signal(getattr(signal, name))
        assert (serving.wait(60), serving.stderr.read()) == (0, "")
    _, left = psutil.wait_procs(viewers, timeout=180)
    assert left == []
