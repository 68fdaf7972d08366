"""The workbench in a real browser, with one server for all: jobs, addresses, keys, and what a page shows of them."""

import json
from contextlib import contextmanager

import psutil
import pytest

from tests.browsers import box_of
from tests.waiting import wait_for
from tests.workbench.test_page import _at, _error

pytestmark = pytest.mark.usefixtures("browser")


SHOWN, DIAGNOSED = "shown", "diagnosed"
"""Runs that several tests look at: one without a diagnosis, one that gets one."""


@pytest.fixture(scope="module")
def bench(shared_bench):
    """The one that the tests of this file share."""
    return shared_bench


@pytest.fixture
def compared(open_page, make_run, bench, request):
    """Opens a page that has compared a run: one of the test's own, or one that is there for all."""

    def opened(run=None):
        run = run or request.node.originalname
        if not (bench.desk.folder / run).exists():
            make_run(run)
        page = open_page()
        page.evaluate("run => location.hash = `#/run/${run}/compare`", run)
        _error(page)
        return run, page

    return opened


CANCEL = """async () => {
    const { cancelButton } = await import("/page/jobs.js");
    const sent = [];
    window.fetch = async (_, { body }) => (body && sent.push(JSON.parse(body)), new Response("{}"));
    const button = cancelButton({ id: "x" });
    for (let k = 0; k < 3; k++) {
        button.click();
        await new Promise((resolve) => setTimeout(resolve, 60));
    }
    return sent;
}"""


def test_a_double_click_on_cancel_is_one(open_page):
    """Its second half does not make the work end the hard way."""
    assert open_page().evaluate(CANCEL) == [{"harder": False}]


@contextmanager
def _standing_still(bench):
    """The job that runs stands still meanwhile, so that it is not done before the page is; signals wait for it."""
    (job,) = wait_for(lambda: [job for job in bench.desk.jobs.all() if job.state == "running"])
    pid = wait_for(lambda: (job.folder / "pid").is_file() and (job.folder / "pid").read_text())
    processes = _stopped(psutil.Process(int(pid)))
    try:
        yield job
    finally:
        for process in processes:
            process.resume()


def _stopped(process):
    """A process and all that it has started, suspended: what stands still starts no more."""
    process.suspend()
    wait_for(lambda: process.status() in (psutil.STATUS_STOPPED, psutil.STATUS_ZOMBIE))
    return [process, *(each for child in process.children() for each in _stopped(child))]


def test_a_job_is_cancelled_from_the_page(compared, bench):
    """Cancel ends the work, however slowly it is pressed, and the page says so and offers it again."""
    run, page = compared()
    page.evaluate("run => location.hash = `#/run/${run}/which`", run)
    page.click("[data-start=diagnose]")
    with _standing_still(bench) as job:
        page.hover(".empty [data-cancel]")
        page.mouse.down()
        with (job.folder / "output.txt").open("a") as output:
            output.write("one more line\n")
        page.wait_for_selector(".empty .progress >> text=one more line")
        page.mouse.up()
        page.wait_for_selector("text=stop it now")
    page.wait_for_selector("text=The last one was cancelled")
    page.wait_for_selector("[data-start=diagnose]")
    assert bench.desk.jobs.all()[0].state == "cancelled"
    assert not (bench.desk.folder / run / "model" / "diagnosis.json").exists()


def test_two_pages_agree_and_reloading_loses_nothing(compared, open_page, bench):
    """Work begun on one page is seen on another and can be cancelled there; a page that is loaded again meanwhile
    shows it still running; and what it found appears on both.
    """
    run, first = compared()
    pages = [first, open_page()]
    for page in pages:
        page.evaluate("run => location.hash = `#/run/${run}/which`", run)
        page.wait_for_selector("[data-start=diagnose]")
    first.click("[data-start=diagnose]")
    held = []
    with _standing_still(bench):
        pages[1].wait_for_selector("#jobs.busy")
        pages[1].wait_for_selector("main [data-cancel]")
        first.wait_for_selector(".empty progress")
        first.route("**/api/events", lambda route: held.append(route))  # the server says late which jobs run
        with first.expect_response("**/api/which*"):
            first.reload()
        first.wait_for_timeout(500)
        assert first.locator("[data-start=diagnose]").count() == 0  # it runs already
        held[0].continue_()
        first.wait_for_selector(".empty progress")
    first.unroute("**/api/events")
    for page in pages:
        page.wait_for_selector(".effect.sure")
    assert pages[0].inner_text("h1") == pages[1].inner_text("h1")


