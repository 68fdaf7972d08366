"""Axes, chambers and set-points that are mistaken for each other: one line says so, and nothing is named."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from labrig import LabrigError
from labrig.diagnosis import compare, diagnose, prepared, rows_from
from labrig.diagnosis._mixed_up import mixed_up
from labrig.model import Model
from tests.laws import bowed, limited, orifice, power_law, sliding, strut


def said(lab, values: np.ndarray) -> list[str]:
    """What is said to be mistaken."""
    return list(mixed_up(prepared(rows_from(lab.dataset(values)), lab.model()).context))


def axes(lab, values: np.ndarray, order: list[int], signs: tuple[int, int, int]) -> np.ndarray:
    """What is seen by cameras whose x is the model's axis order[0] with such a sign, and so on."""
    each = values.reshape(*values.shape[:2], -1, 3)
    return (each[..., order] * np.array(signs)).reshape(values.shape)


@pytest.mark.parametrize(
    ("order", "signs", "words"),
    [
        ([0, 2, 1], (1, 1, 1), "x, z and y"),
        ([0, 1, 2], (1, 1, -1), "x, y and -z"),
        ([1, 0, 2], (1, 1, 1), "y, x and z"),
    ],
)
def test_axes_of_another_name(make_lab, order: list[int], signs, words: str) -> None:
    """Cameras with y up, or another hand, from another origin: the line says which axis is which."""
    lab = make_lab(markers=12)
    seen = axes(lab, lab.predict(power_law(lab)) + lab.noise(), order, signs) + 200.0
    assert said(lab, seen) == [
        f"what is measured as x, y and z is {words} of the model, a mirror image: the axes of one of both are named "
        "otherwise, rename them in the mapping"
    ]


@pytest.mark.parametrize(
    ("order", "signs", "words"),
    [([0, 1], (1, -1), "x and -z"), ([1, 0], (1, 1), "z and x"), ([0, 1], (1, 1), "")],
)
def test_axes_of_one_camera(make_lab, order: list[int], signs, words: str) -> None:
    """Of markers that one camera sees, x and z, an image that is upside down, or exchanged axes, are said."""
    lab = make_lab(markers=12)
    context = prepared(rows_from(lab.dataset(lab.predict(power_law(lab)) + lab.noise())), lab.model()).context
    own, rows = context.rows.axis != 1, context.rows
    seen = rows.values[:, own].reshape(len(rows.values), -1, 2)[..., order] * np.array(signs) + 200.0
    flat = replace(
        rows,
        values=seen.reshape(len(seen), -1),
        unit=tuple(np.array(rows.unit)[own]),
        observables=tuple(np.array(rows.observables)[own]),
        marker=rows.marker[own],
        axis=rows.axis[own],
    )
    parts = {"base": context.base[:, own], "base_vented": context.base_vented[own]}
    found = [
        *mixed_up(
            replace(context, rows=flat, jacobian=context.jacobian[:, own], displaced=None, _memo={}, **parts)
        )
    ]
    told = f"what is measured as x and z is {words} of the model, a mirror image: "
    assert [line[: len(told)] for line in found] == ([told] if words else [])


@pytest.mark.parametrize("turn", [30.0, 85.0, 90.0, 178.0])
def test_a_turned_frame_is_no_other_axes(make_lab, turn: float) -> None:
    """Cameras that were turned, by a right angle, too, are a frame, which has a name and a formula."""
    lab = make_lab(markers=12)
    a = np.deg2rad(turn)
    R = np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]])
    values = (lab.predict(lab.u) + lab.noise()).reshape(60, -1, 12, 3) @ R.T
    assert said(lab, values.reshape(60, -1, 36)) == []


def test_hoses_that_were_exchanged(make_lab) -> None:
    """Chambers one and three move what the other should, and creep: two names, and what to look at."""
    lab = make_lab(chambers=4, markers=12)
    values = lab.predict(power_law(lab)[..., [2, 1, 0, 3]]) + lab.noise()
    assert said(lab, values) == [
        "c1 does what the model says of c3, c3 does what the model says of c1: check their hoses, and the order of the "
        "chambers in the mapping and in the model"
    ]


