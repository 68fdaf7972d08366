"""Records in which a rig never rests: the slopes of a fitted map, and what came before the first sample."""

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from labrig.diagnosis import prepared, rows_from
from labrig.model import Model

DT_S, TAU_S = 0.5, 12.0
NOISE_MM = 0.05


def driven(n: int, seed: int) -> np.ndarray:
    """An input (n,) from 0 to 1 that turns faster than the rig follows."""
    random = np.random.default_rng(seed)
    t = np.arange(n) / n
    u = np.sum([np.sin(2 * np.pi * (f * t + random.uniform())) for f in (9, 17, 31, 47, 70)], axis=0)
    return (u - u.min()) / np.ptp(u)


def followed(u: np.ndarray, level: float) -> np.ndarray:
    """Motion (n,), mm, of a body that empties through an orifice, and bends the more the fuller it is."""
    out = np.empty(len(u))
    for i, x in enumerate(u):
        out[i] = 8 * (level + 0.4 * level**2)
        for _ in range(10):  # flow by the root of the level: no lag of one time constant
            level = max(level + DT_S / 10 * 1.5 / TAU_S * (np.sqrt(x) - np.sqrt(level)), 0.0)
    return out


def imported(folder, u, y, **more):
    """A run of a record of one chamber (0 to 100 kPa) and one observable."""
    folder.mkdir(exist_ok=True)
    random = np.random.default_rng(len(u))
    seen = y + NOISE_MM * random.normal(size=len(y))
    pd.DataFrame({"t": DT_S * np.arange(len(u)), "p": 100 * u, "y": seen}).to_csv(
        folder / "t.csv", index=False
    )
    mapping = {
        "table": "t.csv",
        "time": {"column": "t", "unit": "s"},
        "actuation": [{"column": "p", "name": "p", "unit": "kPa", "min": 0, "max": 100}],
        "observables": [{"column": "y", "name": "y", "unit": "mm"}],
        **more,
    }
    (folder / "map.yaml").write_text(yaml.safe_dump(mapping))
    (folder / "model.yaml").write_text("base: {kind: static, degree: 2}\n")
    return labrig.import_table(folder / "map.yaml", folder / "run")


def context_of(folder, run):
    """What the effects are given of a run."""
    rows = rows_from(run)
    return Model.load(folder / "model.yaml").predictor(rows).context(rows)


def test_slopes_are_those_at_rest(tmp_path):
    """A map that is fitted to a record is much flatter than the rig at rest; effects act through slopes at rest."""
    u = driven(1200, 1)
    context = context_of(tmp_path, imported(tmp_path, u, followed(u, float(u[0]))))
    true = 8 * (1 + 0.8 * u) / 100
    inner = (u > 0.2) & (u < 0.8)
    fitted = np.polynomial.Polynomial.fit(u, context.base[:, 0], 2).deriv()(u) / 100
    assert np.median(fitted[inner] / true[inner]) < 0.5
    assert np.median(context.jacobian[inner, 0, 0] / true[inner]) == pytest.approx(1, abs=0.25)


@pytest.mark.parametrize(("start", "level"), [("vented", 0.0), ("rest", None)])
def test_the_record_says_how_it_began(tmp_path, start, level):
    """Where nobody said what came before the first sample: vented chambers, or rest at that sample."""
    u = driven(1200, 2)
    u = np.maximum(u, 0.5) if level is None else np.maximum(u, 0.3)
    context = context_of(
        tmp_path, imported(tmp_path, u, followed(u, float(u[0]) if level is None else level))
    )
    assert context.rows.between_sessions == start


def test_so_it_does_beside_a_base_of_ones_own(tmp_path):
    """The same beside a function of the user's that has the rig's map, and no memory."""
    u = np.maximum(driven(1200, 2), 0.5)
    began = {}
    for level in (0.0, float(u[0])):
        folder = tmp_path / f"{level:.2f}"
        run = imported(folder, u, followed(u, level))
        (folder / "base.py").write_text("def predict(a):\n    x = a / 100\n    return 8 * (x + 0.4 * x**2)\n")
        (folder / "model.yaml").write_text("base: {kind: python, file: base.py, function: predict}\n")
        began[level] = context_of(folder, run).rows.between_sessions
    assert list(began.values()) == ["vented", "rest"]


