"""One thread for small banded matrices: more would wait for each other, most of all where processes share cores."""

from contextlib import AbstractContextManager
from functools import cache

from threadpoolctl import ThreadpoolController


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()


def one_thread() -> AbstractContextManager:
    """Within it, linear algebra runs on one thread."""
    return _controller().limit(limits=1, user_api="blas")
