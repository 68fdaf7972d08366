"""What goes by the set-point alone is no effect that remembers, and a sensor's own curve is the base's."""

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepared, rows_from
from labrig.diagnosis._answers import Answer, Size, answers_of
from labrig.diagnosis._constants import INEXACT
from labrig.diagnosis._diagnose import BY_SET_POINT, laid_out
from labrig.diagnosis._explanation import CURVE, OF_BASE, STATIC
from labrig.diagnosis._parts import PartSize
from labrig.diagnosis._posterior import Search
from labrig.diagnosis._verdict import decide, detectable_floors
from tests.laws import limited, power_law
from tests.naming import verdict_of
from tests.sensors import model_of_both, two_sensors

REMEMBERS = {"creep", "leak", "delay", "hysteresis", "friction", "drift", "marker_slip"}


def bowed(lab, force: np.ndarray, bow: float) -> np.ndarray:
    """What a sensor reads whose characteristic is a parabola beside a straight line through its ends."""
    return force + 4 * bow * (force - force.min()) * (force.max() - force) / np.ptp(force) ** 2


def test_a_bowed_sensor_is_no_effect(make_lab) -> None:
    """One of two sensors that is not linear is the base's own form: no creep and no coupling is sure."""
    lab = make_lab(chambers=2, force=True, captures=60, rows_s=(3.0, 4.0))
    force = lab.predict(lab.u)
    data = two_sensors(lab, force + lab.noise(), bowed(lab, force, 0.6) + lab.noise())
    found = verdict_of(data, model_of_both(lab))
    assert found.effects == ()
    assert found.carried_by == "how the base itself moves"


def test_creep_is_named_beside_a_bowed_sensor(make_lab) -> None:
    """What a sensor's curve lacks hides nothing that goes on in the holds."""
    lab = make_lab(chambers=2, force=True, captures=60, rows_s=(1.0, 3.0, 8.0))
    force = lab.predict(power_law(lab))
    data = two_sensors(lab, force + lab.noise(), bowed(lab, force, 0.6) + lab.noise())
    assert verdict_of(data, model_of_both(lab)).effects == ("creep",)


def test_curves_of_the_set_points_are_smooth_and_few(make_lab) -> None:
    """They hold any parabola of the pressures, and nothing that changes along a hold."""
    lab = make_lab(chambers=2, captures=40, rows_s=(1.0, 3.0, 8.0))
    model = lab.model()
    rows = rows_from(lab.dataset(lab.predict(lab.u) + lab.noise()))
    _, seen, _ = laid_out(prepared(rows, model), {})
    curves, x = seen.curves, seen.context.rows.fraction
    weight = np.sqrt(seen.counts_for)
    parabola = weight * (seen.whiten @ (x[:, 0] * x[:, 1] - 0.3 * x[:, 0]))
    in_hold = weight * (seen.whiten @ np.log(seen.context.elapsed_s))
    assert curves.T @ curves == pytest.approx(np.eye(curves.shape[1]), abs=1e-9)
    assert curves.shape[1] <= seen.n_captures / 3
    assert curves @ (curves.T @ parabola) == pytest.approx(parabola, abs=1e-9)
    n = seen.n_captures
    assert (curves @ (curves.T @ in_hold))[n:] == pytest.approx(np.zeros(len(weight) - n), abs=1e-9)


def test_what_remembers_counts_by_what_no_curve_makes(make_lab) -> None:
    """A part that a curve of the set-points makes nearly all of may be that curve; the same part of another effect is
    that effect.
    """
    lab = make_lab(chambers=2, markers=6, captures=50, rows_s=(3.0, 4.0))
    model = lab.model()
    _, _, design = laid_out(
        prepared(rows_from(lab.dataset(lab.predict(limited(lab)) + lab.noise())), model),
        {"stiffening": model.library()["stiffening"]},
    )
    search = Search(design).run()
    plain, of_memory = (answers_of(search, 0.0, names) for names in ((), ("stiffening",)))
    assert plain[0].names == ("stiffening",)
    assert plain[0].worth("stiffening") > 0.9
    assert of_memory[0].worth("stiffening") == plain[0].worth("stiffening") / 2
    assert of_memory[0].unnamed[CURVE] == pytest.approx(plain[0].counts("stiffening"))
    words = {CURVE: BY_SET_POINT, **{o: o for a in of_memory for o in a.unnamed}}
    found = decide(of_memory, ("stiffening",), words | {CURVE: BY_SET_POINT})
    assert (found.effects, found.considered[0].call) == ((), "possible")
    assert found.carried_by == BY_SET_POINT


