"""Where heavy work runs: this process, processes of this computer, or a Dask cluster; the same calls for all.

A task that loses its worker (killed, out of memory, unplugged) is done again elsewhere. Functions and tasks must be
picklable; processes are spawned, as on Windows, so functions must be importable by name.
"""

import os
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import current_process, get_context, parent_process
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from labrig._errors import LabrigError
from labrig._extras import missing

ATTEMPTS = 3
"""How often a task may lose its worker before the work is given up."""
GUARD = '`if __name__ == "__main__":`'
_OWN = ("labrig", "__main__")
"""What a script is called that is labrig's own."""
_CONNECT_S = 10


class Executor:
    """Runs a function on many tasks; a context manager.

    `workers` processes of this computer (0: as many as it has cores; 1: this very process), or the workers of the
    Dask `cluster` at an address such as tcp://host:8786. Raises `LabrigError` if the cluster cannot be reached.
    """

    def __init__(self, workers: int = 0, cluster: str | None = None) -> None:
        if workers < 0:
            raise LabrigError(f"--workers {workers}: a number of processes, or 0 for one per core")
        self.workers = workers or os.cpu_count() or 1
        self.cluster = cluster
        self._pool: ProcessPoolExecutor | None = None
        self._client: Any = _connect(cluster) if cluster else None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of all workers; what has not begun is not done."""
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None
        if self._client is not None:
            self._client.close()
            self._client = None

    def map(self, function: Callable[[Any], Any], tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """(number of the task, what `function(task)` returned), in the order in which they come to an end.

        An exception of the function is raised here. Raises `LabrigError` for a task that lost its worker too often.
        """
        if self._client is not None:
            return self._on_cluster(function, tasks)
        if self.workers == 1 or len(tasks) <= 1:
            return ((k, function(task)) for k, task in enumerate(tasks))
        return self._in_processes(function, tasks)

    def _in_processes(
        self, function: Callable[[Any], Any], tasks: Sequence[Any]
    ) -> Iterator[tuple[int, Any]]:
        left = dict.fromkeys(range(len(tasks)), 0)
        while left:
            if self._pool is None:
                self._pool = spawned(self.workers)
            futures: dict[Future, int] = {}
            try:
                futures = {self._pool.submit(function, tasks[k]): k for k in left}
                for future in as_completed(futures):
                    result = future.result()
                    del left[futures[future]]
                    yield futures[future], result
            except BrokenProcessPool:
                self._pool.shutdown(wait=True, cancel_futures=True)
                self._pool = None
                done = [future for future in futures if future.done() and future.exception() is None]
                for future in done:
                    if (k := futures[future]) in left:
                        del left[k]
                        yield k, future.result()
                for k in list(left)[: self.workers]:
                    left[k] += 1
                    _give_up_after(left[k], k)
            except BaseException:
                for future in futures:
                    future.cancel()
                raise

    def _on_cluster(self, function: Callable[[Any], Any], tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        from distributed import KilledWorker
        from distributed import as_completed as dask_completed

        futures = {
            self._client.submit(function, task, pure=False, retries=0): k for k, task in enumerate(tasks)
        }
        try:
            for future in dask_completed(list(futures), loop=self._client.loop):
                try:
                    result = future.result()
                except KilledWorker:
                    raise _lost(futures[future]) from None
                yield futures[future], result
        finally:
            self._client.cancel(list(futures))


def spawned(workers: int) -> ProcessPoolExecutor:
    """Processes for calls; they end with the one that asked for them, also where that is killed.

    Each reads the script that is run, once more, so a script has to keep what it does behind `GUARD`.
    """
    reads_the_script = getattr(current_process(), "_inheriting", False)
    if reads_the_script:  # a worker that asks for workers, which would ask for more
        raise SystemExit(
            f"labrig: several processes need {GUARD} around what a script does: each reads it anew"
        )
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_end_with_parent)


def _end_with_parent() -> None:
    def end() -> None:
        if (parent := parent_process()) is not None:
            parent.join()
            os._exit(1)  # nothing to put away: nobody waits for the result

    threading.Thread(target=end, name="labrig parent", daemon=True).start()


def _give_up_after(attempts: int, task: int) -> None:
    if attempts >= ATTEMPTS:
        raise _lost(task)


def _lost(task: int) -> LabrigError:
    script = Path(getattr(sys.modules["__main__"], "__file__", None) or "labrig")
    begun_anew = f", or no {GUARD} around what {script.name} does" if script.stem not in _OWN else ""
    return LabrigError(
        f"the work was given up: task {task} lost its worker again and again (killed, or out of memory"
        f"{begun_anew}?); what is done is kept"
    )


def _connect(address: str) -> Any:
    """A Dask client; raises `LabrigError` if there is no Dask, or nothing at the address."""
    try:
        from distributed import Client
    except ImportError:
        raise missing("--cluster", "cluster") from None
    try:
        return Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise LabrigError(
            f"--cluster {address}: no Dask scheduler answers there ({type(error).__name__})"
        ) from None
