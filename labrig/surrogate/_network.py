"""Neural networks as plain arrays: evaluated, and differentiated forward, without the library that trained them."""

from dataclasses import dataclass

import numpy as np
from scipy.special import erf

from labrig.arrays import Floats

_ROOT_HALF = 0.7071067811865476
_DENSITY = 0.3989422804014327


@dataclass(frozen=True)
class Network:
    """Layers x -> activation(W x + b), the last one without activation where `linear_end` is true.

    `layers` holds (W (out, in), b (out,)) of each; `activation` is `relu` or `gelu`.
    """

    layers: tuple[tuple[Floats, Floats], ...]
    activation: str
    linear_end: bool = True

    def value(self, x: Floats) -> Floats:
        """Outputs (F, out) for inputs (F, in)."""
        for index, (weight, bias) in enumerate(self.layers):
            x = x @ weight.T + bias
            if not self._is_linear(index):
                x = self._activate(x)
        return x

    def slopes(self, x: Floats, by: Floats | None = None) -> tuple[Floats, Floats]:
        """Outputs (F, out) and their derivatives (F, out, C) along `by` (F, in, C); by the inputs without it."""
        change = np.broadcast_to(np.eye(x.shape[1]), (len(x), x.shape[1], x.shape[1])) if by is None else by
        for index, (weight, bias) in enumerate(self.layers):
            x = x @ weight.T + bias
            change = weight @ change
            if not self._is_linear(index):
                change = change * self._slope(x)[:, :, None]
                x = self._activate(x)
        return x, change

    def _is_linear(self, index: int) -> bool:
        return self.linear_end and index == len(self.layers) - 1

    def _activate(self, x: Floats) -> Floats:
        if self.activation == "relu":
            return np.maximum(x, 0.0)
        return 0.5 * x * (1.0 + erf(_ROOT_HALF * x))

    def _slope(self, x: Floats) -> Floats:
        if self.activation == "relu":
            return (x > 0).astype(float)
        return 0.5 * (1.0 + erf(_ROOT_HALF * x)) + x * np.exp(-0.5 * x * x) * _DENSITY


@dataclass(frozen=True)
class NetworkHead:
    """Latent coordinates z (K) of fractions x (C) of the range: the mean of an ensemble's outputs, scaled."""

    kind = "network"

    members: tuple[Network, ...]
    scale: float = 1.0

    def latent(self, x: Floats) -> Floats:
        """z (F, K) at fractions x (F, C)."""
        return self.scale * np.mean([member.value(x) for member in self.members], axis=0)

    def slopes(self, x: Floats) -> Floats:
        """dz/dx (F, K, C) at fractions x (F, C)."""
        return self.scale * np.mean([member.slopes(x)[1] for member in self.members], axis=0)

    def doubt(self, x: Floats) -> Floats:
        """How far the members are apart (F,), root mean square over z; one where there is only one member."""
        if len(self.members) < 2:
            return np.ones(len(x))
        values = np.array([member.value(x) for member in self.members])
        return self.scale * np.sqrt((values.std(axis=0, ddof=1) ** 2).sum(axis=-1) + 1e-12)
