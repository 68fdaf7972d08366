"""Effects that can stand in for each other: one of them is named or doubted, and nothing is never all there is."""

import numpy as np
import pytest

from labrig.diagnosis import SURE, Calibration, _verdict, diagnose
from labrig.diagnosis._answers import Answer, Size
from labrig.diagnosis._verdict import decide
from labrig.effects import get, rows_of
from labrig.model import Model
from tests.naming import verdict_of

ARM = """
import numpy as np

ALONG_MM = np.array([30.0, 60.0, 90.0, 120.0])
TOWARDS = np.deg2rad([90.0, 210.0, 330.0])


def predict(u):
    bend = 2e-4 * np.stack([u @ np.cos(TOWARDS), u @ np.sin(TOWARDS)], axis=-1)
    size = np.maximum(np.linalg.norm(bend, axis=-1), 1e-9)[..., None]
    way, turn = bend / size, size * ALONG_MM
    aside, down = (1 - np.cos(turn)) / size, -np.sin(turn) / size
    return np.stack([aside * way[..., :1], aside * way[..., 1:], down], axis=-1).reshape(*u.shape[:-1], 12)
"""


def test_a_sag_that_two_effects_make_is_one_of_both(make_lab) -> None:
    """An arm that sags by 3 mm, as a cantilever does and more under pressure: gravity or another shape at rest."""
    lab = make_lab(chambers=3, markers=4, captures=60, rows_s=(3.0, 4.0))
    lab.model()
    (lab.folder / "base.py").write_text(ARM)
    content: dict = {}
    exec(ARM, content)  # the arm itself, as its file has it
    lab.rest_mm[:] = content["predict"](np.zeros((1, 3))).reshape(4, 3)
    place = content["predict"](lab.u)
    place[..., ::3] += 3.0 * (np.arange(1, 5) / 4) ** 3 * (1 + 0.3 * lab.u.sum(axis=2, keepdims=True) / 180)
    found = verdict_of(lab.dataset(place + lab.noise()), Model.load(lab.folder / "model.yaml"))
    assert found.verdict in {"identified", "confounded"}
    assert {*found.effects, *found.rivals} & {"gravity", "rest_shape"}


def test_a_tip_that_is_off_beside_places_that_are_held_is_no_gravity_alone(make_lab) -> None:
    """A marker glued elsewhere on a tip that moves, two that are fixed: another rest shape, or gravity; neither is sure
    where the poses do not tell, and the formula of either takes it off.
    """
    lab = make_lab(chambers=3, markers=3, captures=60, rows_s=(3.0, 4.0, 5.0), repeats=False)
    lab.reach[:6] *= 0.0
    data = lab.dataset(lab.predict(lab.u) + np.r_[np.zeros(6), 1.2, 0.5, -0.3] + lab.noise(0.3, 0.0))
    data = data.drop_vars("rest_mm")  # nobody says where the markers are at rest
    summary = diagnose(data, lab.model()).summary
    calls = {c["effect"]: c["call"] for c in summary["effects_considered"]}
    assert calls["gravity"] != "sure"
    assert calls["rest_shape"] in {"possible", "sure"}
    assert summary["error"]["model"] < 1.2 * summary["error"]["floor"]
    forms = {v.form for v in get("gravity").variants(lab.model().context(rows_of(data)))}
    assert "own weight along x" in forms


@pytest.mark.parametrize(("beside", "verdict"), [(2.3, "confounded"), (1.7, "identified")])
def test_the_probability_is_that_of_these_effects_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch, beside: float, verdict: str
) -> None:
    """Creep is there for sure; a leak beside it, probably or not: whichever is more probable is the verdict."""
    monkeypatch.setattr(_verdict, "shipped", lambda: Calibration(0.0, 1.0, 0.0, {}))
    sizes = {"creep": Size(5.0, 0.5, 5.0), "leak": Size(beside, 0.5, beside)}
    answer = Answer(1.0, sizes, {}, 2.0)
    creep, leak = answer.worth("creep"), answer.worth("leak")
    assert (0.5 < leak < SURE) if verdict == "confounded" else (0.1 < leak < 0.5)
    found = decide([answer], ("creep", "leak"), {})
    assert (found.verdict, found.effects) == (verdict, ("creep",))
    assert found.rivals == (("leak",) if verdict == "confounded" else ())
    alone = creep * (1 - leak)
    assert found.probability == pytest.approx(leak if verdict == "confounded" else alone, abs=2e-3)
