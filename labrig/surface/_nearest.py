"""Nearest points of a cloud."""

import numpy as np

from labrig.arrays import Floats, Ints


class Nearest:
    """A tree over points (N, 3)."""

    def __init__(self, points: Floats) -> None:
        from scipy.spatial import KDTree

        self.points = np.ascontiguousarray(points, dtype=np.float64)
        # an unbalanced tree is made in half the time and is as quick to ask
        self._tree = KDTree(self.points, balanced_tree=False, compact_nodes=False)

    def one(self, points: Floats) -> tuple[Ints, Floats]:
        """The nearest point's index (P,) and squared distance (P,)."""
        distance, index = self._tree.query(points)
        return np.asarray(index, np.int64), np.asarray(distance, float) ** 2

    def several(self, points: Floats, count: int) -> Ints:
        """The `count` nearest points' indices, (P, count)."""
        count = min(count, len(self.points))
        index = np.asarray(self._tree.query(points, k=count)[1], np.int64)
        return index.reshape(len(points), count)
