"""Names with spaces and umlauts, and names that change: what the page says and what it offers for copying."""

import json
import time
from typing import Any

import pytest

from labrig.workbench._events import encoded
from labrig.workbench._jobs import Jobs
from tests.waiting import wait_for

pytestmark = pytest.mark.usefixtures("browser")
RUN = "Finger 12 M\u00fcller"


def test_moments_keep_their_digits() -> None:
    """A moment of today reaches the page to the millisecond: times that have passed are counted from it."""
    now_s = time.time()
    said = json.loads(encoded("clock", now_s).partition("data: ")[2])
    assert said == pytest.approx(now_s, abs=1e-3)


def test_commands_are_quoted_for_the_shell(open_page: Any, make_run: Any) -> None:
    """A run with spaces in its name is one word of the command that is offered for copying."""
    make_run(RUN, captures=10)
    page = open_page()
    page.evaluate("run => location.hash = `#/run/${encodeURIComponent(run)}/compare`", RUN)
    page.wait_for_selector("[data-drawn]")
    page.wait_for_function(  # while it is computed, its job has a command, too
        "text => document.querySelector('.command code')?.innerText === text",
        arg=f'labrig compare "{RUN}" --model model.yaml',
    )


def test_the_import_line_follows_the_name(open_page: Any, table: Any, tmp_path: Any) -> None:
    """Another name for the run is in the command at once."""
    page = open_page()
    page.set_input_files("input[type=file]", table(tmp_path / "x.csv", 0, captures=4))
    page.fill("[aria-label='name of the run']", "another name")
    assert page.inner_text(".import .command code").endswith('-o "another name"')
    assert page.get_attribute(".import .copy", "aria-label").endswith('-o "another name"')


def test_a_model_of_a_plain_name_is_saved(ask: Any, bench: Any, make_run: Any) -> None:
    """A folder in a new model's name is refused, for the model would not be in the run's list."""
    run = make_run(captures=4)
    body = {"run": run, "model": "model.yaml", "effects": "creep"}
    for name in ("c/d.yaml", "c\\d.yaml"):
        status, said = ask("/api/add/save", {**body, "name": name})
        assert status == 400
        assert "plain name" in said["error"]
    assert not (bench.desk.folder / "c").exists()


def test_the_same_work_is_joined(tmp_path: Any) -> None:
    """Who asks for a comparison that goes on already is given that one, and no error."""
    jobs = Jobs(tmp_path, tmp_path / "jobs")
    words = ["workbench", ".", "--no-browser"]
    first = jobs.join(words, "long")
    try:
        assert jobs.join(words, "long").id == first.id
    finally:
        wait_for(lambda: "http://" in first.output())
        jobs.cancel(first, harder=True)
        assert jobs.wait(20)


def test_good_news_is_no_failure(tmp_path: Any) -> None:
    """A search that finds nothing to settle is done, for a person, though its command had nothing to do; one that
    somebody ended is cancelled.
    """
    jobs = Jobs(tmp_path, tmp_path / "jobs")
    said = {
        4: "labrig: it leaves nothing to settle",
        2: "labrig: nothing to settle there is no such run",
        130: "ended",
    }
    for code, state in ((4, "done"), (2, "failed"), (130, "cancelled")):
        folder = tmp_path / "jobs" / f"20260101-000000-{code:09d}-aaaa"
        folder.mkdir(parents=True)
        about = {"words": ["next"], "title": "what to measure next", "run": "run", "started_s": 1.0}
        (folder / "job.json").write_text(json.dumps(about), encoding="utf-8")
        (folder / "output.txt").write_text(said[code], encoding="utf-8")
        (folder / "ended.json").write_text(json.dumps({"code": code, "ended_s": 2.0}), encoding="utf-8")
        (job,) = (job for job in jobs.all() if job.id == folder.name)
        assert job.facts()["state"] == state
        assert job.facts()["last"] == said[code]
        assert job.had_nothing_to_do == (code == 4)


def test_a_name_that_commands_take_for_an_option(bench: Any, ask: Any, make_run: Any) -> None:
    """No run of such a name is made, and of one that is there it is said what to do, before a command fails on it."""
    make_run("-x")
    status, said = ask("/api/run?run=-x")
    assert (status, "give it another name" in said["error"]) == (400, True)
    status, said = ask(
        "/api/import", {"table": ".workbench/dropped/a/b.csv", "name": "--help", "mapping": ""}
    )
    assert (status, "give it another name" in said["error"]) == (400, True)
