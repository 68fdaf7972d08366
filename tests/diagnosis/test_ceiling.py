"""What a flexible learner predicts of captures that took no part in learning."""

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._ceiling import STATIC, _heldout, covariates, kernel


@pytest.mark.parametrize("every", [1, 2])
def test_each_block_is_predicted_by_what_was_learnt_without_it(make_lab, every: int) -> None:
    """The short way, from one inverse, gives what learning anew for each block does; also from some rows only."""
    lab = make_lab(captures=40, markers=4, chambers=2)
    ready = prepared(rows_from(lab.dataset(lab.predict(0.9 * lab.u) + lab.noise())), lab.model())
    regression, context = ready.regression, ready.context
    rows = np.arange(0, len(context.base), every)
    features = covariates(context)[STATIC]
    K, ridge = kernel(features, features[rows]), 0.1
    target = np.random.default_rng(0).normal(size=(len(context.base), 3))
    found = _heldout(regression, K, ridge, target, rows)
    assert regression.n_groups > 5
    for g in range(regression.n_groups):
        own, train = regression.row_group == g, regression.row_group[rows] != g
        gram = K[rows][np.ix_(train, train)] + ridge * np.eye(train.sum())
        assert found[own] == pytest.approx(K[own][:, train] @ np.linalg.solve(gram, target[rows[train]]))
