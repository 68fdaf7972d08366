"""A rig set up in a real browser: typed, judged beside its field, saved; nothing typed is lost on the way."""

from typing import Any

import pytest
import yaml

from labrig.rig import load_rig
from tests.browsers import box_of
from tests.waiting import wait_for
from tests.workbench.test_page import _at

pytestmark = pytest.mark.usefixtures("browser")
OLD = {
    "name": "old",
    "chambers": [{"name": "left", "max_kpa": 40}, {"name": "right", "max_kpa": 45, "min_kpa": -20}],
    "pressure": {"kind": "modbus", "host": "10.0.0.2", "map": "festo-vtem.yaml", "outputs": [3, 1]},
    "mocap": {"kind": "vicon", "up": "y"},
    "markers": ["m1", "m2"],
    "safety": {"vents_alone": "a relay"},
}


@pytest.fixture
def watch(open_page):
    """A page on Watch, without a rig."""
    page = open_page()
    page.evaluate("location.hash = '#/watch'")
    page.wait_for_selector("#setup-text:not(:empty)")
    return page


def _saved(page: Any, name: str = "rig.yaml") -> None:
    page.fill("#setup-file", name)
    page.click("#setup-save:not([disabled])")
    page.wait_for_selector("#setup-saved")


def _files(bench: Any) -> list[str]:
    return sorted(path.name for path in bench.desk.folder.iterdir() if path.is_file())


def test_a_rig_is_set_up_by_clicks(watch, bench):
    """A form that is filled writes a file of which `load_rig` reads the same values; two commands lead on."""
    watch.fill("#setup-name", "bench")
    watch.fill("#setup-pressure-port", "COM3")
    watch.select_option("#setup-pressure-build", "full")
    watch.fill("[aria-label='number of chambers alike']", "3")
    watch.fill("[name='chambers.0.max_kpa']", "45,5")
    watch.click("#setup-alike")
    watch.click("#setup-add")
    watch.fill("[name='chambers.3.name']", "belly")
    watch.fill("[name='chambers.3.output']", "7")
    watch.click("[aria-label='remove chamber 2']")
    watch.select_option("#setup-mocap", "vicon")
    watch.fill("#setup-mocap-subject", "mannequin")
    watch.fill("#setup-markers", "m1\nm2, 1, 2, 3")
    watch.select_option("#setup-scanner", "artec")
    watch.fill("#setup-scanner-folder", "scans")
    watch.fill("#setup-safety-vents_alone", "a relay")
    watch.wait_for_selector("#setup-text:has-text('vents_alone: a relay')")
    text = watch.inner_text("#setup-text")
    assert _files(bench) == []
    _saved(watch, "bench.yaml")
    assert (bench.desk.folder / "bench.yaml").read_text(encoding="utf-8").strip() == text.strip()
    config = load_rig(bench.desk.folder / "bench.yaml")
    assert [(c.name, c.min_kpa, c.max_kpa, c.slew_kpa_s) for c in config.chambers] == [
        ("c1", 0, 45.5, 100),
        ("c3", 0, 45.5, 100),
        ("belly", 0, 45.5, 100),
    ]
    assert config.pressure.options == {"port": "COM3", "build": "full", "outputs": [0, 1, 7]}
    assert config.mocap is not None
    assert config.mocap.options == {"subject": "mannequin"}
    assert (config.markers, config.rest_mm) == (("m1", "m2"), {"m2": (1, 2, 3)})
    assert config.scanner is not None
    assert config.scanner.options == {"folder": "scans", "unit": "mm"}
    assert config.safety.vents_alone == "a relay"
    said = watch.locator("#setup-saved .command code").all_inner_texts()
    assert said == ["labrig rig check bench.yaml --still", "labrig workbench . --rig bench.yaml"]
    watch.wait_for_selector("#no-rig [data-rig='bench.yaml']")
    assert "There is no rig file here yet" not in watch.inner_text("#no-rig")
    assert bench.desk.jobs.all() == []


def test_what_is_wrong_stands_beside_its_field(watch, bench):
    """As it is typed, also in settings that were closed; while it is there nothing can be saved."""
    watch.fill("#setup-name", "bench")
    beside = "[data-at='pressure.port'] .fault"
    watch.wait_for_selector(f"{beside}:has-text('is missing')")
    assert watch.inner_text("#setup-wrong") == "Port: is missing"
    watch.fill("#setup-pressure-port", "COM3")
    watch.fill("[name='chambers.1.max_kpa']", "high")
    watch.wait_for_selector(
        "[data-at='chambers.1'] .fault:has-text(\"most: should be a valid number, not 'high'\")"
    )
    assert watch.get_attribute("[name='chambers.1.max_kpa']", "aria-invalid") == "true"
    assert watch.inner_text(beside) == ""
    assert watch.is_disabled("#setup-save")
    watch.fill("[name='chambers.1.max_kpa']", "60")
    watch.wait_for_selector("#setup-save:not([disabled])")
    watch.click("[data-at=safety] summary")
    watch.evaluate(  # closed before the answer can be there
        """() => {
            const field = document.querySelector("#setup-safety-heartbeat_s");
            field.value = "-1";
            field.dispatchEvent(new Event("input", { bubbles: true }));
            field.closest("details").open = false;
        }"""
    )
    watch.wait_for_selector(
        "[data-at='safety.heartbeat_s'] .fault:has-text('greater than or equal to 0.2')", state="visible"
    )
    assert watch.is_disabled("#setup-save")
    assert _files(bench) == []