def test_what_is_said_of_the_past_is_believed(tmp_path):
    """A mapping that says that the chambers were vented is not overruled."""
    u = np.maximum(driven(600, 2), 0.5)
    run = imported(tmp_path, u, followed(u, float(u[0])), between_sessions="vented")
    assert context_of(tmp_path, run).rows.between_sessions == "vented"


def test_a_record_that_began_at_rest_has_no_first_step(tmp_path):
    """Lags, plays and dead times stand at the first sample where the record began there."""
    u = np.maximum(driven(600, 2), 0.5)
    context = context_of(tmp_path, imported(tmp_path, u, followed(u, float(u[0]))))
    first = context.rows.actuation[0]
    for remembered in (context.relaxed(20.0), context.play(0.1), context.earlier(3.0), context.previous):
        assert remembered[0] == pytest.approx(first)


def test_an_observable_that_was_not_seen_everywhere(tmp_path):
    """Samples that are missing, or wild, change the slopes at rest little."""
    u = driven(1200, 1)
    y = followed(u, float(u[0]))
    whole = context_of(tmp_path, imported(tmp_path, u, y)).jacobian
    y[::7], y[100:110] = np.nan, 60.0
    some = context_of(tmp_path / "some", imported(tmp_path / "some", u, y)).jacobian
    assert some.mean() == pytest.approx(whole.mean(), rel=0.1)


def test_what_was_added_holds_on_another_record(tmp_path):
    """A lag that is named on one record, surely or perhaps, takes most of the error off another that begins in the
    middle of things.
    """
    u = driven(1500, 3)
    found = labrig.diagnose(imported(tmp_path, u, followed(u, float(u[0]))), tmp_path / "model.yaml")
    assert {*found.sure, *found.possible} in ({"creep"}, {"delay"}, {"creep", "delay"})
    assert found.error["model"] < 0.25 * found.error["base"]
    assert found.improved is not None
    found.improved.save(tmp_path / "improved.yaml")
    other = driven(1500, 4)
    level = followed(other, float(other[0]))[400:]
    run = imported(tmp_path / "later", other[400:], level)
    rows = rows_from(run)
    left = {}
    for name in ("model", "improved"):
        predicted = Model.load(tmp_path / f"{name}.yaml").predictor(rows).context(rows)
        left[name] = float(np.sqrt(np.mean(predicted.residual[60:] ** 2)))
    assert left["improved"] < 0.4 * left["model"]


def test_what_was_before_a_record_is_no_noise(tmp_path):
    """A record that begins in the middle of a recovery, neither vented nor at rest, shows a lag beside the noise."""
    u = np.repeat(np.random.default_rng(1).uniform(0.2, 1, 60), 20)
    upper, lower, motion = 0.9, 0.1, np.empty(len(u))
    for i, x in enumerate(u):  # two volumes, one after the other, that fill the faster the fuller they are
        motion[i] = 8 * lower
        for _ in range(10):
            upper += DT_S / 20 * (x - upper) * (0.6 + 0.8 * upper)
            lower += DT_S / 12 * (upper - lower) * (0.6 + 0.8 * lower)
    found = labrig.diagnose(imported(tmp_path, u, motion), tmp_path / "model.yaml")
    assert found.summary["effects"] == ["delay"]
    assert found.error["floor"] < 2 * NOISE_MM


def test_what_was_before_is_asked_of_each_session(tmp_path):
    """Decays of each session of its own, at its beginning 1; none where the past is known, or set-points are held."""
    u = driven(600, 6)
    folder = tmp_path / "two"
    imported(folder, u, followed(u, 0.3))
    table = pd.read_csv(folder / "t.csv")
    table["day"] = np.repeat([1, 2], 300)
    table.to_csv(folder / "t.csv", index=False)
    mapping = yaml.safe_load((folder / "map.yaml").read_text()) | {"session": {"column": "day"}}
    began = {}
    for between in ("unknown", "held"):
        (folder / "map.yaml").write_text(yaml.safe_dump(mapping | {"between_sessions": between}))
        run = labrig.import_table(folder / "map.yaml", folder / f"run-{between}")
        began[between] = prepared(rows_from(run), Model.load(folder / "model.yaml")).began
    assert began["held"] is None
    decays = began["unknown"]
    assert decays.shape == (600, 6)  # of 1, 4 and 16 samples
    assert decays[[0, 300]] == pytest.approx(np.repeat(np.eye(2), 3, axis=1))
    assert decays[4, :3] == pytest.approx(np.exp([-4, -1, -0.25]))
