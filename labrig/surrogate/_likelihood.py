"""The kernel's parameters by maximum marginal likelihood, with exact gradients, on the leading modes."""

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs  # pyright: ignore[reportAttributeAccessIssue]
from scipy.optimize import minimize

from labrig.arrays import Floats
from labrig.surrogate._kernel import Kernel

_START = (np.log(0.7), np.log(2.0), np.log(0.5))
_BOUNDS = ((np.log(0.05), np.log(30.0)), (np.log(1e-2), np.log(300.0)), (np.log(1e-3), np.log(1e3)))
_NOISE_START, _NOISE_BOUNDS = np.log(1e-4), (np.log(1e-9), np.log(1e-1))


def fit_kernel(x: Floats, targets: Floats, iterations: int = 40) -> tuple[Kernel, float]:
    """Fit the kernel to targets (n, K), each of zero mean and unit variance, at fractions x (n, C).

    All targets share the kernel and have a variance of their own. Returns the kernel and its noise, the
    variance of what it can't explain relative to what it can.
    """
    C = x.shape[1]
    objective = _Objective(x, targets)
    start = np.concatenate([np.repeat(_START, C), [_NOISE_START]])
    bounds = [b for b in _BOUNDS for _ in range(C)] + [_NOISE_BOUNDS]
    found = minimize(
        objective, start, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": iterations}
    )
    length, bend, share = np.exp(found.x[:-1]).reshape(3, C)
    return Kernel(length, bend, share), float(np.exp(found.x[-1]))


class _Objective:
    """Negative log marginal likelihood and its gradient by the logarithms of the parameters."""

    def __init__(self, x: Floats, targets: Floats) -> None:
        self._x, self._targets = x, targets
        self._i, self._j = np.triu_indices(len(x), 1)

    def __call__(self, theta: Floats) -> tuple[float, Floats]:
        n, C = self._x.shape
        length, bend, share = np.exp(theta[:-1]).reshape(3, C)
        noise = np.exp(theta[-1])
        t = np.log1p(bend * self._x) / np.log1p(bend)
        steps, bells = [], []
        packed = np.ones(len(self._i))
        for c in range(C):
            step = (t[self._i, c] - t[self._j, c]) / length[c]
            bell = np.exp(-0.5 * step * step)
            packed *= (1.0 + share[c] * bell) / (1.0 + share[c])
            steps.append(step)
            bells.append(bell)
        K = np.zeros((n, n), order="F")
        K[self._i, self._j] = packed
        K[np.diag_indices(n)] = 1.0 + noise
        factor, failed = dpotrf(K, lower=0, overwrite_a=1)
        if failed:
            return 1e10, np.zeros_like(theta)
        alpha, _ = dpotrs(factor, self._targets, lower=0)
        scale = np.maximum((self._targets * alpha).sum(axis=0) / n, 1e-12)
        value = 0.5 * n * float(np.log(scale).mean()) + float(np.log(np.diagonal(factor)).sum())
        inverse, _ = dpotri(factor, lower=0, overwrite_c=1)
        weighted = alpha / scale / alpha.shape[1]
        # twice the upper triangle: the matrix is symmetric, and only one half of it is stored
        outer = weighted @ alpha.T
        by_K = (inverse[self._i, self._j] - outer[self._i, self._j]) * packed
        gradient = np.empty_like(theta)
        for c in range(C):
            step, bell = steps[c], bells[c]
            plus = 1.0 + share[c] * bell
            by_bell = by_K * (share[c] * bell / plus)
            pull = by_bell * step
            gradient[c] = np.dot(pull, step)
            bent = self._bent_slope(bend[c], self._x[:, c], t[:, c])
            gradient[C + c] = -np.dot(pull, bent[self._i] - bent[self._j]) / length[c]
            gradient[2 * C + c] = by_bell.sum() - by_K.sum() * share[c] / (1.0 + share[c])
        gradient[-1] = 0.5 * noise * float((np.diagonal(inverse) - np.diagonal(outer)).sum())
        return value, gradient

    @staticmethod
    def _bent_slope(bend: float, x: Floats, t: Floats) -> Floats:
        """The derivative of the bent coordinate by the logarithm of the bend."""
        whole = np.log1p(bend)
        return bend * (x / (1.0 + bend * x) - t / (1.0 + bend)) / whole