def test_every_state_has_an_address_and_back_works(compared):
    """A link leads to a run, a marker and an effect, and the browser's way back passes the same states."""
    _, page = compared(SHOWN)
    page.click("text=Where does it fail?")
    page.click('.bars [data-bar^="marker|"]')
    _at(page, "kind=marker")
    marker = page.url
    page.wait_for_selector("h2:has-text('Marker m')")
    page.go_back()
    page.wait_for_selector("h2:has-text('The whole run')")
    page.goto("about:blank")
    page.goto(marker)
    page.wait_for_selector("h2:has-text('Marker m')")


def test_a_band_that_is_clicked_is_marked(compared):
    """A bar of the times in the session is marked in their panel, beside the band of the noise."""
    _, page = compared(SHOWN)
    page.click("text=Where does it fail?")
    page.click(".tabs >> text=time in session")
    page.click('.bars [data-bar^="time in session|"]')
    page.wait_for_selector("figure.marked .js-plotly-plot")
    marks = "document.querySelector('figure.marked .js-plotly-plot').layout.shapes.map(s => s.xref || 'x')"
    wait_for(lambda: sorted(page.evaluate(marks)) == ["paper", "x"], "the band is not marked")


def test_the_keyboard_is_enough(compared):
    """Steps are opened with Alt and their number, and captures stepped through with the arrows."""
    run, page = compared(SHOWN)
    page.keyboard.press("ArrowRight")
    _at(page, "capture=")
    first = page.inner_text("h2.which")
    page.keyboard.press("ArrowRight")
    wait_for(lambda: page.inner_text("h2.which") != first, "the same capture is shown")
    page.keyboard.press("Alt+3")
    _at(page, "/where")
    page.keyboard.press("Alt+1")
    page.wait_for_selector(f"[data-run='{run}']")


def test_the_scale_of_colours_is_dragged(compared):
    """The scale stays as it is from capture to capture, and is dragged by its ends."""
    _, page = compared(SHOWN)
    ends = page.inner_text(".scale .ends")
    page.click(".captures li:nth-child(2) button")
    assert page.inner_text(".scale .ends") == ends
    box = box_of(page.locator(".handle").nth(1))
    page.mouse.move(box["x"] + 7, box["y"] + 10)
    page.mouse.down()
    page.mouse.move(box["x"] - 40, box["y"] + 10)
    page.mouse.up()
    _at(page, "scale=")
    wait_for(lambda: page.inner_text(".scale .ends") != ends, "the scale stays as it was")


def test_a_name_that_is_seldom_right_says_what_would_confirm_it(compared, ask, bench):
    """Of a sure effect whose name was wrong before the page says how often, and the experiment; of others neither."""
    run, page = compared(DIAGNOSED)
    ask("/api/which", {"run": run, "model": "model.yaml"})
    page.evaluate("run => location.hash = `#/run/${run}/which`", run)
    page.wait_for_selector("h3:has-text('What betrays it')")
    file = bench.desk.folder / run / "model" / "diagnosis.json"
    text = file.read_text(encoding="utf-8")

    def reload(there: int) -> None:
        """As if the name had been right so many times of 15."""
        found = json.loads(text)
        for each in found["effects_considered"]:
            if each["call"] == "sure":
                each["track_record"] = {"there": there, "of": 15}
        file.write_text(json.dumps(found), encoding="utf-8")
        page.reload()

    try:
        reload(14)
        page.wait_for_selector("h3:has-text('What betrays it')")
        assert page.locator("text=What would confirm it").count() == 0
        reload(3)
        page.wait_for_selector("text=What would confirm it: the name was right 3 times of 15")
    finally:  # others look at this run, too
        file.write_text(text, encoding="utf-8")


@pytest.mark.slow
def test_an_effect_that_does_not_help_says_so(compared, ask):
    """An effect that is switched on and lowers nothing is marked, and is saved only all the same."""
    run, page = compared(DIAGNOSED)
    ask("/api/which", {"run": run, "model": "model.yaml"})
    page.evaluate("run => location.hash = `#/run/${run}/which`", run)
    page.wait_for_selector(".effect.sure")
    page.click("text=Add it and watch the error fall")
    page.wait_for_selector("[data-refined=true]")
    page.check("[data-effect=delay]")
    page.wait_for_selector("[data-note=delay].useless")
    page.wait_for_selector("text=delay does not help beside the others")
    assert page.inner_text("[data-save]") == "Save all the same"