@pytest.mark.parametrize("bent", [0.4, 100.0])
def test_what_shows_is_found_and_more_than_laws_are_off(make_lab, monkeypatch, bent: float) -> None:
    """In few numbers it has to be found; of errors of many floors a twentieth is what any law is off its family."""
    lab = make_lab(chambers=1, force=True, captures=50, rows_s=(3.0,), bent=0.0)
    model = lab.model()
    x = lab.u / lab.u.max()
    data = lab.dataset(lab.predict(lab.u) + lab.noise() + bent * x * x)
    _, seen, design = laid_out(prepared(rows_from(data), model), {"creep": model.library()["creep"]})
    search = Search(design).run()
    needed = np.hypot(detectable_floors(seen), INEXACT * search.to_explain)
    assert (detectable_floors(seen) < INEXACT * search.to_explain) == (bent > 1)
    for beyond, shared in ((0.95 * needed, {"creep"}), (1.05 * needed, set())):
        found = {"creep": PartSize(50.0, 0.1, beyond), "?rest": PartSize(0.0)}
        monkeypatch.setattr("labrig.diagnosis._answers.sizes", lambda search, e, found=found: found)
        monkeypatch.setattr(
            "labrig.diagnosis._answers.missed", lambda search, e, least: [(1.0, {"creep": 50.0})]
        )
        assert answers_of(search, 0.0, ("creep",))[0].shared == shared


def test_a_curve_outvotes_nothing_that_remembers() -> None:
    """Beside a larger curve of the set-points without a name, creep keeps its name, and stiffening loses it."""
    sizes = {"creep": Size(2.0, 0.1, 2.0), "stiffening": Size(2.0, 0.1, 2.0)}
    answer = Answer(1.0, sizes, {STATIC: 5.0}, 0.5, frozenset({"creep"}))
    assert answer.names == ("creep",)
    assert answer.worth("creep") > 0.99
    assert answer.worth("stiffening") < 0.01
    assert Answer(1.0, sizes, {CURVE: 5.0}, 0.5).names == ("creep", "stiffening")
    assert CURVE in OF_BASE


def test_which_effects_remember(make_lab) -> None:
    """Those that are defined by time, or by what was before; a curve of the pressures may be all of any other."""
    library = make_lab().model().library()
    assert {name for name, effect in library.items() if effect.remembers} == REMEMBERS


def test_rows_that_are_left_out_are_looked_at(make_lab, few_effects) -> None:
    """A lag that is over within the first second is said where nothing is missing, since nothing else tells of it;
    where an effect is named, that valves take time is no news.
    """
    few_effects("stiffening", "delay", "creep", "leak")
    lab = make_lab(chambers=2, markers=6, captures=40, rows_s=(0.1, 0.4, 0.7, 3.0, 6.0))
    filled = (1 - np.exp(-lab.hold_s / 0.2))[:, :, None]
    for u, verdict, expected in (
        (lab.u * filled, "nothing_missing", 1),
        (lab.u, "nothing_missing", 0),
        (limited(lab) * filled, "identified", 0),
    ):
        summary = diagnose(lab.dataset(lab.predict(u) + lab.noise()), lab.model()).summary
        lines = [line for line in summary["warnings"] if "a lag so short is not looked at" in line]
        assert (summary["verdict"], len(lines)) == (verdict, expected)


def on_levels(make_lab):
    """A force of two chambers whose set-points are on five levels each, in random order."""
    lab = make_lab(force=True, chambers=2, captures=60, rows_s=(1.0, 3.0, 8.0), repeats=False)
    lab.commanded[:] = np.random.default_rng(0).choice([0.0, 12.5, 25.0, 37.5, 50.0], lab.commanded.shape)
    return lab


def test_curves_of_levels_are_any_function_of_each_chambers(make_lab) -> None:
    """On a programme of levels whatever a chamber does from one to the next is a curve of the set-points."""
    lab = on_levels(make_lab)
    _, seen, _ = laid_out(prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model()), {})
    x, weight = seen.context.rows.fraction, np.sqrt(seen.counts_for)
    waves = weight * (seen.whiten @ np.sin(2 * np.pi * 1.6 * x).sum(axis=1))
    assert seen.curves @ (seen.curves.T @ waves) == pytest.approx(waves, abs=1e-9)
    assert seen.curves.shape[1] <= seen.n_captures / 3


def test_a_loop_on_a_programme_of_levels_keeps_its_name(make_lab) -> None:
    """Captures of the same levels differ by what came before them."""
    lab = on_levels(make_lab)
    data = lab.dataset(lab.predict(lab.looped(1.5)) + lab.noise())
    assert {"hysteresis", "friction"} & set(verdict_of(data, lab.model()).effects)
