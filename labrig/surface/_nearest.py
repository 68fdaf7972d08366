"""Nearest points of a cloud: small_gicp's tree where it is installed, scipy's where it is not; the same answers."""

from functools import cache
from types import ModuleType

import numpy as np

from labrig.arrays import Floats, Ints


@cache
def small_gicp() -> ModuleType | None:
    """The library of the `scan` extra, or None."""
    try:
        import small_gicp as library  # pyright: ignore[reportMissingImports]
    except ImportError:
        return None
    return library


class Nearest:
    """A tree over points (N, 3); `library` is False to do without small_gicp."""

    def __init__(self, points: Floats, library: bool = True) -> None:
        self.points = np.ascontiguousarray(points, dtype=np.float64)
        gicp = small_gicp() if library else None
        if gicp is not None:
            self._gicp, self._scipy = gicp.KdTree(self.points), None
        else:
            from scipy.spatial import KDTree

            # an unbalanced tree is made in half the time and is as quick to ask
            self._gicp, self._scipy = None, KDTree(self.points, balanced_tree=False, compact_nodes=False)

    def one(self, points: Floats) -> tuple[Ints, Floats]:
        """The nearest point's index (P,) and squared distance (P,)."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        if self._gicp is not None:
            index, square = self._gicp.batch_nearest_neighbor_search(points)
            return np.asarray(index, np.int64), np.asarray(square, float)
        assert self._scipy is not None
        distance, index = self._scipy.query(points)
        return np.asarray(index, np.int64), np.asarray(distance, float) ** 2

    def several(self, points: Floats, count: int) -> Ints:
        """The `count` nearest points' indices, (P, count)."""
        count = min(count, len(self.points))
        points = np.ascontiguousarray(points, dtype=np.float64)
        if self._gicp is not None:
            index = np.asarray(self._gicp.batch_knn_search(points, count)[0], np.int64)
        else:
            assert self._scipy is not None
            index = np.asarray(self._scipy.query(points, k=count)[1], np.int64)
        return index.reshape(len(points), count)
