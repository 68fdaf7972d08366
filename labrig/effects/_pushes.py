"""Obstacles of any form: what pushes a marker away goes with the place that it would be at, whatever stands there."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Space, acting, field
from labrig.effects._obstacles import Places, to_rows

_WIDE = (0.12, 0.3)
"""How wide the bells are, shares of the farthest way: grids, no limits of a verdict."""
_SPOTS, _CAPTURES, _BEST = 300, 100, 8
"""How many places are looked at, on how many captures, and how many places are taken."""
_AWAY = 0.2
"""Share of the farthest way from which a marker may meet something: nothing stands where the body rests."""


def pushes(context: Context) -> Iterator[Space]:
    """Bells about the places where the residuals speak for a push, each along x, y and z.

    Places that markers would be at are chosen one after the other (orthogonal matching pursuit, one bell at a time).
    What stands there does no work: it may turn markers aside, but as a whole it holds them back.
    """
    rows = context.rows
    if (rows.axis >= 0).sum() < 3 or not (rows.marker >= 0).any():
        return
    places = Places(context)
    far = float(places.length.max())
    away = places.length > _AWAY * far
    # in an order of their pressures: the same, whatever came first
    order = np.lexsort(rows.actuation[places.first].T)
    some = order[:: max(1, len(order) // _CAPTURES)]
    here, out, left = places.here[places.first[some]], away[places.first[some]], places.left[some]
    spots = here[out]
    if far <= 0 or len(spots) < _BEST:
        return
    spots = spots[:: max(1, len(spots) // _SPOTS)]
    for share in _WIDE:
        bells = np.stack([_bell(here, spot, share * far) * out for spot in spots])
        features = [
            field(
                f"{n} along {letter}", to_rows(context, (bell * away)[..., None] * 0.1 * far * np.eye(3)[a])
            )
            for n, i in enumerate(_clearest(bells, left))
            for bell in [_bell(places.here, spots[i], share * far)]
            for a, letter in enumerate("xyz")
        ]
        key, back = f"pushes {share}", field("back", to_rows(context, -places.move * away[..., None]))
        yield Space(key, "contact pushes", acting(features), scanned=len(spots), along=back)


def _bell(here: Floats, spot: Floats, wide_mm: float) -> Floats:
    """A bell of places (n, M, 3) about one, (n, M)."""
    return np.exp(-((here - spot) ** 2).sum(axis=2) / (2 * wide_mm**2))


def _clearest(bells: Floats, left: Floats) -> list[int]:
    """Which bells (B, n, M) take most of what is left (n, M, 3), one after the other."""
    flat = bells.reshape(len(bells), -1)
    power, rest, chosen = np.maximum((flat**2).sum(axis=1), 1e-9), left.reshape(-1, 3).copy(), []
    for _ in range(_BEST):
        along = flat @ rest
        best = int(np.argmax((along**2).sum(axis=1) / power))
        rest -= np.outer(flat[best], along[best] / power[best])
        chosen.append(best)
    return list(dict.fromkeys(chosen))
