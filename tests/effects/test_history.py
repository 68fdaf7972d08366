"""History: play, relaxation, direction, and what sessions do to them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrig.effects import Context, Rows, rows_of
from labrig.effects._skin import at_events, path_direction
from labrig.model import Model, base_context
from labrig.model._bases import StaticModel
from labrig.model._file import StaticBase

PATHS = st.lists(st.floats(0, 60), min_size=2, max_size=12)


def context_of(
    path: list[float], times: np.ndarray | None = None, sessions: list[int] | None = None
) -> Context:
    """One chamber that visits `path`, one row at each stop (3 s into it), one observable."""
    import xarray as xr

    n = len(path)
    u = np.array(path, float)[:, None]
    at = np.arange(n) * 10.0 if times is None else times
    session = [f"s{s}" for s in sessions or [0] * n]
    data = xr.Dataset(
        {
            "commanded": (("capture", "chamber"), u, {"units": "kPa"}),
            "hold_s": (("capture", "time"), np.full((n, 1), 3.0)),
            "time_s": (("capture", "time"), at[:, None] + 3.0),
            "event_time_s": ("event", at),
            "event_commanded": (("event", "chamber"), u),
            "observed": (("capture", "time", "observable"), u[:, None]),
        },
        coords={
            "chamber": ["c1"],
            "chamber_min": ("chamber", [0.0]),
            "chamber_max": ("chamber", [60.0]),
            "session": ("capture", session),
            "event_session": ("event", session),
            "event_of": ("capture", np.arange(n)),
            "repeat": ("capture", [""] * n),
            "observable": ["d"],
            "unit": ("observable", ["mm"]),
            "marker_of": ("observable", [""]),
            "axis_of": ("observable", [""]),
        },
        attrs={"between_sessions": "vented"},
    )
    return seen_by_a_line(rows_of(data))


def seen_by_a_line(rows: Rows) -> Context:
    """The context of a linear base."""
    return base_context(StaticModel(StaticBase(kind="static", degree=1), rows), rows)


@given(PATHS, st.floats(0.02, 0.5), st.floats(0.1, 1000))
@settings(max_examples=60)
def test_play_does_not_know_the_clock(path: list[float], width: float, pace: float) -> None:
    """However fast the path is run through, the states are the same: hysteresis is rate-independent."""
    n = len(path)
    slow = context_of(path, np.arange(n) * 10.0)
    fast = context_of(path, np.arange(n) * pace)
    assert slow.play(width) == pytest.approx(fast.play(width))


@given(PATHS, st.floats(0.02, 0.5))
@settings(max_examples=60)
def test_play_follows_within_its_width(path: list[float], width: float) -> None:
    """The state is never further from its input than the half width, and stops on the way are seen straight."""
    state = context_of(path).play(width)[:, 0]
    assert (np.abs(state - path) <= width * 60 + 1e-9).all()
    finer = [v for a, b in zip([0.0, *path], path, strict=False) for v in ((a + b) / 2, b)]
    assert context_of(finer).play(width)[1::2, 0] == pytest.approx(state)


@given(PATHS, st.floats(0.02, 0.5), st.floats(0, 60), st.floats(0, 60))
@settings(max_examples=60)
def test_an_inner_loop_closes(path: list[float], width: float, a: float, b: float) -> None:
    """Return-point memory: after a smaller excursion and back, the state is as if it had never been made."""
    low, high = min(a, b), max(a, b)
    there = [*path, high, low]
    around = [*there, (low + high) / 2, low]
    assert context_of(around).play(width)[-1] == pytest.approx(context_of(there).play(width)[-1])


@given(PATHS, st.floats(0.5, 500))
@settings(max_examples=60)
def test_a_relaxing_state_is_that_of_a_kelvin_voigt_element(path: list[float], tau_s: float) -> None:
    """The strain at each row is the hereditary integral of all steps before it, each as 1 - exp(-t / tau)."""
    context = context_of(path)
    at = context.rows.time_s
    steps = np.diff(path, prepend=0.0)
    since = at[:, None] - context.rows.event_time_s
    exact = np.where(since > 0, steps * -np.expm1(-np.maximum(since, 0) / tau_s), 0.0).sum(axis=1)
    assert context.relaxed(tau_s)[:, 0] == pytest.approx(exact, abs=1e-9)


def test_a_linear_base_strains_as_its_pressures_relax() -> None:
    """For a linear base the lag of the deflection and the lag of the pressure are one."""
    context = context_of([10.0, 50.0, 20.0, 60.0, 0.0])
    assert context.linear
    assert context.strained(7.0) == pytest.approx(context.relaxed(7.0), abs=1e-6)


@pytest.mark.parametrize("between", ["vented", "unknown", "held"])
def test_sessions_begin_vented_unless_held(between: str) -> None:
    """Held pressures go on from session to session; vented ones, and unknown ones, begin at zero."""
    whole = context_of([20.0, 60.0, 40.0, 30.0], sessions=[0, 0, 1, 1])
    context = seen_by_a_line(replace(whole.rows, between_sessions=between))
    held = between == "held"
    assert context.previous[:, 0].tolist() == [0.0, 20.0, 60.0 if held else 0.0, 40.0]
    assert context.direction[:, 0].tolist() == [1.0, 1.0, -1.0 if held else 1.0, -1.0]
    assert context.play(0.1)[:, 0].tolist() == (
        [14.0, 54.0, 46.0, 36.0] if held else [14.0, 54.0, 34.0, 34.0]
    )
    alone = context_of([40.0, 30.0]).relaxed(30.0)
    if not held:
        assert context.relaxed(30.0)[2:] == pytest.approx(alone)
    else:
        assert (context.relaxed(30.0)[2:] > alone + 1.0).all()


def test_session_time_starts_anew() -> None:
    """Time in session is counted from the first actuation of each."""
    context = context_of([20.0, 60.0, 40.0], times=np.array([0.0, 10.0, 5000.0]), sessions=[0, 0, 1])
    assert context.session_time_s.tolist() == [3.0, 13.0, 3.0]


def test_direction_lasts_while_nothing_moves() -> None:
    """A set-point that is commanded again keeps the direction from which it was reached."""
    context = context_of([0.0, 30.0, 30.0, 10.0, 10.0])
    assert context.direction[:, 0].tolist() == [0.0, 1.0, 1.0, -1.0, -1.0]


def test_the_way_of_all_chambers_lasts_while_nothing_moves() -> None:
    """Set-points that come again leave what rubs as it was, up to the first move, before which there is none."""
    np.testing.assert_array_equal(
        path_direction(context_of([0.0, 10.0, 10.0, 5.0, 5.0]))[:, 0], [0, 1, 1, -1, -1]
    )


def test_a_pinned_quantity_replaces_its_grid() -> None:
    """Only what is named is pinned."""
    context = context_of([0.0, 30.0])
    assert context.grid("width", (0.1, 0.2)) == (0.1, 0.2)
    pinned = context.pin({"width": 0.17})
    assert pinned.grid("width", (0.1, 0.2)) == (0.17,)
    assert pinned.grid("tau_s", (3.0,)) == (3.0,)


def test_thinned_rows_keep_the_history() -> None:
    """Leaving rows out changes nothing of the states of the others."""
    context = context_of([10.0, 50.0, 20.0, 60.0, 0.0, 30.0])
    keep = np.array([1, 4])
    thin = context.thin(keep)
    assert thin.play(0.2) == pytest.approx(context.play(0.2)[keep])
    assert thin.relaxed(30.0) == pytest.approx(context.relaxed(30.0)[keep])


def test_what_the_sensors_read_is_split_into_error_and_fall(make_lab) -> None:
    """Measured less commanded at the beginning of the hold, and what is lost after it; None if not measured."""
    lab = make_lab(captures=6, repeats=False)
    data = lab.dataset(lab.predict(lab.u))
    assert seen_by_a_line(rows_of(data)).measured_fall is None
    read = lab.u + 1.5
    read[:, 2] -= 0.5
    data["measured"] = (("capture", "time", "chamber"), read)
    context = seen_by_a_line(rows_of(data))
    assert context.measured_error == pytest.approx(np.full((18, 3), 1.5))
    assert context.measured_fall == pytest.approx(np.tile([0.0, 0.0, -0.5], 6)[:, None].repeat(3, axis=1))


def test_a_logged_position_has_a_speed(make_lab) -> None:
    """A covariate in mm is a motion, its speed taken along time; a temperature or a tilt is none."""
    lab = make_lab(captures=20, rows_s=(3.0,), repeats=False)
    place = 2.0 * lab.event_s
    rest = np.linspace(20, 21, 20)
    context = seen_by_a_line(
        rows_of(
            lab.dataset(
                lab.predict(lab.u),
                {"rod": ("mm", place), "temperature": ("degC", rest), "tilt": ("deg", rest)},
            )
        )
    )
    assert list(context.motion) == ["rod"]
    speed, span = context.motion["rod"]
    assert speed[3:-3] == pytest.approx(2.0)
    assert span == pytest.approx(np.ptp(place))


@given(PATHS, st.floats(0.1, 45.0), st.booleans())
def test_what_was_commanded_earlier(path: list[float], dead_s: float, held: bool) -> None:
    """So many seconds ago the set-point before that moment stood; before a session's first, what sessions leave."""
    sessions = [int(i >= len(path) // 2) for i in range(len(path))]
    context = context_of(path, sessions=sessions)
    if held:
        context = replace(context, rows=replace(context.rows, between_sessions="held"), _memo={})
    for i, now in enumerate(np.arange(len(path)) * 10.0 + 3.0):
        past = [k for k in range(i + 1) if sessions[k] == sessions[i] and k * 10.0 <= now - dead_s]
        before = [k for k in range(i) if sessions[k] != sessions[i]] if held else []
        expected = path[past[-1]] if past else path[before[-1]] if before else 0.0
        assert context.earlier(dead_s)[i, 0] == pytest.approx(expected)
    assert context.sample_s == 0.0


def test_captures_of_one_row_are_no_record() -> None:
    """Many captures with one row each, some seconds into their holds, are set-points; rows without holds a record."""
    path, times = list(np.linspace(0, 60, 150)), np.arange(150) * 0.5
    captures = context_of(path, times)
    assert captures.sample_s == 0.0
    rows = replace(captures.rows, hold_s=np.zeros(150), time_s=times)
    record = replace(captures, rows=rows, _memo={})
    assert record.sample_s == 0.5
    line = np.interp(times - 0.7, times, path, left=0.0)
    assert record.earlier(0.7)[2:, 0] == pytest.approx(line[2:])


def test_what_was_set_and_not_recorded_moved_the_surface_too(make_lab) -> None:
    """Where a capture is left out, the surface was still where the base has it then, also where chambers help each
    other: what remembers knows the way.
    """

    def base(u: np.ndarray) -> np.ndarray:
        return lab.predict(u) + 0.02 * u[..., :1] * u[..., 1:2]

    lab = make_lab(captures=20, bent=1.5)
    rows = rows_of(lab.dataset(base(lab.u)))
    context = Model.of(base).predictor(rows).context(rows)
    some = context.thin(np.flatnonzero(rows.capture % 3 != 1))
    assert at_events(some) == pytest.approx(at_events(context), abs=1e-9)
    assert at_events(replace(some, elsewhere=None)) != pytest.approx(at_events(context), abs=0.1)
