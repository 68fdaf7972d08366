"""Rows: holds condensed, transients dropped, runs joined."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.effects import join_rows, rows_of
from labrig.effects._resolution import resolution_of
from labrig.model import Model
from tests.naming import verdict_of

MakeLab = Callable[..., object]


def test_every_row_of_a_short_hold_is_kept(make_lab) -> None:
    """Few rows that begin after the transient stay as they are, in order, with all that belongs to them."""
    lab = make_lab(captures=12, rows_s=(3.0, 4.0, 5.0))
    values = lab.predict(lab.u)
    rows = rows_of(lab.dataset(values, {"temperature": ("degC", np.linspace(20, 25, 12))}))
    assert rows.values == pytest.approx(values.reshape(36, -1))
    assert rows.capture.tolist() == np.repeat(np.arange(12), 3).tolist()
    assert rows.event.tolist() == rows.capture.tolist()
    assert rows.hold_s.tolist() == [3.0, 4.0, 5.0] * 12
    assert rows.time_s == pytest.approx(lab.time_s.ravel())
    assert rows.actuation == pytest.approx(np.repeat(lab.commanded, 3, axis=0))
    assert rows.fraction == pytest.approx(rows.actuation / 60.0)
    assert rows.covariates["temperature"].values == pytest.approx(np.repeat(np.linspace(20, 25, 12), 3))
    assert rows.covariates["temperature"].unit == "degC"
    assert rows.observables[:4] == ("m0.x", "m0.y", "m0.z", "m1.x")
    assert rows.marker.tolist() == np.repeat(np.arange(6), 3).tolist()
    assert rows.axis.tolist() == [0, 1, 2] * 6


def test_a_marker_of_which_a_coordinate_is_missing_has_no_place_at_rest(make_lab) -> None:
    """Its columns are there one by one; where it is at rest nobody knows, and effects that ask for that can act."""
    lab = make_lab(chambers=2, captures=20, markers=3)
    run = lab.dataset(lab.predict(lab.u) + lab.noise())
    whole, part = run.isel(marker=[0, 2]), run["position_mm"].isel(marker=1, axis=[0, 1])
    run = whole.assign(observed=(("capture", "time", "observable"), part.values)).assign_coords(
        observable=["m1.x", "m1.y"],
        unit=("observable", ["mm", "mm"]),
        marker_of=("observable", ["m1", "m1"]),
        axis_of=("observable", ["x", "y"]),
    )
    rows = rows_of(run)
    assert rows.markers == ("m0", "m2", "m1")
    assert rows.rest_mm is not None
    assert np.isfinite(rows.rest_mm).all(axis=1).tolist() == [True, True, False]
    order = [rows_of(lab.dataset(lab.predict(lab.u))).observables.index(name) for name in rows.observables]
    model = Model.of(lambda u: lab.predict(u[:, None])[:, 0][:, order])
    assert verdict_of(run, model).verdict == "nothing_missing"


def test_the_transient_is_dropped(make_lab) -> None:
    """Nothing of the first second is kept, or of the first third where the hold is shorter than three seconds."""
    lab = make_lab(captures=4, rows_s=tuple(np.arange(0.0, 6.0, 0.25)), repeats=False)
    assert rows_of(lab.dataset(lab.predict(lab.u))).hold_s.min() >= 1.0
    brief = make_lab(captures=4, rows_s=tuple(np.arange(0.0, 1.3, 0.1)), repeats=False)
    assert rows_of(brief.dataset(brief.predict(brief.u))).hold_s.min() == pytest.approx(0.4)


def test_a_long_hold_is_condensed_densely_at_its_beginning(make_lab) -> None:
    """Hundreds of frames become few bins, their middle unmoved by a spike, shorter early than late."""
    lab = make_lab(captures=20, rows_s=tuple(np.arange(1.0, 101.0, 0.25)), repeats=False)
    values = lab.predict(lab.u)
    values[:, 200] += 1000.0
    rows = rows_of(lab.dataset(values), row_budget=400)
    per_capture = np.bincount(rows.capture)
    assert (per_capture <= 20).all()
    assert (per_capture >= 10).all()
    at = rows.hold_s[rows.capture == 0]
    assert (np.diff(at) > 0).all()
    assert np.diff(at)[0] < 0.3 * np.diff(at)[-1]
    assert rows.values == pytest.approx(lab.predict(lab.commanded)[rows.capture], abs=1e-9)


def test_what_was_not_seen_stays_nan(make_lab) -> None:
    """A hidden marker is NaN in its rows, and a capture without anything seen has no rows at all."""
    lab = make_lab(captures=12)
    values = lab.predict(lab.u)
    values[3, :, 6:9] = np.nan
    values[7] = np.nan
    rows = rows_of(lab.dataset(values))
    hidden = rows.capture == 3
    assert np.isnan(rows.values[hidden][:, 6:9]).all()
    assert np.isfinite(rows.values[~hidden]).all()
    assert 7 not in rows.capture
    assert rows.n_captures == 12


def test_limits_that_are_unknown_are_those_of_the_commands(make_lab) -> None:
    """Without limits the range is from zero to the highest command; one that never moves still has a range."""
    lab = make_lab(captures=6, chambers=2, repeats=False)
    lab.commanded[:, 1] = 0.0
    data = lab.dataset(lab.predict(lab.u)).assign_coords(
        chamber_min=("chamber", [np.nan, np.nan]), chamber_max=("chamber", [np.nan, np.nan])
    )
    rows = rows_of(data)
    assert rows.low.tolist() == [0.0, 0.0]
    assert rows.high.tolist() == [lab.commanded[:, 0].max(), 1.0]


def test_single_observables_and_markers_stand_side_by_side(make_lab) -> None:
    """A force beside markers is an observable like any other, with its own unit and no marker."""
    lab = make_lab(captures=6, repeats=False)
    data = lab.dataset(lab.predict(lab.u))
    force = np.arange(18.0).reshape(6, 3, 1)
    data["observed"] = (("capture", "time", "observable"), force)
    data = data.assign_coords(
        observable=["grip"],
        unit=("observable", ["N"]),
        marker_of=("observable", [""]),
        axis_of=("observable", [""]),
    )
    rows = rows_of(data)
    assert rows.observables[-1] == "grip"
    assert rows.unit == ("mm",) * 18 + ("N",)
    assert (rows.marker[-1], rows.axis[-1]) == (-1, -1)
    assert rows.values[:, -1].tolist() == list(range(18))


def test_joined_runs_keep_their_own_sessions_and_history(make_lab) -> None:
    """Captures, events and sessions are counted on; equal names of sessions do not meet."""
    one, two = make_lab(captures=6, repeats=False), make_lab(captures=8, seed=1, sessions=2, repeats=False)
    a, b = (rows_of(lab.dataset(lab.predict(lab.u))) for lab in (one, two))
    rows = join_rows([a, b])
    assert rows.sessions == ("1:s0", "2:s0", "2:s1")
    assert rows.n_captures == 14
    assert rows.capture.tolist() == np.repeat(np.arange(14), 3).tolist()
    assert rows.event_actuation == pytest.approx(np.concatenate([one.commanded, two.commanded]))
    assert rows.event_session.tolist() == [0] * 6 + [1] * 4 + [2] * 4
    assert rows.event_actuation[rows.event] == pytest.approx(rows.actuation)
    assert join_rows([a]) is a


def test_what_is_left_out_of_joined_runs_is_of_all_of_them(make_lab) -> None:
    """How far rows of the first second lie from where they settle is the root mean square over the runs."""
    lab = make_lab(captures=6, rows_s=(0.2, 3.0, 4.0), repeats=False)
    far = np.array([1.0, 0.0, 0.0])[:, None]
    parts = [rows_of(lab.dataset(lab.predict(lab.u) + off * far)) for off in (0.0, 3.0, 4.0)]
    assert parts[1].early == pytest.approx(np.full(18, 3.0))
    assert join_rows(parts).early == pytest.approx(np.full(18, np.sqrt(25 / 3)))


def test_joined_runs_go_on_in_time_where_it_is_known(make_lab) -> None:
    """A run that began two hours later is two hours later. Where that is not known, or it began before the first ended,
    it is taken to follow the first, and remembers nothing of it.
    """
    lab = make_lab(captures=6, repeats=False)
    first, second = lab.dataset(lab.predict(lab.u)), lab.dataset(lab.predict(lab.u))
    alone = rows_of(first)
    assert np.isnan(alone.start_s)
    began = [rows_of(run.assign_attrs(start_s=s)) for run, s in ((first, 1000.0), (second, 8200.0))]
    rows = join_rows(began)
    assert rows.time_s[:18] == pytest.approx(alone.time_s)
    assert rows.time_s[18:] == pytest.approx(alone.time_s + 7200.0)
    assert rows.event_time_s[7:] == pytest.approx(alone.event_time_s + 7200.0)
    overlapping = [rows_of(first.assign_attrs(start_s=1000.0)), rows_of(second.assign_attrs(start_s=1001.0))]
    end = float(alone.time_s.max())
    for parts in (overlapping, [alone, alone]):
        follows = join_rows(parts)
        assert follows.time_s[18:] == pytest.approx(alone.time_s + end)
        assert follows.event_time_s[6:] == pytest.approx(alone.event_time_s + end)
        assert follows.goes_on == ()


def test_a_run_remembers_the_one_before(make_lab) -> None:
    """Of a rig that is vented in between, what the first run has left goes on in the second; else each begins anew."""
    lab = make_lab(captures=6, repeats=False)
    runs = [
        rows_of(lab.dataset(lab.predict(lab.u)).assign_attrs(between_sessions=between, start_s=start))
        for between in ("vented", "unknown")
        for start in (1000.0, 8200.0)
    ]
    rows = join_rows(runs[:2])
    assert rows.goes_on == (1,)
    assert rows.event_actuation[6].tolist() == [0.0] * lab.chambers
    assert rows.event_time_s[6] == pytest.approx(float(runs[0].time_s.max()))
    assert rows.event_actuation[rows.event] == pytest.approx(rows.actuation)
    assert rows.event_session.tolist() == [0] * 7 + [1] * 6
    context = lab.model().predictor(rows).context(rows)
    assert context.started[7] == 6
    creeping = lab.model().predictor(runs[1]).context(runs[1]).relaxed(4000.0)
    remembered = context.relaxed(4000.0)[18:]
    assert np.abs(remembered - creeping).max() > 0.1 * np.abs(creeping).max()
    assert join_rows(runs[2:]).goes_on == ()


def test_repeats_of_one_run_are_not_those_of_another(make_lab) -> None:
    """Equal labels of two runs stay apart; what has no label gets none."""
    lab = make_lab(captures=6, repeats=False)
    run = lab.dataset(lab.predict(lab.u)).assign_coords(repeat=("capture", ["r1", "", "r1", "", "", ""]))
    assert join_rows([rows_of(run), rows_of(run)]).repeat == (
        *("1:r1", "", "1:r1", "", "", ""),
        *("2:r1", "", "2:r1", "", "", ""),
    )


def test_runs_of_other_rigs_are_not_joined(make_lab) -> None:
    """What differs is named."""
    one, two = make_lab(captures=6), make_lab(captures=6, markers=5)
    a, b = (rows_of(lab.dataset(lab.predict(lab.u))) for lab in (one, two))
    with pytest.raises(LabrigError) as error:
        join_rows([a, b])
    assert str(error.value) == "the runs differ in their observables: they can't be diagnosed together"
    in_bar = replace(a, actuation_unit="bar")
    with pytest.raises(LabrigError) as error:
        join_rows([a, in_bar])
    assert str(error.value) == (
        "the runs differ in their units of the actuation: they can't be diagnosed together; import one of them again, "
        "with `scale` and `unit` as the other has them"
    )


def test_a_run_with_nothing_in_it_is_refused(make_lab) -> None:
    """No captures, no observables, nothing seen: each has its own complaint."""
    lab = make_lab(captures=6)
    data = lab.dataset(lab.predict(lab.u)).assign_attrs(run="today")

    def complaint(bad: xr.Dataset) -> str:
        with pytest.raises(LabrigError) as error:
            rows_of(bad)
        return str(error.value)

    assert complaint(data.isel(capture=slice(0))) == "today: the run has no captures; nothing can be compared"
    assert (
        complaint(data.drop_vars("position_mm"))
        == "today: the run has no observables; name some under 'observables:'"
    )
    unseen = data.assign(position_mm=np.nan * data.position_mm)
    assert complaint(unseen) == "today: no observable was seen in any capture"


@given(st.floats(1e-3, 10.0), st.integers(4, 30), st.floats(-100.0, 100.0))
def test_the_step_in_which_something_was_recorded(step: float, levels: int, zero: float) -> None:
    """Values that are all some multiple of a step from one another have that step; those of a continuum have none."""
    random = np.random.default_rng(0)
    coarse = zero + step * random.integers(0, levels, 200)
    fine = zero + step * levels * random.random(200)
    assert resolution_of(np.stack([coarse, fine, np.full(200, zero)], axis=1)) == pytest.approx([step, 0, 0])


@pytest.mark.parametrize(
    ("step", "digits", "said"),
    [
        (360 / 512, 3, 360 / 512),
        (360 / 512, 1, 360 / 512),
        (360 / 16384, 3, 360 / 16384),
        (360 / 16384, 2, 0.01),
        (0.25, 2, 0.25),
        (1e-3, 2, 0.01),
    ],
)
def test_steps_are_seen_through_the_digits_that_were_written(step: float, digits: int, said: float) -> None:
    """An encoder whose angles were written with few decimals has its own steps; or those of the last digit, if they
    are not finer by much.
    """
    random = np.random.default_rng(3)
    spread = int(max(60, 0.5 / step))
    values = np.round(3.3 + step * random.integers(0, spread, 400), digits)
    assert resolution_of(values[:, None]) == pytest.approx([said], rel=1e-3)


def test_what_returns_without_noise_is_not_coarse() -> None:
    """Five set-points that come again and again, each with its own value: in steps because the set-points are."""
    level = np.arange(60) % 5
    exact: Floats = np.array(3.0 * level)
    assert resolution_of(exact[:, None], level) == pytest.approx([0.0])
    coarse: Floats = np.array(exact + 0.5 * (np.arange(60) % 3))
    assert resolution_of(coarse[:, None], level) == pytest.approx([0.5])
    assert resolution_of(exact[:, None]) == pytest.approx([3.0])


def test_steps_too_small_to_have_multiples_are_no_resolution() -> None:
    """Values that differ by less than a number can be divided by say no step, and give no warning."""
    values = np.tile([0.0, 5e-324, 1.0, 2.0], 10)
    assert resolution_of(values[:, None]) == pytest.approx([0.0])
