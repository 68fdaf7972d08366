"""A workbench in this process, asked by HTTP and by a browser, on measurements of a rig that creeps."""

import http.client
import json
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from labrig.workbench import Desk, Running, open_desk, start

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

MARKERS = 4
MAPPING = """\
time: {column: t, unit: s}
capture: {column: capture}
actuation:
  - {column: p1, name: c1, unit: kPa, min: 0, max: 60}
  - {column: p2, name: c2, unit: kPa, min: 0, max: 60}
observables:
"""


def write_table(path: Path, seed: int, captures: int = 30, rows: int = 4) -> Path:
    """Holds of two chambers of a rig that creeps by a fifth of its motion; set-points come again with their history."""
    random = np.random.default_rng(seed)
    header = ["t", "capture", "p1", "p2", *(f"m{m}{a}" for m in range(MARKERS) for a in "xyz")]
    lines, t, remembered = [",".join(header)], 0.0, np.zeros(2)
    for capture in range(captures):
        u = random.uniform(0, 60, 2).round(1)
        if capture % 8 in (2, 3):
            u = np.array([[45.0, 15.0], [20.0, 50.0]][capture % 8 - 2])
        for _ in range(rows):
            t += 2.0
            remembered += (u - remembered) * (1 - math.exp(-2.0 / 5.0))
            at = _places() + random.normal(0, 0.05, (MARKERS, 3))
            at[:, 2] += _reach() @ (0.25 * u + 0.06 * remembered)
            cells = [f"{t:.1f}", str(capture), *map(str, u), *(f"{x:.3f}" for x in at.ravel())]
            lines.append(",".join(cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _places() -> np.ndarray:
    m = np.arange(MARKERS)
    return np.stack([30.0 * m, 20.0 * (m % 2), 0.0 * m], axis=1)


def _reach() -> np.ndarray:
    m = np.arange(MARKERS)[:, None]
    return np.exp(-(((m - np.array([0.5, 2.5])) / 1.2) ** 2))


def mapping() -> str:
    """What the columns of `write_table` mean."""
    columns = [
        f"  - {{column: m{m}{a}, name: m{m}.{a}, unit: mm, marker: m{m}, axis: {a}}}"
        for m in range(MARKERS)
        for a in "xyz"
    ]
    rests = ", ".join(f"m{m}: {{rest: {[float(x) for x in at]}}}" for m, at in enumerate(_places()))
    return MAPPING + "\n".join(columns) + f"\nmarkers: {{{rests}}}\n"


class Asker:
    """Asks a workbench as a page would, or with other headers."""

    def __init__(self, running: Running) -> None:
        self.running = running

    def __call__(
        self, path: str, body: Any = None, *, token: str | None = "right", **headers: str
    ) -> tuple[int, Any]:
        """Status and content; a POST where there is a body."""
        connection = http.client.HTTPConnection("127.0.0.1", self.running.port, timeout=180)
        given = {name.replace("_", "-"): value for name, value in headers.items()}
        if token is not None:
            given["x-labrig-token"] = self.running.desk.token if token == "right" else token
        data = None
        if isinstance(body, bytes):
            data = body
        elif body is not None:
            data, given["content-type"] = json.dumps(body).encode(), "application/json"
        try:
            connection.request("GET" if data is None else "POST", path, data, given)
            answer = connection.getresponse()
            text = answer.read().decode("utf-8", "replace")
            self.headers = dict(answer.getheaders())
        finally:
            connection.close()
        try:
            return answer.status, json.loads(text)
        except ValueError:
            return answer.status, text


@contextmanager
def served(folder: Path, rig_file: Path | None = None) -> Iterator[Running]:
    """A workbench of a folder, perhaps for a rig; when it ends, its jobs have too."""
    desk: Desk = open_desk(folder, rig_file)
    running = start(desk, port=0)
    try:
        yield running
    finally:
        for job in desk.jobs.all():
            desk.jobs.cancel(job, harder=True)
        desk.jobs.wait(10)
        running.stop()


@pytest.fixture(scope="module")
def shared_bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """A workbench that all tests of a file share, each with runs of its own or only looking at them."""
    folder = tmp_path_factory.mktemp("shared") / "lab"
    folder.mkdir()
    with served(folder) as running:
        yield running


@pytest.fixture
def table() -> Callable[..., Path]:
    """`write_table`."""
    return write_table


@pytest.fixture
def table_mapping() -> str:
    """`mapping`."""
    return mapping()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Running]:
    """A workbench of an empty folder."""
    folder = tmp_path / "lab"
    folder.mkdir()
    with served(folder) as running:
        yield running


@pytest.fixture
def ask(bench: Running) -> Asker:
    """Asks it."""
    return Asker(bench)


@pytest.fixture
def make_run(bench: Running) -> Callable[..., str]:
    """Makes a run of a table, with a model beside it that does not know creep; gives its name."""
    from labrig.log import import_table

    def make(name: str = "run", seed: int = 0, **settings: int) -> str:
        folder = bench.desk.folder
        source = write_table(folder.parent / f"{name}.csv", seed, **settings)
        (folder.parent / "map.yaml").write_text(mapping(), encoding="utf-8")
        import_table(folder.parent / "map.yaml", folder / name, [source])
        if not (folder / "model.yaml").exists():  # what was made with it stays as good as new
            (folder / "model.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
        return name

    return make


@pytest.fixture
def open_page(browser: "Browser", bench: Running) -> "Iterator[Callable[[], Page]]":
    """Opens pages of the workbench; a test in which one complains in its console has failed."""
    contexts, complaints = [], []

    def opening() -> "Page":
        context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
        context.set_default_timeout(180_000)  # a diagnosis on a slow computer that does four things at once
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.goto(bench.address)
        return page

    yield opening
    for context in contexts:
        context.close()
    assert complaints == []