def test_a_file_that_is_there_is_not_written_over(browser, bench):
    """The page says so beside the name, also of one that appeared since it looked, and what was typed stays."""
    path = bench.desk.folder / "rig.yaml"
    page = browser.new_page()  # its console tells of the answer that refuses
    page.set_default_timeout(180_000)
    page.goto(bench.address)
    page.evaluate("location.hash = '#/watch'")
    page.fill("#setup-name", "bench")
    page.fill("#setup-pressure-port", "COM3")
    page.wait_for_selector("#setup-save:not([disabled])")
    path.write_text("mine")
    page.click("#setup-save")
    page.wait_for_selector("#setup-wrong-file:has-text('rig.yaml: exists already')")
    assert page.is_disabled("#setup-save")
    assert (path.read_text(), page.input_value("#setup-name")) == ("mine", "bench")
    page.close()


def test_kinds_of_devices_can_be_tried(watch):
    """What was typed for one is there again; a host or a serial port is asked for, and what is simulated."""
    watch.fill("#setup-pressure-port", "COM7")
    watch.select_option("#setup-pressure", "modbus")
    watch.fill("#setup-pressure-host", "10.0.0.2")
    assert watch.locator("#setup-pressure-parity").count() == 0
    watch.select_option("#setup-pressure-by", "serial")
    assert watch.locator("#setup-pressure-host").count() == 0
    assert watch.input_value("#setup-pressure-baudrate") == "19200"
    watch.select_option("#setup-pressure", "simulated")
    assert watch.locator("[name='chambers.0.output']").count() == 0
    watch.wait_for_selector("#setup-simulated-body")
    watch.wait_for_selector("#setup-text:has-text('surface: membrane')")
    watch.select_option("#setup-pressure", "openpneu")
    assert watch.input_value("#setup-pressure-port") == "COM7"
    watch.select_option("#setup-pressure", "modbus")
    assert watch.input_value("#setup-pressure-by") == "serial"
    watch.wait_for_selector("#setup-text:not(:has-text('surface'))")


def test_a_form_is_begun_from_a_file(open_page, bench):
    """It is filled from a file that it can hold, and saved as another; of one that it cannot hold it says why."""
    folder = bench.desk.folder
    (folder / "old.yaml").write_text("# by hand\n" + yaml.safe_dump(OLD), encoding="utf-8")
    own = {**OLD, "pressure": {"kind": "python", "file": "mine.py", "class": "Mine"}}
    (folder / "own.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")
    page = open_page()
    page.evaluate("location.hash = '#/watch'")
    page.wait_for_selector(
        "[data-rig='own.yaml'] >> text=the form has no field for pressure of kind 'python'"
    )
    assert page.locator("[data-begin='own.yaml']").count() == 0
    assert page.inner_text("[data-rig='old.yaml'] code") == "labrig workbench . --rig old.yaml"
    page.click("[data-begin='old.yaml']")
    page.wait_for_selector("#setup-remarks >> text=the comments in old.yaml stay there")
    assert page.input_value("[name='chambers.1.min_kpa']") == "-20"
    assert page.input_value("[name='chambers.0.output']") == "3"
    page.fill("#setup-name", "new")
    _saved(page)
    before, after = load_rig(folder / "old.yaml"), load_rig(folder / "rig.yaml")
    assert after.model_copy(update={"name": "old"}) == before


def test_what_was_typed_outlives_a_theme_a_reload_and_another_step(watch):
    """Until it is saved or put away."""
    watch.fill("#setup-name", "bench")
    watch.select_option("#setup-mocap", "vicon")
    for leave in ("theme", "reload", "step"):
        if leave == "theme":
            watch.click("#theme")
        elif leave == "reload":
            watch.reload()
        else:
            watch.evaluate("location.hash = '#/choose'")
            watch.wait_for_selector(".dropzone")
            watch.evaluate("location.hash = '#/watch'")
            _at(watch, "#/watch")
        wait_for(lambda: watch.locator("#setup-mocap-host").count() == 1, "the form is empty")
        assert watch.input_value("#setup-name") == "bench"
    watch.click("text=empty the form")
    watch.wait_for_selector("#setup-mocap-host", state="detached")
    assert watch.input_value("#setup-name") == ""


def test_the_form_fits_a_narrow_window(watch):
    """At 420 px no part of it is wider than the window."""
    watch.set_viewport_size({"width": 420, "height": 800})
    watch.fill("#setup-name", "a rig with a name that is rather long, as some have it")
    watch.wait_for_selector("#setup-text:has-text('a rig with a name')")
    assert watch.evaluate("document.documentElement.scrollWidth") <= 420
    box = box_of(watch.locator("#setup-save"))
    assert box["x"] + box["width"] <= 420
