"""What measured numbers say about which of several explanations is true.

Each explanation expects a Gaussian (`Outlook`), or one for each of its forms. The mutual information between the
numbers and the explanation is estimated from the distances between all pairs of Gaussians (A. Kolchinsky, B. Tracey,
Entropy 19 (2017) 361). How the odds will change is drawn instead, and its median taken: where one explanation is far
less sure of what comes than the other, few draws make most of the mean.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from labrig.arrays import Floats, Ints
from labrig.diagnosis import Outlook

_DRAWS = 200


def information(outlook: Outlook, probability: Floats, explanation: Ints) -> float:
    """What the numbers say about the explanation, nats, from 0 to its entropy.

    By Bhattacharyya distances: where every explanation has one form, it is never too much.

    `probability` (M,) of each form, all together one; `explanation` (M,) is the one that each belongs to.
    """
    near = np.exp(-bhattacharyya(outlook))
    same = explanation[:, None] == explanation
    likely = probability > 0  # each is 1 to itself: no sum of theirs vanishes
    together = np.log((near @ probability)[likely])
    alone = np.log(((near * same) @ probability)[likely]) - np.log((same @ probability)[likely])
    return max(float(probability[likely] @ (alone - together)), 0.0)


def log_bayes(outlook: Outlook, probability: Floats, explanation: Ints) -> Floats:
    """The median logarithm of the Bayes factor for each explanation that is true, over each other one, (R, R)."""
    mean, C = _gaussians(outlook)
    L = np.linalg.cholesky(C)
    logdet = _half_log_determinant(L)
    random = np.random.default_rng(len(mean))
    count = int(explanation.max()) + 1
    share = [
        np.where(explanation == e, probability, 0.0) / probability[explanation == e].sum()
        for e in range(count)
    ]
    out = np.zeros((count, count))
    for true in range(count):
        form = random.choice(len(mean), size=_DRAWS, p=share[true])
        y = mean[form] + np.einsum("nij,nj->ni", L[form], random.standard_normal((_DRAWS, mean.shape[1])))
        z = np.linalg.solve(L, (y - mean[:, None]).swapaxes(1, 2))
        each = -0.5 * (z**2).sum(axis=1) - logdet[:, None]
        likely = np.array([logsumexp(each, b=s[:, None], axis=0) for s in share])
        out[true] = np.median(likely[true] - likely, axis=1)
    return out


def bhattacharyya(outlook: Outlook) -> Floats:
    """The Bhattacharyya distance between each two Gaussians, (M, M).

    The Cholesky factor of a covariance with the difference of the means below it, and a number in the corner, has the
    determinant of the one on its diagonal, and in the corner what that number is more than the Mahalanobis distance.
    """
    mean, C = _gaussians(outlook)
    half = _half_log_determinant(np.linalg.cholesky(C))
    count, d = mean.shape
    out = np.zeros((count, count))
    bordered = np.empty((count, d + 1, d + 1))
    C = C / 2
    for m in range(count - 1):
        others, each = slice(m + 1, None), bordered[m + 1 :]
        apart = mean[m] - mean[others]
        corner = 1 + (apart**2).sum(axis=1)  # noise is of unit size, so that the distance is less
        np.add(C[m], C[others], out=each[:, :d, :d])
        each[:, d, :d], each[:, d, d] = apart, corner  # what stands above the diagonal is not read
        L = np.linalg.cholesky(each)
        between = (corner - L[:, d, d] ** 2) / 8 + _half_log_determinant(L[:, :d, :d])
        out[m, others] = between - (half[m] + half[others]) / 2
    out += out.T
    return np.maximum(out, 0.0)


def _half_log_determinant(L: NDArray[np.floating]) -> Floats:
    """Half the logarithm of the determinant (M,) of L L' (M, d, d)."""
    return np.log(np.diagonal(L, axis1=1, axis2=2)).sum(axis=1)


def _gaussians(outlook: Outlook) -> tuple[Floats, Floats]:
    """Means (M, d) and covariances (M, d, d), in units of the noise of numbers that count for their worth."""
    covariance = outlook.worth * outlook.covariance + np.eye(outlook.mean.shape[1])
    return np.sqrt(outlook.worth) * outlook.mean, covariance
