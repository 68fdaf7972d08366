"""At one speed a lag in time and a loop look alike: a record that has no other speed is said to be so."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from labrig.diagnosis import diagnose
from labrig.diagnosis._one_speed import counted_time, one_side, one_speed, one_stroke, short_holds
from labrig.effects import Context, library, rows_of
from tests.laws import orifice

MOVES_ON = ("regulator", "tension", "stiffening", "contact", "coupling")
"""Effects that are curves of the pressures: they lag behind nothing, and asking for them takes the most of the time."""
ENDS_KPA = (0.0, 60.0, 10.0, 80.0, 20.0, 70.0, 0.0)


def ramps(speeds: tuple[float, ...], noise: float = 0.05) -> np.ndarray:
    """Pressures of ramps between the ends, kPa at 10 Hz, each at the next of these speeds, as a sensor reads them."""
    ways = pairwise(ENDS_KPA)
    parts = [
        np.linspace(a, b, int(abs(b - a) / speeds[i % len(speeds)] * 10), endpoint=False)
        for i, (a, b) in enumerate(ways)
    ]
    whole = np.concatenate(parts)
    return whole + noise * np.random.default_rng(0).normal(size=len(whole))


def context_of(folder: Path, pressure: np.ndarray, clock: dict[str, str] | None) -> Context:
    """A record of these pressures, with a clock or without."""
    folder.mkdir(exist_ok=True)
    rows = "".join(f"{i / 10},{p:.3f},{0.3 * p:.4f}\n" for i, p in enumerate(pressure))
    (folder / "t.csv").write_text(f"t,p,y\n{rows}")
    mapping = {
        "table": "t.csv",
        **({"time": clock} if clock else {}),
        "capture": {"per": "segment"},
        "actuation": [{"column": "p", "name": "c1", "unit": "kPa", "min": 0, "max": 90}],
        "observables": [{"column": "y", "name": "y", "unit": "mm"}],
    }
    (folder / "map.yaml").write_text(yaml.safe_dump(mapping))
    (folder / "model.yaml").write_text("base: {kind: static, degree: 1}\n")
    run = labrig.import_table(folder / "map.yaml", folder / "run")
    return labrig.Model.load(folder / "model.yaml").context(rows_of(run))


def said(folder: Path, pressure: np.ndarray) -> list[str]:
    """What is said of a record of these pressures."""
    return one_speed(context_of(folder, pressure, {"column": "t", "unit": "s"}))


def test_ramps_of_one_speed_are_said_to_be_so(tmp_path: Path) -> None:
    """The speed is named with its unit, a sensor's noise notwithstanding."""
    (line,) = said(tmp_path, ramps((4.0,)))
    assert line.startswith(
        "the input always moves at about 4 kPa/s: what lags in time (delay, creep) and what depends"
    )


@pytest.mark.parametrize("speeds", [(2.0, 8.0), (4.0, 6.0, 9.0)])
def test_several_speeds_need_no_word(tmp_path: Path, speeds: tuple[float, ...]) -> None:
    """Where ramps go at speeds that differ, time and way can be told apart."""
    assert said(tmp_path, ramps(speeds)) == []


@pytest.mark.parametrize("even", [True, False])
def test_even_steps_at_even_times_are_one_speed(make_lab, even: bool) -> None:
    """A staircase up and down is one, whatever another chamber is set to now and then; scattered set-points are not."""
    lab = make_lab(chambers=2, captures=60)
    if even:
        lab.commanded[:, 0] = np.abs(np.arange(60) % 20 - 10) * 6.0
        lab.commanded[:, 1] = np.repeat([10.0, 50.0, 30.0], 20)
    said = one_speed(lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise()))))
    assert len(said) == even
    assert not even or said[0].startswith("the set-points always go on by about 1 kPa/s: what lags in time")


def test_set_points_that_are_seen_at_one_moment(make_lab, few_effects) -> None:
    """A leak that is seen three seconds after each set-point only may have another name: that is said, and not where
    some are seen later, too, nor where nothing is missing."""
    few_effects("leak", "delay", "creep", "drift")
    for rows_s, law, expected in (
        ((3.0, 3.2), orifice, 1),
        ((1.0, 3.0, 8.0), orifice, 0),
        ((3.0, 3.2), None, 0),
    ):
        lab = make_lab(chambers=2, captures=40, rows_s=rows_s)
        values = lab.predict(law(lab) if law else lab.u) + lab.noise()
        said = diagnose(lab.dataset(values), lab.model()).summary["warnings"]
        lines = [
            line for line in said if line.startswith("every row was taken 3.1 s after its set-point: what a")
        ]
        assert len(lines) == expected


@pytest.mark.parametrize("speeds", [(4.0,), (2.0, 4.0, 8.0)])
def test_a_loop_is_told_from_a_lag_at_several_speeds_only(tmp_path: Path, speeds: tuple[float, ...]) -> None:
    """Dahl's friction in a record: where the input has one speed a lag in time does the same, and each is possible."""
    pressure = np.tile(ramps(speeds, noise=0.0), 2)
    held, loop = 0.0, np.zeros(len(pressure))
    for i, step in enumerate(np.diff(pressure), start=1):
        held = np.sign(step) + (held - np.sign(step)) * np.exp(-abs(step) / 6.0)
        loop[i] = held
    seen = 0.3 * pressure - 0.5 * loop + np.random.default_rng(1).normal(0, 0.1, len(pressure))
    table = {
        "t (s)": 0.1 * np.arange(len(pressure)),
        "p set (kPa)": pressure.round(3),
        "force (N)": seen.round(3),
    }
    run = labrig.import_table(pd.DataFrame(table), tmp_path / "run")
    found = diagnose(run, labrig.Model.of(lambda u: 0.3 * u), without=MOVES_ON).summary
    sure, possible = set(found["effects"]), set(found["effects"]) | set(found["rivals"])
    if len(speeds) > 1:
        assert possible & {"hysteresis", "friction"}
        assert not possible & {"delay", "creep"}
    else:
        assert not sure & {"hysteresis", "friction", "delay", "creep"}
        assert possible >= {"hysteresis", "friction", "delay", "creep"}


