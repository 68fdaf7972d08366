"""labrig run and its relatives, as a person types them."""

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

from labrig import open_run

RIG = {
    "name": "mannequin",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 10)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated", "rate_hz": 20},
    "simulated": {"surface": "mannequin", "seed": 0, "hidden": "sealed.json"},
}
MINE = '''
from labrig.campaign import Actuate, Procedure, Record, Settle


class Mine(Procedure):
    """One chamber, to a pressure."""

    high_kpa: float = 20.0
    gently: bool = True
    stops: tuple[float, ...] = (0.5, 1.0)

    def steps(self, rig):
        for stop in self.stops:
            yield Actuate(rig.setpoint(c1=stop * self.high_kpa))
            yield Settle(1.0 if self.gently else 0.1)
            yield Record(0.5)
'''

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a simulated rig and a user's procedure, as the current one."""
    from labrig_drivers.simulated import hide, seal

    monkeypatch.chdir(tmp_path)
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(RIG))
    (tmp_path / "mine.py").write_text(MINE)
    seal(tmp_path, hide("creep", seed=1))
    return tmp_path


def test_a_campaign_is_run_and_looked_at(lab: Path, labrig: Run) -> None:
    """run, runs, show, reveal, one after the other."""
    code, out, _ = labrig(
        "run", "capture", "--rig", "rig.yaml", "--captures", "4", "--repeated", "0", "--out", "one"
    )
    assert code == 0
    assert out == "one: 4 captures in 19 s, vented\n"
    assert open_run("one").sizes["capture"] == 4
    code, out, _ = labrig("runs", ".")
    assert code == 0
    assert out.splitlines()[1].split()[0] == "one"
    assert "capture" in out
    assert out.splitlines()[1].rstrip().endswith("completed")
    code, out, _ = labrig("show", "one")
    assert code == 0
    assert "captures    4 of 4" in out
    assert "12 (4 actuate, 4 settle, 4 record)" in out
    assert "mm/s at the end of the settle (median)" in out
    assert labrig("reveal", "one") == (
        0,
        "creep: 1 mm rms over random set-points of the whole range; at others it is more or less\n",
        "",
    )


def test_the_default_folder_is_new_each_time(lab: Path, labrig: Run) -> None:
    """Two runs in one second do not meet."""
    for _ in range(2):
        assert labrig("run", "mine.py", "--rig", "rig.yaml")[0] == 0
    assert len(list((lab / "runs").iterdir())) == 2


def test_a_finished_run_says_what_can_be_done_with_it(lab: Path, labrig: Run) -> None:
    """Neither --resume nor the same --out goes round in a circle: compare, or measure into another folder."""
    assert labrig("run", "mine.py", "--rig", "rig.yaml", "--out", "one")[0] == 0
    kept = (lab / "one" / "log.000.mcap").read_bytes()
    message = (
        "labrig: one is finished: all its 2 captures are there; compare a model with them "
        "(labrig compare one --model MODEL.yaml), or measure again into another --out\n"
    )
    assert labrig("run", "--resume", "one") == (2, "", message)
    assert labrig("run", "mine.py", "--rig", "rig.yaml", "--out", "one") == (2, "", message)
    assert (lab / "one" / "log.000.mcap").read_bytes() == kept


