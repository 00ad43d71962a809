"""Where runs happen: in this process, in worker processes, or on a dask cluster."""

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class SerialExecutor(Executor):
    """Runs each call at once, in the calling thread, so that Ctrl-C reaches it."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Call ``fn`` and return its finished future."""
        future: Future[T] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def process_executor(jobs: int) -> Iterator[Executor]:
    """Give an executor of ``jobs`` single-threaded processes; leaving by an exception ends them at once."""
    before = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")  # forked children would inherit locks of other threads
    with _single_threaded_children():
        executor = ProcessPoolExecutor(jobs, mp_context=context, initializer=_start_worker)
        try:
            yield executor
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            for child in set(multiprocessing.active_children()) - before:
                child.kill()
                child.join()
            raise
        finally:
            executor.shutdown()


@contextmanager
def dask_executor(address: str) -> Iterator[Executor]:
    """Give an executor on an existing dask cluster.

    Raises
    ------
    ValueError
        When dask is not installed.
    OSError
        When no scheduler answers at the address.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise ValueError("--dask: needs the extra 'cluster': pip install 'cutgap[cluster]'") from error
    with Client(address, timeout="10s", set_as_default=False) as client:  # type: ignore[no-untyped-call]
        yield client.get_executor()


def _start_worker() -> None:
    """Leave Ctrl-C, which the terminal sends to every process, to the parent; end when the parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = os.getppid()

    def watch_parent() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch_parent, daemon=True).start()


@contextmanager
def _single_threaded_children() -> Iterator[None]:
    """Set the environment that spawned processes read when they load their libraries."""
    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
