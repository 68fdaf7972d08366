"""A small plant of air and markers, and devices and twins over it that never outlive a test."""

import socket
import threading
import time
from functools import partial

import numpy as np
import pytest

from labrig_drivers import Channel, RealClock
from labrig_drivers.simulated._wire_plant import SharedPlant
from tests.waiting import wait_for

CHAMBERS = ("c1", "c2", "c3", "c4")
MARKERS = tuple(f"m{number:02d}" for number in range(1, 35))


class SmallPlant:
    """Chambers that follow their set-points with a time constant of 30 ms; markers rise with the mean."""

    def __init__(self, chambers=CHAMBERS, markers=MARKERS):
        self.channels = tuple(Channel(name, 0.0, 60.0, 1000.0) for name in chambers)
        self.chamber_names = tuple(chambers)
        self.marker_names = tuple(markers)
        self.rest_mm = np.arange(3.0 * len(markers)).reshape(-1, 3)
        self.occluded = set()
        self.commands = []
        self.stuck_kpa = None
        self._time_s = 0.0
        self._pressure_kpa = np.zeros(len(chambers))
        self._target_kpa = np.zeros(len(chambers))

    def command(self, time_s, pressure_kpa):
        self.pressure_kpa(time_s)
        self._target_kpa = np.array(pressure_kpa, float)
        self.commands.append(self._target_kpa)

    def pressure_kpa(self, time_s):
        keep = np.exp(-max(0.0, time_s - self._time_s) / 0.03)  # a camera may ask a moment late
        self._time_s = max(time_s, self._time_s)
        self._pressure_kpa = self._target_kpa + (self._pressure_kpa - self._target_kpa) * keep
        if self.stuck_kpa is not None:
            self._pressure_kpa = np.full(len(self.channels), self.stuck_kpa)
        return self._pressure_kpa.copy()

    def observe(self, time_s):
        position_mm = self.rest_mm + np.array([0.0, 0.0, self.pressure_kpa(time_s).mean()])
        status = np.zeros(len(self.marker_names), np.int8)
        for index in self.occluded:
            position_mm[index] = np.nan
            status[index] = 1
        return position_mm, status

    def surface(self, time_s):
        side = np.linspace(0.0, 200.0, 12)
        x, y = np.meshgrid(side, side)
        z = self.pressure_kpa(time_s).mean() * np.sin(np.pi * x / 200) * np.sin(np.pi * y / 200)
        vertices = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
        corner = (np.arange(11)[:, None] * 12 + np.arange(11)).ravel()
        lower = np.stack([corner, corner + 1, corner + 12], axis=1)
        upper = np.stack([corner + 1, corner + 13, corner + 12], axis=1)
        return vertices, np.concatenate([lower, upper])


class Closing:
    """Ends what was started in a test, the last first."""

    def __init__(self):
        self._ends = []

    def __call__(self, thing):
        self._ends.append(thing.close if hasattr(thing, "close") else thing.stop)
        return thing

    def all(self):
        for end in reversed(self._ends):
            end()


class Script:
    """A TCP server that runs `talk(connection)` for each client, one at a time, and then hangs up."""

    def __init__(self, talk, port=0):
        self._talk = talk
        self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.settimeout(0.05)
        self.port = self._listener.getsockname()[1]
        self.accepted = 0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        while not self._stopping.is_set():
            try:
                connection, _ = self._listener.accept()
            except TimeoutError:
                continue
            self.accepted += 1
            with connection:
                connection.settimeout(5)
                try:
                    self._talk(connection)
                except OSError:
                    continue

    def stop(self):
        self._stopping.set()
        self._thread.join()
        self._listener.close()


@pytest.fixture
def plant():
    return SmallPlant()


@pytest.fixture
def shared(plant):
    return SharedPlant(plant, RealClock())


@pytest.fixture
def small_plant_class():
    return SmallPlant


@pytest.fixture
def closing():
    """Wraps a started device, twin or server so that it ends with the test."""
    closing = Closing()
    yield closing
    closing.all()


@pytest.fixture
def script(closing):
    """Starts a scripted server: `script(talk)`."""
    return lambda talk, port=0: closing(Script(talk, port))


@pytest.fixture
def until():
    """Waits until `condition()` holds, at most ten seconds, and returns what it gave."""

    return partial(wait_for, seconds=10.0)


@pytest.fixture(autouse=True)
def _no_thread_is_left():
    before = set(threading.enumerate())
    yield
    end = time.monotonic() + 5
    while (left := set(threading.enumerate()) - before) and time.monotonic() < end:
        time.sleep(0.01)
    assert not left
