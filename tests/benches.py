"""Workbenches of one test process compute in the same processes, one workbench after the other.

Each would import the same packages anew, and be ended a few seconds later. What a workbench does with a process of its
own is in tests/workbench/test_worker.py and, where it runs as a command, in tests/watch.
"""

from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager

import pytest

from labrig.workbench import _worker

_CLOSE, _SPAWNED = _worker.Worker.close, _worker.spawned


def unshare(patch: pytest.MonkeyPatch) -> None:
    """From here on a workbench's processes are its own again, as they are outside the tests."""
    patch.setattr(_worker.Worker, "close", _CLOSE)
    patch.setattr(_worker, "spawned", _SPAWNED)


@contextmanager
def shared_processes() -> Iterator[None]:
    """Meanwhile the process of a workbench that ends is kept for the next one."""
    spare: list[ProcessPoolExecutor] = []

    def kept(workers: int) -> ProcessPoolExecutor:
        return spare.pop() if spare else _SPAWNED(workers)

    def close(worker: _worker.Worker) -> None:
        worker._closed = True
        pool, worker._pool = worker._pool, None
        if pool is not None and not pool._broken:
            for waiting in list(pool._pending_work_items.values()):  # what it does now, it does to its end
                Future.cancel(waiting.future)
            spare.append(pool)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_worker, "spawned", kept)
        patch.setattr(_worker.Worker, "close", close)
        yield
    for pool in spare:
        for process in list((pool._processes or {}).values()):
            process.terminate()
        pool.shutdown(wait=True, cancel_futures=True)
