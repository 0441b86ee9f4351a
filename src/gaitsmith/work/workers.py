"""Tasks done on other processes: of this machine, or of a Ray cluster."""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Protocol

from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.files import uninterrupted

MOST_JOBS = 256
_KILLED = "a worker process was killed; finished work is kept, run again with fewer jobs"
_LOOK = 0.5  # s between two looks of a worker whether its master is still there
_REACH = 3.0  # s in which a cluster has to answer
_AGAIN = 10  # times that a task is given to another node when one dies


class Workers(Protocol):
    """Where tasks are done; tasks and what they are given are importable and picklable."""

    def submit(self, key: str, task: Callable[..., Any], *given: Any) -> None:
        """Let a task be done."""

    def done(self) -> tuple[str, Any]:
        """Key and result of the next task that is finished; what it raised is raised here."""


class _Local:
    """Processes of this machine, each with one thread for its linear algebra."""

    def __init__(self, jobs: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_serve, initargs=(os.getpid(),))
        self._keys: dict[Future[Any], str] = {}

    def submit(self, key: str, task: Callable[..., Any], *given: Any) -> None:
        """Let a task be done."""
        with uninterrupted():  # processes begin here; only this one decides what is finished
            try:
                self._keys[self.pool.submit(task, *given)] = key
            except BrokenProcessPool:
                raise GaitsmithError(_KILLED) from None

    def done(self) -> tuple[str, Any]:
        """Key and result of the next task that is finished."""
        future = next(iter(wait(self._keys, return_when=FIRST_COMPLETED).done))
        key = self._keys.pop(future)
        try:
            return key, future.result()
        except BrokenProcessPool:
            raise GaitsmithError(_KILLED) from None


def _serve(master: int) -> None:
    """Leave Ctrl-C to the master, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def look() -> None:
        while os.getppid() == master:
            time.sleep(_LOOK)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()


class _Ray:
    """Nodes of a cluster; a task whose node dies is done by another one."""

    def __init__(self, ray: Any) -> None:
        self._ray, self._keys = ray, dict[Any, str]()

    def submit(self, key: str, task: Callable[..., Any], *given: Any) -> None:
        """Let a task be done."""
        remote = self._ray.remote(task).options(num_cpus=1, max_retries=_AGAIN)
        self._keys[remote.remote(*given)] = key

    def done(self) -> tuple[str, Any]:
        """Key and result of the next task that is finished."""
        (first, *_), _ = self._ray.wait([*self._keys], num_returns=1)
        key = self._keys.pop(first)
        try:
            return key, self._ray.get(first)
        except self._ray.exceptions.RayTaskError as error:
            raise error.cause from None
        except self._ray.exceptions.RayError as error:
            raise GaitsmithError(f"the cluster lost a task: {str(error).splitlines()[0][:200]}") from None


def address_of(engine: str, address: str | None) -> str:
    """Address of the Ray cluster that ``--engine`` and ``--address`` name; empty for this machine.

    Raises:
        BadInput: one without the other.
    """
    if (engine == "ray") != (address is not None):
        given = "nothing" if address is None else address
        raise BadInput("--address", given, "host:port with --engine ray, nothing without it")
    return address or ""


@contextlib.contextmanager
def workers(jobs: int = 1, address: str = "") -> Iterator[Workers]:
    """Processes to work with.

    Args:
        address: ``host:port`` of a Ray cluster instead; empty for none.

    Raises:
        BadInput: jobs out of range, no package ray, or a cluster that does not answer.
    """
    if not 1 <= jobs <= MOST_JOBS:
        raise BadInput("--jobs", jobs, f"1 to {MOST_JOBS}")
    if address:
        ray = _cluster(address)
        try:
            yield _Ray(ray)
        finally:
            ray.shutdown()
        return
    held = {name: os.environ.get(name) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
    os.environ.update(dict.fromkeys(held, "1"))
    others = set(multiprocessing.active_children())
    local = _Local(jobs)
    try:
        yield local
    except BaseException:
        for process in set(multiprocessing.active_children()) - others:
            process.kill()  # what they do is not wanted any more
        raise
    finally:
        local.pool.shutdown(wait=True, cancel_futures=True)
        for name, value in held.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _cluster(address: str) -> Any:
    """Ray, connected to a cluster."""
    host, _, port = address.rpartition(":")
    valid = "host:port of the head of a Ray cluster"
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise BadInput("--address", address, valid)
    try:
        import ray
    except ImportError:
        raise BadInput("--engine ray", "no package ray", "the extra ray", "pip install 'gaitsmith[ray]'") from None
    try:
        socket.create_connection((host, int(port)), _REACH).close()
    except OSError:
        raise BadInput("--address", address, valid, "nobody answers there: ray start --head") from None
    try:
        ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
    except Exception as error:
        text = str(error).strip().splitlines()[0][:120] if str(error).strip() else type(error).__name__
        raise BadInput("--address", address, valid, text) from None
    return ray
