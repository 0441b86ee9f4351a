"""Tasks on other processes: every one is done once, what goes wrong is told, and nobody is left behind."""

import multiprocessing
import os
import signal
import time

import pytest

from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.work.workers import workers


@pytest.fixture(autouse=True)
def nobody_is_left_behind():
    """Whatever happens, no process of a test's outlives it."""
    before = set(multiprocessing.active_children())
    yield
    assert not set(multiprocessing.active_children()) - before


def test_every_task_is_done_once_elsewhere():
    with workers(2) as crew:
        for k in range(5):
            crew.submit(str(k), pow, k, 2)
        crew.submit("pid", os.getpid)
        found = dict(crew.done() for _ in range(6))
    assert found.pop("pid") != os.getpid()
    assert found == {str(k): k * k for k in range(5)}


def first_of(task, *given):
    with workers(1) as crew:
        crew.submit("a", task, *given)
        return crew.done()


def test_what_a_task_raises_is_raised_here():
    with pytest.raises(BadInput, match="field"):
        first_of(_refuse)


def _refuse():
    raise BadInput("field", 1, "2")


def test_a_worker_that_is_killed_is_told():
    with pytest.raises(GaitsmithError, match="killed"):
        first_of(_die)


def _die():
    os.kill(os.getpid(), signal.SIGKILL)


def test_leaving_early_ends_what_runs():
    with pytest.raises(KeyboardInterrupt):
        leave()


def leave():
    with workers(1) as crew:
        crew.submit("a", time.sleep, 600.0)
        raise KeyboardInterrupt


@pytest.mark.parametrize(("jobs", "address"), [(0, ""), (257, ""), (1, "here"), (1, "127.0.0.1:99999"), (1, ":1")])
def test_numbers_and_addresses_that_cannot_be(jobs, address):
    with pytest.raises(BadInput), workers(jobs, address):
        pass
