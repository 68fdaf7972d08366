"""What the tests of several packages need: the command line in process, and a small laboratory of their own.

The laboratory's formulas are its own too: nothing of it comes from `labrig.effects` or `drivers.simulated`.
"""

import gc
import os
import shutil
import signal
import stat
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import settings

if TYPE_CHECKING:
    import xarray as xr
    from playwright.sync_api import Browser

    from labrig.model import Model

CHROMIUM = next((p for name in ("chromium", "chromium-browser") if (p := shutil.which(name))), None)
HIGH_KPA = 60.0
GAP_S = 2.0
NIGHT_S = 3600.0

BASE = """
from pathlib import Path

import numpy as np

with np.load(Path(__file__).with_name("base.npz")) as file:
    KNOWN = dict(file)


def predict(actuation):
    x = actuation / KNOWN["high"]
    return KNOWN["rest"] + (x * (1 + KNOWN["bent"]) / (1 + KNOWN["bent"] * x)) @ KNOWN["reach"].T
"""


# no example fails because others are at work, too
settings.register_profile("shared computer", deadline=None)
settings.load_profile("shared computer")

if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) == signal.SIG_IGN:
    signal.signal(signal.SIGHUP, lambda *_: None)  # under nohup what the tests start hears of it all the same

gc.disable()  # all that is imported and collected stays


def pytest_collection_finish() -> None:
    """From here on what a test leaves is collected, and what all of them share is not looked through each time."""
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with slow tests come first: at the end no process is left alone with one of them.

    Those of one folder are spread: what computes (effects, diagnosis) runs beside what waits (devices, pages).
    """
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    folders: dict[tuple[bool, Path], list[Path]] = {}
    for path in dict.fromkeys(item.path for item in items):
        folders.setdefault((path not in slow, path.parent), []).append(path)
    order = {
        path: (later, (i + 0.5) / len(own))
        for (later, _), own in folders.items()
        for i, path in enumerate(own)
    }
    items.sort(key=lambda item: order[item.path])


@pytest.fixture(scope="session", autouse=True)
def _cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What simulated rigs keep is shared by all tests, also by those of other processes, and goes when they end."""
    folder = tmp_path_factory.getbasetemp()
    together = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LABRIG_CACHE", str(together / "cache"))
        yield


@pytest.fixture(scope="session")
def browser() -> "Iterator[Browser]":
    """The system's Chromium, without a window."""
    if CHROMIUM is None:
        pytest.skip("no Chromium here: .ci/system-libraries browser installs it")
    from playwright.sync_api import sync_playwright

    drawing = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    # putting pages together by a processor that is only simulated took most of their time
    drawing.append("--disable-gpu-compositing")
    sandbox = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=[*sandbox, *drawing])
        yield chromium
        chromium.close()