def test_chambers_that_go_round(make_lab) -> None:
    """Each of three has the hose of the next."""
    lab = make_lab(markers=12)
    (line,) = said(lab, lab.predict(lab.u[..., [1, 2, 0]]) + lab.noise())
    assert line.startswith(
        "c1 does what the model says of c3, c2 does what the model says of c1, c3 does what the model says of c2: "
    )


def test_chambers_with_other_ranges(make_lab) -> None:
    """A chamber that goes to a third of the pressure is known by what a kilopascal does, not by how far it went."""
    lab = make_lab(markers=12, bent=0.0)
    lab.commanded[:, 0] /= 3.0
    (line,) = said(lab, lab.predict(lab.u[..., [1, 0, 2]]) + lab.noise())
    assert line.startswith("c1 does what the model says of c2, c2 does what the model says of c1: ")


def test_twins_may_be_exchanged(make_lab) -> None:
    """Of two chambers that do nearly the same nobody is told that they are exchanged."""
    lab = make_lab(markers=12)
    lab.reach[:, 1] = 1.03 * lab.reach[:, 0]
    assert said(lab, lab.predict(lab.u[..., [1, 0, 2]]) + 0.1 * lab.noise()) == []


@pytest.mark.parametrize(("later", "word"), [(1, "before"), (-1, "after")])
def test_rows_that_slipped_by_one(make_lab, later: int, word: str) -> None:
    """A table whose pressures and measurements were put together one row off."""
    lab = make_lab(markers=12)
    values = lab.predict(np.roll(lab.u, later, axis=0)) + lab.noise()
    assert said(lab, values) == [
        f"what is measured at each set-point is what the model says of the one {word}: check how the pressures and the "
        "measurements were put together"
    ]


@pytest.mark.parametrize("law", [None, bowed, limited, orifice, power_law, sliding, strut])
def test_physics_is_no_mistake(make_lab, law) -> None:
    """Whatever is missing, and at twenty times the size, nothing is said to be exchanged."""
    lab = make_lab(markers=12, seed=3)
    clean = lab.predict(lab.u)
    more = (lab.predict(law(lab)) if law else clean) - clean
    for times in (1.0, 20.0):
        assert said(lab, clean + times * more + lab.noise()) == []


def test_nothing_is_named_before_it_is_put_right(make_lab) -> None:
    """A diagnosis ends with the line, where it called exchanged hoses a contact; a comparison warns."""
    lab = make_lab(markers=12)
    data = lab.dataset(lab.predict(lab.u[..., [1, 0, 2]]) + lab.noise())
    start = "c1 does what the model says of c2, c2 does what the model says of c1: check their hoses"
    with pytest.raises(LabrigError, match=f"^nothing can be diagnosed: {re.escape(start)}"):
        diagnose(data, lab.model())
    assert [line for line in compare(data, lab.model()).summary["warnings"] if line.startswith(start)]


def test_a_loop_as_wide_as_a_step_is_no_slip_of_rows(make_lab) -> None:
    """On stairs of a twentieth of the range play of one step has the set-point before on the way: it is hysteresis."""
    lab = make_lab(chambers=1, markers=12, captures=120)
    lab.commanded[:, 0] = np.resize(np.r_[0:61:3, 57:0:-3], 120)
    state, u = 0.0, lab.u
    for i, now in enumerate(lab.commanded[:, 0]):
        state = max(now - 3.0, min(now + 3.0, state))
        u[i] = state
    assert said(lab, lab.predict(u) + lab.noise()) == []


def test_a_chamber_that_stays_is_exchanged_with_none(make_lab) -> None:
    """One at 30 kPa all the time beside one that is not connected: no exchange."""
    lab = make_lab(markers=12)
    lab.commanded[:, 0] = 30.0
    u = lab.u
    u[..., 1] = 0.0
    assert said(lab, lab.predict(u) + lab.noise()) == []


