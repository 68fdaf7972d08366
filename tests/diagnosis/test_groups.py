"""What is another in each session: days, specimens and mountings as groups."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from labrig._errors import LabrigError
from labrig.diagnosis import compare, diagnose
from labrig.effects import join_rows, library, rows_of
from labrig.model import Model, write_model_file
from labrig.model._bases import StaticModel
from labrig.model._file import StaticBase

DAYS = 4


def another_frame(lab, day):
    """Every day the markers are seen by cameras that stand a little elsewhere: true rotations about their centre."""
    random, out = np.random.default_rng(3), lab.predict(lab.u)
    centre = lab.rest_mm.mean(axis=0)
    for d in range(DAYS):
        turn, shift = Rotation.from_rotvec(0.02 * random.normal(size=3)), 0.8 * random.normal(size=3)
        seen = out[day == d].reshape(-1, 3) - centre
        out[day == d] = (turn.apply(seen) + centre + shift).reshape(out[day == d].shape)
    return out


def another_supply(lab, day):
    """Every day the regulator was calibrated anew, by some per cent otherwise."""
    return lab.predict(lab.u * np.array([1.07, 0.94, 1.03, 0.96])[day][:, None, None])


def another_zero(lab, day):
    """Every day the pressure sensors were zeroed at another air pressure."""
    return lab.predict(lab.u + np.array([2.2, -1.4, 0.6, -1.8])[day][:, None, None])


def another_specimen(lab, day):
    """Every day another specimen was mounted, each with a sag and a warp of its own that stretches out under load."""
    at = lab.rest_mm / np.ptp(lab.rest_mm[:, 0])
    shapes = np.stack([at[:, 0] ** 2, np.sin(4 * at[:, 0] + at[:, 1]), np.cos(3 * at[:, 0])])
    sag = np.random.default_rng(5).normal(size=(DAYS, 3)) @ shapes
    offset = sag[:, :, None] * np.array([0.2, 0.3, 1.0])
    flat = 1 - 0.08 * lab.u.mean(axis=2, keepdims=True) / lab.u.max()
    return lab.predict(lab.u) + flat * offset.reshape(DAYS, -1)[day][:, None]


@pytest.mark.parametrize(
    ("hidden", "effect", "parameter"),
    [
        (another_frame, "frame", "shift_in_session"),
        (another_zero, "regulator", "offset_in_session"),
        (another_specimen, "rest_shape", "offset_in_session"),
    ],
)
def test_what_is_another_every_day(make_lab, few_effects, hidden, effect, parameter) -> None:
    """A frame, a gain, a zero or a rest shape of each day is named, fitted day by day, and nothing of it is left."""
    few_effects("frame", "regulator", "rest_shape", "gravity", "drift", "tension", "stiffening")
    lab = make_lab(chambers=2, captures=60, sessions=DAYS)
    found = diagnose(lab.dataset(hidden(lab, lab.session) + lab.noise()), lab.model())
    assert [*found.summary["effects"], *found.summary["rivals"]] == [effect]
    assert found.improved is not None
    (entry,) = found.improved.file.effects
    assert (entry.form or "").endswith("in each session")
    assert {label.split(":")[0] for label in entry.parameters[parameter].per or ()} == {
        "s0",
        "s1",
        "s2",
        "s3",
    }
    error = found.summary["error"]
    assert error["model"] < 1.1 * error["floor"] < 0.5 * error["base"]


def test_the_day_that_stands_apart_is_said_by_name(make_lab) -> None:
    """Where a model fails on one day only, that day is the first of its group."""
    lab = make_lab(captures=60, sessions=DAYS)
    off = lab.predict(lab.u * np.where(lab.session == 2, 0.9, 1.0)[:, None, None])
    found = compare(lab.dataset(off + lab.noise()), lab.model())
    days = [place for place in found.summary["where"] if place["group"] == "session"]
    assert [d["name"] for d in days if d["clear"]] == ["s2"]
    assert days[0]["name"] == "s2"


def test_a_day_of_which_nothing_is_known(make_lab, few_effects, tmp_path) -> None:
    """On a run with known and new days the known ones are taken off, nothing of the new one is, and that is said."""
    few_effects("frame", "regulator", "rest_shape", "gravity", "drift", "tension", "stiffening")
    lab = make_lab(chambers=2, captures=60, sessions=DAYS)
    dataset = lab.dataset(another_supply(lab, lab.session) + lab.noise())
    known = dataset.isel(capture=lab.session < 3, event=lab.session < 3)
    found = diagnose(known, lab.model())
    assert found.improved is not None
    path = tmp_path / "known.yaml"
    write_model_file(found.improved.file, path)
    model = Model.load(path)
    context = model.context(rows_of(dataset))
    error = [np.sqrt(np.nanmean(context.residual[context.rows.session == s] ** 2)) for s in range(DAYS)]
    assert max(error[:3]) < 0.6 * error[3]
    assert compare(dataset, model).summary["warnings"][0] == (
        "regulator: gain_in_session is another in each session, and has no value for s3: nothing is taken off there"
    )
    only = dataset.isel(capture=lab.session == 1, event=lab.session == 1)
    only = only.assign_coords(event_of=("capture", np.arange(only.sizes["capture"])))
    assert not any("no value" in w for w in compare(only, model).summary["warnings"])


def test_what_was_recorded_goes_before_the_session(make_lab) -> None:
    """Where a payload tells the sessions apart nothing is another in each of them; a temperature does not."""
    lab = make_lab(captures=24, sessions=DAYS)
    loads = np.array([0.0, 0.2, 0.4, 0.2])[lab.session]
    warm = 20.0 + lab.session + 0.1 * np.arange(24)

    def forms(covariates) -> set[str]:
        rows = rows_of(lab.dataset(lab.predict(lab.u), covariates))
        context = replace(lab.model().context(rows), saved=False)
        return {v.form for name in ("frame", "regulator") for v in library()[name].variants(context)}

    assert not any(form.endswith("in each session") for form in forms({"payload": ("kg", loads)}))
    assert sum(form.endswith("in each session") for form in forms({"air": ("degC", warm)})) == 4


def specimens(lab):
    """Straight answers, of another size and from another place in each session."""
    random = np.random.default_rng(1)
    size, place = random.uniform(0.8, 1.2, DAYS), 2.0 * random.normal(size=(DAYS, len(lab.rest)))
    moved = (lab.predict(lab.u) - lab.rest) * size[lab.session][:, None, None]
    return lab.rest + moved + place[lab.session][:, None]


def test_a_map_for_each_session(make_lab, tmp_path) -> None:
    """Four specimens, a straight line for each: nothing is missing; one line for all of them fails."""
    lab = make_lab(chambers=2, captures=60, sessions=DAYS, bent=0.0)
    dataset = lab.dataset(specimens(lab) + lab.noise(0.02, 0.05))
    (tmp_path / "each.yaml").write_text("base: {kind: static, in_each_session: true}")
    (tmp_path / "one.yaml").write_text("base: {kind: static}")
    found = diagnose(dataset, Model.load(tmp_path / "each.yaml"))
    assert found.summary["verdict"] == "nothing_missing"
    one = compare(dataset, Model.load(tmp_path / "one.yaml")).summary["error"]
    assert found.summary["error"]["base"] < 0.05 * one["model"]
    rows = rows_of(dataset)
    declared = Model.load(tmp_path / "each.yaml").declared(rows)
    assert declared is not None
    assert np.linalg.matrix_rank(declared) == declared.shape[1] == DAYS * 3


def test_a_map_of_another_session(make_lab, tmp_path) -> None:
    """Of a session that it was not fitted to a base with a map for each says what one map for all of them says."""
    lab = make_lab(captures=80, sessions=DAYS, bent=0.0)
    rows = rows_of(lab.dataset(specimens(lab)))
    spec = {each: StaticBase(kind="static", degree=1, in_each_session=each) for each in (False, True)}
    known = rows.thin(rows.session < 3)
    each, one = StaticModel(spec[True], known), StaticModel(spec[False], known)
    said, all_alike = each.predict_rows(rows), one.predict(rows.actuation)
    assert said[rows.session == 3] == pytest.approx(all_alike[rows.session == 3])
    assert said[rows.session < 3] == pytest.approx(rows.values[rows.session < 3])
    many = make_lab(captures=48, sessions=12)
    with pytest.raises(LabrigError) as caught:
        StaticModel(spec[True], rows_of(many.dataset(many.predict(many.u))))
    assert str(caught.value) == (
        "base: a map for each session (in_each_session) is for 11 sessions at most, and this run has 12"
    )


def test_counted_sessions_are_those_of_their_run(make_lab) -> None:
    """A session that is only counted is another run's session 0 by the run, one with a name is the same anywhere."""
    lab = make_lab(captures=12)
    dataset = lab.dataset(lab.predict(lab.u))
    counted = dataset.assign_coords(session=("capture", ["0"] * 12), event_session=("event", ["0"] * 12))
    rows = rows_of(counted.assign_attrs(run_id="0123456789abcdef"))
    assert rows.session_keys == ("01234567/0",)
    assert rows_of(counted).session_keys == ("0",)
    named = rows_of(dataset.assign_attrs(run_id="0123456789abcdef"))
    assert named.session_keys == ("s0",)
    assert join_rows([rows, named]).session_keys == ("01234567/0", "s0")
    assert join_rows([replace(rows, session_keys=()), named]).session_keys == ("0", "s0")