def test_runs_are_listed_from_where_one_is(lab: Path, labrig: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a folder: the runs in ./runs, where there is none those in the current folder, or what to name."""
    assert labrig("runs") == (
        2,
        "",
        "labrig: there is no folder runs here, and this one holds no runs; name the folder that does: "
        "labrig runs FOLDER\n",
    )
    assert labrig("run", "mine.py", "--rig", "rig.yaml", "--out", "runs/one")[0] == 0
    assert labrig("runs")[1].splitlines()[1].startswith("one ")
    monkeypatch.chdir(lab / "runs")
    assert labrig("runs")[1].splitlines()[1].startswith("one ")


def test_a_users_procedure_has_its_parameters_as_options(lab: Path, labrig: Run) -> None:
    """Numbers, flags and lists; help shows them."""
    words = ("--high-kpa", "12", "--no-gently", "--stops", "0.25,0.5,1")
    assert labrig("run", "mine.py", "--rig", "rig.yaml", "--out", "two", *words)[0] == 0
    run = open_run("two")
    assert run["commanded"][:, 0].to_numpy().tolist() == [3.0, 6.0, 12.0]
    facts = yaml.safe_load((lab / "two" / "run.yaml").read_text())
    assert facts["parameters"] == {"high_kpa": 12.0, "gently": False, "stops": [0.25, 0.5, 1.0]}
    code, out, _ = labrig("run", "mine.py", "--help")
    assert code == 0
    assert "mine: One chamber, to a pressure." in out
    assert "--stops" in out
    for word in (
        "--no-high-kpa",
        "--no-gently=0.5",
        "no-gently",
    ):  # only a switch can be off, and by its own word
        code, _, err = labrig("run", "mine.py", "--rig", "rig.yaml", "--out", "three", word)
        assert code == 2
        assert f"has no option {word.partition('=')[0]}; it has" in err
        assert not (lab / "three").exists()


def test_the_help_names_every_procedure(labrig: Run) -> None:
    """But the one that has a command of its own."""
    from labrig.api._procedures import shipped

    said = " ".join(labrig("run", "--help")[1].split())
    named = said.partition("a procedure: ")[2].partition(", or ")[0].split(", ")
    assert set(named) == set(shipped()) - {"validate"}


def test_a_dry_run_shows_the_plan_and_moves_nothing(lab: Path, labrig: Run) -> None:
    """Steps with their times, the estimate, and each limit that it would break, once; exit code 2 then."""
    code, out, _ = labrig("run", "mine.py", "--rig", "rig.yaml", "--dry-run")
    assert code == 0
    assert out.splitlines()[0] == "      0.0 s      0  actuate  [10 0 0 0 0 0 0 0 0] kPa"
    assert out.splitlines()[-1] == "6 steps, 2 captures on rig mannequin: 3 s"
    code, out, err = labrig("run", "mine.py", "--rig", "rig.yaml", "--dry-run", "--high-kpa", "61")
    assert code == 2
    assert out.splitlines()[-1] == "breaks a limit: step 3 (actuate): c1 61 kPa is above its limit of 60 kPa"
    assert err == "labrig: 1 limit would be broken; nothing was moved\n"
    more = labrig(
        "run", "mine.py", "--rig", "rig.yaml", "--dry-run", "--high-kpa", "61", "--stops", "1,1.1,0.9,1"
    )
    assert more[1].splitlines()[-1] == (
        "breaks a limit: step 0 (actuate): c1 61 kPa is above its limit of 60 kPa, and so 2 steps more"
    )
    assert labrig("run", "mine", "--rig", "rig.yaml")[2].endswith("; did you mean mine.py?\n")
    made = {path.name for path in lab.iterdir()} - {"__pycache__"}  # Python's own, beside what it reads
    assert made == {"mine.py", "rig.yaml", "sealed.json"}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("capture", "--captures", "4"),
            "name the rig with --rig RIG.yaml",
        ),
        (
            ("--rig", "rig.yaml"),
            "name a procedure (capture, ...; see labrig run --help), or a run with --resume",
        ),
        (
            ("capturo", "--rig", "rig.yaml"),
            "there is no procedure 'capturo'; there are capture, check, hold, idle, pairs, programme, repeatability, "
            "survey, sweep, validate, or name a file (my_procedure.py); did you mean capture?",
        ),
        (("none.py", "--rig", "rig.yaml"), "there is no file none.py"),
        (
            ("empty.py", "--rig", "rig.yaml"),
            "empty.py has no procedure: write a class that derives from labrig.campaign.Procedure",
        ),
        (("broken.py", "--rig", "rig.yaml"), "broken.py, line 3: NameError: name 'nonsense' is not defined"),
        (
            ("syntax.py", "--rig", "rig.yaml"),
            "syntax.py, line 1: is no Python (invalid syntax)",
        ),
        (("two.py", "--rig", "rig.yaml"), "two.py has several procedures; say which: two.py:A, two.py:B"),
        (("two.py:C", "--rig", "rig.yaml"), "two.py has no procedure C; it has A, B"),
        (
            ("mine.py", "--rig", "rig.yaml", "--hihg-kpa", "3"),
            "mine has no option --hihg-kpa; it has --high-kpa, --gently, --stops; did you mean --high-kpa?",
        ),
        (("mine.py", "--rig", "rig.yaml", "--high-kpa"), "mine: --high-kpa needs a value"),
        (
            ("mine.py", "--rig", "rig.yaml", "--high-kpa", "much"),
            "mine: --high-kpa: should be a valid number, not 'much'",
        ),
        (("mine.py", "--rig", "none.yaml"), "cannot read the rig none.yaml: No such file or directory"),
        (
            ("mine.py", "--resume", "one"),
            "--resume goes on with what the run was; it takes no procedure, parameters, --out or --dry-run",
        ),
        (("--resume", "one"), "one is no run folder; `labrig runs` lists those in ./runs"),
        (("--resume", "."), ". cannot be resumed: it has no run.yaml of `labrig run`"),
    ],
)
def test_a_mistake_is_one_line(lab: Path, labrig: Run, words: tuple[str, ...], message: str) -> None:
    """Exit code 2, and no folder is made."""
    (lab / "empty.py").write_text("x = 1\n")
    (lab / "broken.py").write_text("\n\nnonsense\n")
    (lab / "syntax.py").write_text("def (:\n")
    two = "class {}(Procedure):\n    pass\n"
    (lab / "two.py").write_text(f"from labrig.campaign import Procedure\n{two.format('A')}{two.format('B')}")
    assert labrig("run", *words) == (2, "", f"labrig: {message}\n")
    assert not (lab / "runs").exists()


def test_a_failure_says_how_to_go_on(lab: Path, labrig: Run) -> None:
    """The procedure's own error, where it is, and the command that resumes; which then works."""
    fault = "            if stop == 0.5 and __import__('pathlib').Path('one/log.000.mcap').exists():\n"
    (lab / "mine.py").write_text(f"{MINE}{fault}                raise ValueError('no more')\n")
    code, _, err = labrig("run", "mine.py", "--rig", "rig.yaml", "--out", "one")
    assert code == 2
    assert err.splitlines()[-1] == (
        "labrig: procedure mine failed at step 3: ValueError: no more (mine.py, line 18); "
        "the chambers are vented; to resume: labrig run --resume one"
    )


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")
@pytest.mark.parametrize(
    ("name", "word"), [("SIGINT", "Ctrl-C"), ("SIGTERM", "SIGTERM"), ("SIGHUP", "SIGHUP")]
)
def test_a_signal_ends_in_one_line_and_the_run_is_resumed(
    lab: Path, labrig: Run, name: str, word: str
) -> None:
    """Stopped in real time, vented, exit code 130; then resumed to its end."""
    facts = {**RIG, "mocap": {"kind": "simulated", "rate_hz": 20}}
    (lab / "rig.yaml").write_text(yaml.safe_dump(facts))
    words = [
        "--realtime",
        "--out",
        "one",
        "--captures",
        "4",
        "--repeated",
        "0",
        "--settle-s",
        "0.2",
        "--record-s",
        "0.2",
    ]
    code = "from labrig.cli import main; main()"
    command = [sys.executable, "-c", code, "run", "capture", "--rig", "rig.yaml", *words]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    begin = time.monotonic()
    while not _captures("one") and time.monotonic() - begin < 60:
        time.sleep(0.05)
    process.send_signal(getattr(signal, name))
    _, err = process.communicate(timeout=180)
    assert process.returncode == 130
    line = err.splitlines()[-1]
    assert line.startswith(f"labrig: stopped by {word} after ")
    assert line.endswith("; the chambers are vented; to resume: labrig run --resume one")
    done = _captures("one")
    assert 1 <= done < 4
    code, out, _ = labrig("run", "--resume", "one")
    assert code == 0
    assert out.startswith("one: 4 captures in ")
    assert set(open_run("one")["session"].to_numpy().tolist()) == {"0", "1"}


def _captures(run: str) -> int:
    from labrig import LabrigError
    from labrig.log import summarise

    try:
        return summarise(Path(run)).captures
    except LabrigError:
        return 0


def test_a_damaged_run_is_recovered(lab: Path, labrig: Run) -> None:
    """What was lost is printed, and the copy is complete."""
    labrig("run", "mine.py", "--rig", "rig.yaml", "--out", "one")
    log = lab / "one" / "log.000.mcap"
    log.write_bytes(log.read_bytes()[:-12_000])
    code, out, _ = labrig("recover", "one")
    assert code == 0
    assert out.startswith(
        "lost: log.000.mcap: not closed (the run was killed or goes on, or the file was cut)"
    )
    assert "one-recovered: " in out
    assert open_run("one-recovered").attrs["warnings"] == []
    assert labrig("recover", "one") == (
        2,
        "",
        "labrig: one-recovered exists already; choose another name or remove it\n",
    )


def test_a_run_that_is_refused_leaves_no_folder(
    lab: Path, labrig: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the disk has no room for it, nothing is measured, and the folder that was not there is not there."""
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=0))
    words = ("run", "capture", "--rig", "rig.yaml", "--captures", "4", "--out")
    assert labrig(*words, "one")[0] == 2
    assert not (lab / "one").exists()
    (lab / "two").mkdir()
    assert labrig(*words, "two")[0] == 2
    assert (lab / "two").is_dir()


@pytest.mark.skipif(sys.platform == "win32", reason="limits a file's size as POSIX does")
def test_a_disk_that_is_full_stops_the_run_and_loses_nothing_durable(lab: Path, labrig: Run) -> None:
    """A real write error in the middle of a run: one line, exit code 2; with room again, the run is resumed."""
    code = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (150_000, 150_000))"
    words = ["run", "capture", "--rig", "rig.yaml", "--out", "one", "--captures", "8", "--repeated", "0"]
    command = [sys.executable, "-c", f"{code}; from labrig.cli import main; main()", *words]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, timeout=180, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == (
        "labrig: the log in one cannot be written: File too large; the chambers are vented; "
        "to resume: labrig run --resume one"
    )
    kept = _captures("one")
    assert 1 <= kept < 8
    assert labrig("run", "--resume", "one")[0] == 0
    assert open_run("one").sizes["capture"] == 8


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo terminal")
def test_in_a_terminal_a_bar_is_drawn_and_p_pauses(lab: Path) -> None:
    """Keys are read while the run goes on; the bar says that it is paused, and the terminal is given back."""
    import os
    import pty
    import select
    import termios

    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    words = [
        "run",
        "capture",
        "--rig",
        "rig.yaml",
        "--out",
        "one",
        "--captures",
        "3",
        "--repeated",
        "0",
        "--realtime",
    ]
    command = [sys.executable, "-c", "from labrig.cli import main; main()", *words, "--settle-s", "0.3"]
    process = subprocess.Popen(command, stdin=theirs, stdout=subprocess.DEVNULL, stderr=theirs)
    seen, pressed = b"", 0
    begin = time.monotonic()
    while process.poll() is None and time.monotonic() - begin < 90:
        if select.select([ours], [], [], 0.1)[0]:
            seen += os.read(ours, 65536)
        if (pressed == 0 and b"1/3 captures" in seen) or (
            pressed == 1 and b"paused (vented; p goes on)" in seen
        ):
            os.write(ours, b"p")
            pressed += 1
    process.kill()
    process.wait()
    after = termios.tcgetattr(theirs)
    os.close(ours)
    os.close(theirs)
    assert pressed == 2
    assert process.returncode == 0
    assert after == before
    assert b"3/3 captures" in seen
    assert open_run("one").sizes["capture"] == 3