def test_a_mirror_or_exchanged_hoses(make_lab) -> None:
    """Of a symmetric rig nobody can say which: both are said, in one line."""
    lab = make_lab(chambers=2, markers=6)
    z = 20.0 * np.arange(6)
    lab.rest_mm[:] = np.stack([0 * z, z**2 / 100, z], axis=1)
    lab.rest = lab.rest_mm.ravel()
    lab.reach[:] = 0.0
    lab.reach[0::3] = np.linspace(2, 20, 6)[:, None] * np.array([1.0, -1.0])
    (line,) = said(lab, lab.predict(lab.u[..., [1, 0]]) + lab.noise())
    assert "what is measured as x, y and z is -x, y and z of the model" in line
    assert "; or c1 does what the model says of c2" in line


def test_columns_of_a_function_in_another_order(make_lab) -> None:
    """A function that gives a sensor first, as the table had it, where the run has the markers first: it is said."""
    lab = make_lab(markers=3)
    context = prepared(rows_from(lab.dataset(lab.predict(power_law(lab)) + lab.noise())), lab.model()).context
    assert [*mixed_up(context)] == []
    rolled = replace(context, base=np.roll(context.base, 1, axis=1), _memo={})
    assert [*mixed_up(rolled)] == [
        "the model gives its columns in another order than the run: where the run has m0.x, it gives what follows "
        "m2.z; let it give them in the order m0.x, m0.y, m0.z, m1.x, m1.y, m1.z, ..."
    ]
    assert [*mixed_up(replace(rolled, base_kind="simulator", _memo={}))] == []


def test_all_x_then_all_y_then_all_z(make_lab) -> None:
    """A model whose columns are those of each axis, where the run has those of each marker, is told so."""
    lab = make_lab(markers=12)
    values = lab.predict(power_law(lab)) + lab.noise()
    seen = np.moveaxis(values.reshape(*values.shape[:2], 3, 12), 2, 3).reshape(values.shape)
    (line,) = said(lab, seen)
    assert line == (
        "the model gives x of all markers, then y and z of all: the run has m0.x, m0.y, m0.z, then those of the next "
        "marker, so let it give them in this order"
    )
    with pytest.raises(LabrigError, match="the model gives x of all markers"):
        diagnose(lab.dataset(seen), lab.model())


@pytest.mark.parametrize(
    ("by", "words"),
    [(1, "begins with the last of them"), (-1, "ends with the first of them"), (0, "")],
)
def test_a_quaternion_in_another_order(make_lab, by: int, words: str) -> None:
    """One of both has w first, the other last: the line says so, and none where they have the same order."""
    lab = make_lab(captures=40)
    turn = Rotation.from_rotvec(0.02 * lab.u.reshape(-1, 3) - 0.6).as_quat()
    run = lab.dataset(lab.predict(lab.u)).drop_vars(["position_mm", "rest_mm"])
    read = turn.reshape(40, -1, 4) + 0.002 * lab.random.normal(size=(40, lab.u.shape[1], 4))
    run = run.assign(observed=(("capture", "time", "observable"), read))
    ways = {"unit": ["1"] * 4, "marker_of": [""] * 4, "axis_of": [""] * 4}
    run = run.assign_coords(
        observable=["qx", "qy", "qz", "qw"], **{n: ("observable", v) for n, v in ways.items()}
    )

    def model(u: np.ndarray) -> np.ndarray:
        return np.roll(Rotation.from_rotvec(0.02 * u - 0.6).as_quat(), by, axis=1)

    lines = list(mixed_up(prepared(rows_from(run), Model.of(model)).context))
    assert len(lines) == bool(by)
    assert not by or lines[0].startswith(f"qx, qy, qz, qw is a quaternion that in the model {words}")


@pytest.mark.parametrize(("sign", "bow"), [(-1.0, 0.0), (-0.7, 0.0), (1.0, 0.0), (1.0, 0.8)])
def test_a_sensor_that_goes_the_other_way(make_lab, sign: float, bow: float) -> None:
    """A force of the other sign is no physics, be it weaker or not; one that bows far under its model is."""
    lab = make_lab(captures=40, force=True)
    plain = lab.predict(lab.u)
    lines = said(lab, sign * plain - bow * plain**2 / plain.max() + lab.noise())
    assert [line.startswith("what is measured in N goes the other way") for line in lines] == [True] * (
        sign < 0
    )
