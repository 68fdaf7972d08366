"""Prior spectra: a space's covariance is the learnt one of its own features, or says only what its weights say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrig.diagnosis._directions import directions
from labrig.diagnosis._layout import LEAST_SHARE, Layout
from labrig.diagnosis._observations import observe
from labrig.diagnosis._problem import prepared, rows_from
from labrig.diagnosis._spectra import factor, features_of, prior_of, unlearnt
from labrig.effects._family import Space, field, pattern, pressure

ROWS, OBSERVABLES, CHAMBERS = 4, 3, 2


def lag(name: str, weight: float = 1.0):
    """A pressure feature of two chambers."""
    return pressure(name, np.ones((ROWS, CHAMBERS)), weight)


def shift(name: str, weight: float = 1.0):
    """A field feature."""
    return field(name, np.ones((ROWS, OBSERVABLES)), weight)


def free(name: str, weight: float = 1.0):
    """A pattern feature."""
    return pattern(name, np.ones(ROWS), weight)


SPACE = Space("here", "creep", (lag("fast"), shift("up"), lag("slow", 0.5), free("level", 2.0)), alike=0.7)


def test_features_are_in_the_order_of_their_blocks() -> None:
    """Pressures first, then fields, each as the space has them."""
    assert features_of(SPACE, "shared") == ["fast", "slow", "up"]
    assert features_of(SPACE, "own") == ["fast", "slow"]
    assert features_of(SPACE, "pattern") == ["level"]


def test_what_was_learnt_is_found_by_name() -> None:
    """Each block is the sub-covariance of the features that there are; one that was not learnt about varies as its
    weight says beside those of the block that were.
    """
    C = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])
    spectra = {
        "creep": {
            "shared": {"features": ["slow", "elsewhere", "fast"], "covariance": C.tolist()},
            "own": {"features": ["slow"], "covariance": [[0.3]]},
        }
    }
    prior = prior_of(SPACE, spectra)
    new = (2.0 + 4.0) / (0.7 + 0.35)
    assert prior.shared == pytest.approx(np.array([[2.0, 0.5, 0.0], [0.5, 4.0, 0.0], [0.0, 0.0, new]]))
    assert prior.own == pytest.approx(np.diag([0.3 * 0.3 / 0.15, 0.3]))
    assert prior.pattern == pytest.approx(np.zeros((1, 1)))


@pytest.mark.parametrize(
    "spectra",
    [{}, {"leak": {}}, {"creep": {"shared": {"features": ["elsewhere"], "covariance": [[1.0]]}}}],
)
def test_where_nothing_was_learnt_the_weights_say_it(spectra: dict) -> None:
    """Pressures are alike in all chambers by the space's share, and differ by the rest; all else has its weight."""
    prior = prior_of(SPACE, spectra)
    assert prior.shared == pytest.approx(np.diag([0.7, 0.35, 1.0]))
    assert prior.own == pytest.approx(np.diag([0.3, 0.15]))
    assert prior.pattern == pytest.approx(np.diag([2.0]))


def test_one_chamber_is_alike_with_itself() -> None:
    """With a single chamber nothing is left to differ."""
    prior = unlearnt(Space("here", "creep", (pressure("fast", np.ones((ROWS, 1))),), alike=0.4))
    assert prior.shared == pytest.approx(np.eye(1))
    assert prior.own == pytest.approx(np.zeros((1, 1)))


@given(st.integers(0, 1000), st.integers(1, 6))
@settings(max_examples=30)
def test_a_factor_gives_the_covariance_back(seed: int, rank: int) -> None:
    """L L' is the covariance, with no more columns than it has directions; of zeros there are none."""
    A = np.random.default_rng(seed).normal(size=(6, rank))
    L = factor(A @ A.T, tolerance=1e-12)
    assert L.shape[1] <= rank
    assert pytest.approx(A @ A.T, abs=1e-6) == L @ L.T
    assert factor(np.zeros((3, 3))).shape == (3, 0)


@pytest.mark.parametrize("markers", [1, 6])
def test_pressures_are_whitened_as_pressures(make_lab, markers: int) -> None:
    """Columns of changes of pressures span with the same weights what the rows of all observables give, one by one, but
    for the share that may be left out.
    """
    lab = make_lab(captures=10, markers=markers, repeats=False)
    model = lab.model()
    ready = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), model)
    observations = observe(ready.context, ready.residual, ready.floor)
    effects = [model.library()[name] for name in ("hysteresis", "coupling", "regulator")]
    spaces = [
        s for e in effects for s in e.family(ready.context) if all(f.kind == "pressure" for f in s.features)
    ]
    assert len(spaces) >= 3
    layout = Layout(observations, directions(observations, spaces)[0])
    for space in spaces:
        raw = layout.raw(space, layout.every)
        lifted = layout.lift(raw)
        axes = layout.axes(space, float((raw.astype(float) ** 2).sum()), lifted.reshape(-1, lifted.shape[2]))
        pressures = layout.through_pressures(space)
        assert axes is not None
        assert pressures is not None
        quick = np.zeros((lifted.shape[0] * lifted.shape[1], pressures.shape[2]))
        moved = layout.moves[observations.capture[: len(pressures)]] @ pressures
        quick[: len(moved) * lifted.shape[1]] = moved.reshape(
            -1, pressures.shape[2]
        )  # within holds it is nothing
        slow = (lifted @ axes).reshape(len(quick), -1)
        wanted = slow @ slow.T
        other = np.linalg.norm(quick @ quick.T - wanted, "nuc") / np.trace(wanted)
        assert other < 4 * LEAST_SHARE  # of what all do alike, and each by itself; the rest is as much larger
