"""A rig that speaks the real devices' bytes, whose true pressures a test can see, and a workbench opened for it."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import labrig
from labrig_drivers import RealClock
from labrig_drivers.simulated import build_plant
from labrig_drivers.simulated._twins import TwinOptions, TwinRig
from tests.rigs import MODEL as SIMULATOR
from tests.rigs import RIG
from tests.waiting import wait_for

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")

SLOW_S = 40.0
SMALL = """
name: small
chambers: [{name: c1, max_kpa: 60}, {name: c2, max_kpa: 60}, {name: c3, max_kpa: 60}, {name: c4, max_kpa: 60}]
pressure: {kind: simulated}
mocap: {kind: simulated}
simulated: {surface: membrane, occlusion: 0.0}
"""
MODEL = """
import numpy as np

SLOPE = np.array({slope})


def predict(actuation):
    return np.hstack([np.ones((len(actuation), 1)), actuation]) @ SLOPE + {off}
"""


@dataclass
class Rig:
    """The twins of a rig, and what is true of their chambers."""

    file: Path
    twins: TwinRig

    @property
    def highest_kpa(self) -> float:
        """The highest true pressure of a chamber now."""
        return float(abs(self.twins.plant.pressure_kpa()).max())

    def wait_above(self, pressure_kpa: float) -> None:
        """Wait until some chamber holds more."""
        wait_for(lambda: self.highest_kpa > pressure_kpa, "no chamber was filled")


@pytest.fixture
def until() -> Callable[..., Any]:
    """Waits for something."""
    return wait_for


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    """The reduced mannequin behind an OpenPneu twin and a motion capture server, for all tests of a file."""
    folder = tmp_path_factory.mktemp("rig") / "desk"
    folder.mkdir()
    content = {"name": "bench", "simulated": {"surface": "mannequin", "seed": 1, "occlusion": 0.0}}
    plant = build_plant(content, folder.parent)
    options = TwinOptions(boot_s=0.0, rate_hz=50.0)
    with TwinRig(plant, "bench", folder, RealClock(), options) as twins:
        described = {key: value for key, value in twins.rig.items() if key != "scanner"}
        described["safety"] = {"heartbeat_s": 1.0, "vent_patience_s": 20.0}
        file = folder / "rig.yaml"
        file.write_text(yaml.safe_dump(described), encoding="utf-8")
        yield Rig(file, twins)


@pytest.fixture
def rig(desk: Rig) -> Iterator[Rig]:
    """The rig of the file's tests: vented, its file as it was, and nothing else in its folder but what others left."""
    text = desk.file.read_text(encoding="utf-8")
    assert desk.highest_kpa < 3.0
    yield desk
    desk.file.write_text(text, encoding="utf-8")


@dataclass
class Bench:
    """A `labrig workbench` in a process of its own, and a way to ask it as its page does."""

    process: Any
    address: str
    folder: Path
    spent: bool = False
    """Whether the next test needs another one."""
    rig_token: str = field(init=False, repr=False)
    token: str = field(init=False, repr=False)
    origin: str = field(init=False)

    def __post_init__(self) -> None:
        self.origin, _, secrets = self.address.partition("/?token=")
        self.token, _, self.rig_token = secrets.partition("#rig=")

    @classmethod
    def of(cls, running: Any) -> "Bench":
        """A workbench that runs in this process."""
        return cls(None, running.address, running.desk.folder)

    def ask(self, path: str, body: dict[str, Any] | None = None, rig: bool = True) -> Any:
        """GET, or POST with a body; `(status, content)`."""
        headers = {"x-labrig-token": self.token, "content-type": "application/json"}
        if rig:
            headers["x-labrig-rig"] = self.rig_token
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.origin + path, data=data, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=180) as answer:
                return answer.status, json.loads(answer.read())
        except urllib.error.HTTPError as error:
            return error.code, json.loads(error.read())

    def vent_address(self) -> str:
        """Where its vent button is."""
        vent = self.ask("/api/watch/rig")[1]["vent"]
        return f"http://127.0.0.1:{vent['port']}/{vent['key']}/"

    def start(self, name: str, *arguments: object) -> str:
        """Begin a run, of this name or the next one that is free; gives its name."""
        name = next(
            n for n in (name, *(f"{name}-{i}" for i in range(2, 99))) if not (self.folder / n).exists()
        )
        asked = {"procedure": "capture", "arguments": list(map(str, arguments))}
        status, content = self.begin(name, asked)
        assert status == 202, content
        return str(content["run"])

    def begin(self, name: str, asked: dict[str, Any], **more: Any) -> tuple[int, Any]:
        """Show the plan of what is asked for, and start it; `(status, content)`."""
        status, plan = self.ask("/api/watch/plan", asked)
        assert status == 200, plan
        return self.ask("/api/watch/start", {**asked, **more, "plan": plan["plan"], "out": name})

    def now(self, run: str, **more: Any) -> dict[str, Any]:
        """How a run stands."""
        query = "&".join(f"{key}={value}" for key, value in {"run": run, **more}.items())
        return self.ask(f"/api/watch/now?{query}")[1]

    def live(self, run: str) -> dict[str, Any]:
        """Wait until a run answers."""

        def state() -> dict[str, Any] | None:
            found = self.now(run)
            return found if found.get("live") and found.get("position_mm") else None

        return wait_for(state, "the run does not answer")

    def stop(self) -> str:
        """Ctrl-C; what it said."""
        self.process.send_signal(signal.SIGINT)
        return self.process.communicate(timeout=180)[0]


