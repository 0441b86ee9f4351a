"""Settings of every test: one thread, one folder for compiled kernels, repeatable random examples."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("GAITSMITH_CACHE_DIR", str(Path(__file__).resolve().parent.parent / "build" / "kernels"))
os.environ.setdefault("MPLBACKEND", "Agg")

import pytest
from hypothesis import HealthCheck, settings

# A kernel's first call compiles for seconds, so no deadline; the same examples every time, so a failure is a change.
settings.register_profile(
    "gaitsmith", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow], database=None
)
settings.register_profile("explore", settings.get_profile("gaitsmith"), derandomize=False, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gaitsmith"))
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job begins with Ctrl-C ignored


@pytest.fixture(autouse=True)
def signals_as_they_were() -> Iterator[None]:
    """What a test does to signals ends with it: processes that another one starts would inherit what is ignored."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = [signal.getsignal(number) for number in numbers]
    yield
    for number, handler in zip(numbers, before, strict=True):
        signal.signal(number, handler)