@pytest.fixture
def labrig(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Type a command; returns its exit code, what it printed, and its complaints."""

    def type_command(*words: object) -> tuple[int, str, str]:
        from labrig.cli import main

        with pytest.raises(SystemExit) as caught:
            main([str(w) for w in words])
        printed = capsys.readouterr()
        return int(caught.value.code or 0), printed.out, printed.err

    return type_command


@pytest.fixture
def few_effects(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Has models ask about these effects alone: diagnoses, and what is planned after them, take far less time."""
    from labrig.model import Model

    whole = Model.library
    return lambda *names: monkeypatch.setattr(
        Model, "library", lambda self: {name: whole(self)[name] for name in names}
    )


@dataclass
class Lab:
    """A rig, a programme of set-points, and what is measured on it.

    Chambers stand in a row, `markers` over them; each marker moves along its own normal. With `force` there
    is one force, N, instead. `bent` makes every chamber's response saturate (0: linear). Every tenth hold is
    long. `rows_s` are the moments of the rows of a hold, `long_s` those of a long one. A stretch of two
    set-points comes back now and then: repeats with the same history.
    """

    folder: Path
    chambers: int = 3
    markers: int = 6
    captures: int = 60
    rows_s: tuple[float, ...] = (3.0, 3.5, 4.0)
    long_s: tuple[float, ...] = ()
    sessions: int = 1
    between: str = "vented"
    force: bool = False
    bent: float = 0.8
    reach_mm: float = 20.0
    seed: int = 0
    repeats: bool = True
    random: np.random.Generator = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.random = np.random.default_rng(self.seed)
        C = self.chambers
        if self.force:
            self.rest = np.zeros(1)
            self.reach = np.linspace(50.0, 40.0, C)[None]
        else:
            at = np.linspace(0, C - 1, self.markers)
            weight = np.exp(-(((at[:, None] - np.arange(C)) / 0.7) ** 2))
            tilt = 0.5 * np.sin(np.arange(self.markers))
            normal = np.stack([np.sin(tilt), 0.3 * np.cos(3 * tilt), np.cos(tilt)], axis=1)
            self.rest_mm = np.stack([30 * at, 10 * np.cos(at), 5 * np.sin(2 * at)], axis=1)
            self.rest = self.rest_mm.ravel()
            self.reach = self.reach_mm * (weight[:, None, :] * normal[:, :, None]).reshape(-1, C)
        self.commanded = self._programme()
        n = len(self.commanded)
        lengths = [self.rows_s if i % 10 != 5 or not self.long_s else self.long_s for i in range(n)]
        self.hold_s = np.full((n, max(map(len, lengths))), np.nan)
        for i, rows in enumerate(lengths):
            self.hold_s[i, : len(rows)] = rows
        self.session = (np.arange(n) * self.sessions) // n
        took = np.array([rows[-1] + GAP_S for rows in lengths])
        self.event_s = np.concatenate([[0.0], np.cumsum(took)[:-1]]) + NIGHT_S * self.session
        self.time_s = self.hold_s + self.event_s[:, None]

    def _programme(self) -> np.ndarray:
        u = self.random.uniform(0, HIGH_KPA, (self.captures, self.chambers)).round(1)
        self.label = [""] * self.captures
        if self.repeats:
            for i in range(4, self.captures - 1, 10):
                u[i], u[i + 1] = u[4], u[5]
                self.label[i + 1] = "again"
        return u

    @property
    def u(self) -> np.ndarray:
        """Pressures of the rows as commanded, (n, T, C)."""
        return np.repeat(self.commanded[:, None], self.hold_s.shape[1], axis=1)

    def predict(self, u: np.ndarray) -> np.ndarray:
        """What the rig does at pressures (..., C), (..., K); what its base model says too."""
        x = u / HIGH_KPA
        return self.rest + (x * (1 + self.bent) / (1 + self.bent * x)) @ self.reach.T

    def path(self, points: int = 20) -> Iterator[tuple[int, np.ndarray]]:
        """From event to event: its number, and the way to it in small straight steps, (points, C)."""
        last = np.zeros(self.chambers)
        for i, u in enumerate(self.commanded):
            if i and self.session[i] != self.session[i - 1] and self.between != "held":
                last = np.zeros(self.chambers)
            yield i, last + (u - last) * np.linspace(0, 1, points + 1)[1:, None]
            last = u

    def looped(self, size_kpa: float, width: float = 0.08) -> np.ndarray:
        """Pressures of the rows with a Bouc-Wen loop on them (Wen 1976); it turns within `width` of the range."""
        u, z, last = self.u, np.zeros(self.chambers), np.zeros(self.chambers)
        for i, way in self.path(60):
            for point in way:
                d = (point - last) / HIGH_KPA
                z = z + d / width * (1 - np.abs(z) ** 1.4 * (0.5 * np.sign(d * z) + 0.5))
                last = point
            u[i] -= size_kpa * z
        return u

    def noise(self, row: float = 0.05, capture: float = 0.1) -> np.ndarray:
        """White noise of rows and of captures, (n, T, K)."""
        n, T, K = *self.hold_s.shape, len(self.rest)
        return row * self.random.normal(size=(n, T, K)) + capture * self.random.normal(size=(n, 1, K))

    def dataset(
        self, values: np.ndarray, covariates: dict[str, tuple[str, np.ndarray]] | None = None
    ) -> "xr.Dataset":
        """Measured values (n, T, K) as a campaign's Dataset; `covariates`: name -> unit, values (n,)."""
        import xarray as xr

        n, T = self.hold_s.shape
        values = np.where(np.isfinite(self.hold_s)[:, :, None], values, np.nan)
        names = [f"s{s}" for s in self.session]
        data = {
            "commanded": (("capture", "chamber"), self.commanded, {"units": "kPa"}),
            "hold_s": (("capture", "time"), self.hold_s),
            "time_s": (("capture", "time"), self.time_s),
            "settled": (("capture", "time"), np.isfinite(self.hold_s)),
            "event_time_s": ("event", self.event_s),
            "event_commanded": (("event", "chamber"), self.commanded, {"units": "kPa"}),
        }
        coords = {
            "capture": np.arange(n),
            "chamber": [f"c{c + 1}" for c in range(self.chambers)],
            "chamber_min": ("chamber", np.zeros(self.chambers)),
            "chamber_max": ("chamber", np.full(self.chambers, HIGH_KPA)),
            "session": ("capture", names),
            "event_session": ("event", names),
            "event_of": ("capture", np.arange(n)),
            "repeat": ("capture", self.label),
        }
        if self.force:
            data["observed"] = (("capture", "time", "observable"), values)
            coords |= {"observable": ["force"], "unit": ("observable", ["N"])}
            coords |= {"marker_of": ("observable", [""]), "axis_of": ("observable", [""])}
        else:
            data["position_mm"] = (("capture", "time", "marker", "axis"), values.reshape(n, T, -1, 3))
            data["rest_mm"] = (("marker", "axis"), self.rest_mm)
            coords |= {"marker": [f"m{m}" for m in range(self.markers)], "axis": list("xyz")}
        if covariates:
            rows = np.stack([np.repeat(v[:, None], T, axis=1) for _, v in covariates.values()], axis=2)
            rows = np.where(np.isfinite(self.hold_s)[:, :, None], rows, np.nan)
            data["covariates"] = (("capture", "time", "covariate"), rows)
            coords["covariate"] = list(covariates)
            coords["covariate_unit"] = ("covariate", [u for u, _ in covariates.values()])
        return xr.Dataset(data, coords=coords, attrs={"source": "table", "between_sessions": self.between})  # type: ignore[arg-type]

    def model(self, effects: str = "[]") -> "Model":
        """The rig's own formula as a Python base in `folder`, with the effects given as YAML."""
        from labrig.model import Model

        np.savez(self.folder / "base.npz", rest=self.rest, bent=self.bent, reach=self.reach, high=HIGH_KPA)
        (self.folder / "base.py").write_text(BASE)
        path = self.folder / "model.yaml"
        path.write_text(f"base: {{kind: python, file: base.py, function: predict}}\neffects: {effects}\n")
        return Model.load(path)


@pytest.fixture
def make_lab(tmp_path: Path) -> Callable[..., Lab]:
    """Builds a laboratory in the test's own folder."""
    return lambda **settings: Lab(tmp_path, **settings)


class Disk:
    """A disk as a power cut leaves it: of each file what its last fsync saw, of each folder the names at its last.

    Windows makes names durable by itself, and has no fsync of folders: all names are known there.
    """

    def __init__(self) -> None:
        self._bytes: dict[int, int] = {}
        self._names: dict[int, dict[str, int]] = {}

    def fsync(self, number: int) -> None:
        """Stands in for `os.fsync`."""
        status = os.fstat(number)
        if stat.S_ISDIR(status.st_mode):
            with os.scandir(number) as entries:
                self._names[status.st_ino] = {entry.name: entry.inode() for entry in entries}
        else:
            self._bytes[status.st_ino] = status.st_size

    def cut(self, folder: Path, target: Path) -> Path:
        """Copy what would be left of a folder to `target`, which it returns."""
        target.mkdir()
        known = self._names.get(folder.stat().st_ino, {})
        for path in folder.iterdir():
            number = path.stat().st_ino
            if os.name == "posix" and known.get(path.name) != number:
                continue
            if path.is_dir():
                self.cut(path, target / path.name)
            else:
                (target / path.name).write_bytes(path.read_bytes()[: self._bytes.get(number, 0)])
        return target


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Disk:
    """Whatever is written in this test is lost to a power cut unless it was synced."""
    disk = Disk()
    monkeypatch.setattr("os.fsync", disk.fsync)
    return disk