def press(address: str) -> str:
    """Press the vent button, and look until it has said how that ended; gives what it says."""
    posted = urllib.request.Request(address + "vent", data=b"", method="POST")
    with urllib.request.urlopen(posted, timeout=180) as answer:
        text = answer.read().decode()
    end = time.monotonic() + SLOW_S
    while "venting" in text and time.monotonic() < end:
        time.sleep(0.2)
        text = said_at(address)
    return text


def said_at(address: str) -> str:
    """What the vent button at an address says now of the last vent."""
    with urllib.request.urlopen(address + "said", timeout=180) as answer:
        return str(answer.read().decode())


@pytest.fixture
def vent_says() -> Callable[[str], str]:
    """What the button at an address says now, without pressing it."""
    return said_at


@pytest.fixture
def press_vent() -> Callable[[str], str]:
    """Presses the button at an address and gives the page that says how it ended."""
    return press


@pytest.fixture(scope="module")
def opened(desk: Rig) -> Iterator[list[Bench]]:
    """The workbench that the file's tests share: none yet, or the one that is open."""
    benches: list[Bench] = []
    yield benches
    for bench in benches:
        _close(bench)


@pytest.fixture
def bench(rig: Rig, opened: list[Bench]) -> Iterator[Bench]:
    """The workbench of the rig's folder; another one where the test before ended it. No run outlives its test."""
    if not opened:
        opened.append(_open(rig))
    bench = opened[0]
    yield bench
    with contextlib.suppress(ProcessLookupError):
        bench.process.send_signal(getattr(signal, "SIGCONT", signal.SIGTERM))
    _end_runs(bench.folder)
    if bench.spent or bench.process.poll() is not None:
        _close(opened.pop())
    elif rig.highest_kpa >= 3.0:
        press(bench.vent_address())


def _open(rig: Rig) -> Bench:
    folder = rig.file.parent
    process = subprocess.Popen(
        [sys.executable, "-m", "labrig", "workbench", str(folder), "--rig", str(rig.file), "--no-browser"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )
    return Bench(process, _address(process), folder)


def _close(bench: Bench) -> None:
    if bench.process.poll() is None:
        bench.process.terminate()
        bench.process.communicate(timeout=180)
    if bench.process.stdout is not None:
        bench.process.stdout.close()


def _address(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    for line in process.stdout:
        if line.strip().startswith("http://"):
            return line.strip()
    raise AssertionError("the workbench did not start")


def _end_runs(folder: Path) -> None:
    """No run outlives its test."""
    from labrig import LabrigError
    from labrig._running import notes

    def going() -> list[Any]:
        return [n for what in ("run", "guard") for n in notes(what) if str(folder) in json.dumps(n.facts)]

    for note in going():
        with contextlib.suppress(LabrigError):
            note.ask("end", 2.0, why="the test is over")
    wait_for(lambda: not any(_alive(note) for note in going()), "a run goes on", 20.0)


def _alive(note: Any) -> bool:
    from labrig import LabrigError

    try:
        note.ask("nothing", 2.0)
    except LabrigError as error:
        return "ended" not in str(error)
    return True


@pytest.fixture(scope="session")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run of a simulated rig and two models, one a millimetre worse; each test has a copy."""
    folder = tmp_path_factory.mktemp("measured")
    (folder / "rig.yaml").write_text(SMALL, encoding="utf-8")
    labrig.run("capture", folder / "rig.yaml", out=folder / "runs" / "run", captures=16)
    run = labrig.open_run(folder / "runs" / "run")
    position = run["position_mm"].mean("time").values.reshape(16, -1)
    pressure = np.hstack([np.ones((16, 1)), run["commanded"].values])
    slope = np.linalg.lstsq(pressure, position, rcond=None)[0].tolist()
    for name, off in (("better", 0.0), ("worse", 9.0)):
        (folder / f"{name}.py").write_text(MODEL.format(slope=slope, off=off), encoding="utf-8")
        content = f"base: {{kind: python, file: {name}.py, function: predict}}\neffects: []\n"
        (folder / f"{name}.yaml").write_text(content, encoding="utf-8")
    return folder


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[Callable[[str], Bench]]:
    """Opens a workbench in this process on a small simulated rig that hides something, a run of it and its model."""
    from labrig.workbench import open_desk, start
    from labrig_drivers.simulated import hide, seal

    opened = []

    def make(hidden: str) -> Bench:
        folder = tmp_path / "lab"
        folder.mkdir()
        (folder / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
        (folder / "model.yaml").write_text(SIMULATOR, encoding="utf-8")
        seal(folder, hide(hidden, seed=1))
        labrig.run("capture", folder / "rig.yaml", out=folder / "first", captures=16)
        opened.append(start(open_desk(folder, folder / "rig.yaml")))
        return Bench.of(opened[0])

    yield make
    for running in opened:
        for job in running.desk.jobs.all():
            _cancel(running, job)
        assert running.desk.jobs.wait(60)
        running.stop()


def _cancel(running: Any, job: Any) -> None:
    """A job that has only just begun is asked again, for ten seconds."""
    for _ in range(50):
        try:
            return running.desk.jobs.cancel(job)
        except labrig.LabrigError:
            time.sleep(0.2)
    return running.desk.jobs.cancel(job)


@pytest.fixture
def asked(tmp_path: Path, measured: Path) -> Iterator[Bench]:
    """A workbench in this process, on a run of a simulated rig and two models, one a millimetre worse."""
    from labrig.workbench import open_desk, start

    folder = Path(shutil.copytree(measured, tmp_path / "desk"))
    running = start(open_desk(folder, folder / "rig.yaml"))
    yield Bench.of(running)
    assert running.desk.jobs.wait(30)
    running.stop()