@pytest.mark.parametrize("vented", [True, False])
def test_set_points_that_are_approached_from_one_side(make_lab, vented: bool) -> None:
    """Where the chambers are vented before each set-point a loop and an offset are alike, and that is said."""
    lab = make_lab(chambers=2, captures=30)
    data = lab.dataset(lab.predict(lab.u) + lab.noise())
    if vented:  # an event at zero before that of each capture
        n, of = data.sizes["capture"], data["event_of"].values
        commanded = np.zeros((2 * n, 2))
        commanded[1::2] = data["event_commanded"].values[of]
        time_s = np.repeat(data["event_time_s"].values[of], 2) - np.tile([1.0, 0.0], n)
        data = data.drop_vars(["event_commanded", "event_time_s", "event_session"], errors="ignore").assign(
            event_commanded=(("event", "chamber"), commanded, {"units": "kPa"}),
            event_time_s=("event", time_s),
            event_of=("capture", 2 * np.arange(n) + 1),
        )
        data = data.assign_coords(event_session=("event", np.repeat(data["session"].values, 2)))
    lines = one_side(lab.model().context(rows_of(data)))
    assert bool(lines) == vented
    assert all("approach some from the other side" in line for line in lines)


def test_a_table_without_a_clock_has_no_seconds(tmp_path: Path) -> None:
    """Where rows were only counted, what goes by time is said to count rows, and a speed is by the row; what goes by no
    time needs no word, nor does a table that has a clock.
    """
    counted = context_of(tmp_path, ramps((4.0,), noise=0.0), None)
    (line,) = one_speed(counted)
    assert line.startswith("the input always moves at about 0.4 kPa a row: what lags in time")
    effects = library()
    (line,) = counted_time(counted, {name: effects[name] for name in ("hysteresis", "drift", "creep")})
    assert "times and rates of drift and creep count rows" in line
    assert counted_time(counted, {"hysteresis": effects["hysteresis"]}) == []
    timed = context_of(tmp_path / "other", ramps((4.0,)), {"column": "t", "unit": "s"})
    assert counted_time(timed, {"drift": effects["drift"]}) == []


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ((0, 80), True),
        ((0, 80, 0), True),
        ((0, 80, 0, 80), False),
        ((0, 80, 40, 60), False),
        ((79, 80), False),
    ],
    ids=["one way", "there and back", "and there again", "a loop within", "held, in its noise"],
)
def test_one_stroke_tells_no_time_from_the_way(tmp_path: Path, ends: tuple[float, ...], said: bool) -> None:
    """Where an input goes there, or there and back, once, that is said: a drift is as good a name as a loop there."""
    parts = [np.linspace(a, b, 60, endpoint=False) for a, b in pairwise(ends)]
    pressure = np.concatenate(parts) + 0.3 * np.random.default_rng(0).normal(size=60 * len(parts))
    context = context_of(tmp_path, pressure, {"column": "t", "unit": "s"})
    assert bool(one_stroke(context)) == said


def test_no_name_is_sure_in_one_stroke(tmp_path: Path) -> None:
    """A rubber strip that is stretched and let go once, slowly: its relaxation is as good as a drift, and a doubt."""
    stretch = 1 + 1.5 * (1 - np.abs(np.linspace(-1, 1, 81)))
    network, stress = 1.0, np.zeros(81)
    for i, now in enumerate(stretch):
        network += (
            now - network
        ) / 6.0  # a second network, whose rest length follows (Green and Tobolsky, 1946)
        own = now / network
        stress[i] = 30 * (now - now**-2.0) + 60 * (own - own**-2.0)
    stress += np.random.default_rng(4).normal(0, 0.3, 81)
    table = {"stretch set (1)": stretch.round(4), "stress (kPa)": stress.round(2)}
    run = labrig.import_table(pd.DataFrame(table), tmp_path / "run")
    path = tmp_path / "model.yaml"
    path.write_text("base: {kind: static, degree: 2}\n", encoding="utf-8")
    found = diagnose(run, labrig.Model.load(path)).summary
    assert not found["effects"]
    assert {"creep", "drift", "hysteresis"} <= set(found["rivals"])
    assert any(
        line.startswith("the input goes there and back once: what changes") for line in found["warnings"]
    )


@pytest.mark.parametrize(("rows_s", "said"), [((0.6, 1.0, 1.4), True), ((0.6, 2.0, 3.5), False)])
def test_holds_that_end_while_valves_fill_are_said_to_be_short(make_lab, rows_s: tuple, said: bool) -> None:
    """Where most holds end within two seconds, one line says so and what to do."""
    lab = make_lab(captures=12, rows_s=rows_s, repeats=False)
    lines = short_holds(lab.model().context(rows_of(lab.dataset(lab.predict(lab.u)))))
    assert lines == (
        [
            "12 of 12 holds end within 2 s of the command, while valves fill and the body swings: what is said here "
            "may be that; hold for 3 s or more"
        ]
        if said
        else []
    )
