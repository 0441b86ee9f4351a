"""Settings of every test: one thread, one folder for compiled kernels, repeatable random examples."""

import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("GAITSMITH_CACHE_DIR", str(Path(__file__).resolve().parent.parent / "build" / "kernels"))
os.environ.setdefault("MPLBACKEND", "Agg")

from hypothesis import HealthCheck, settings

# A kernel's first call compiles for seconds, so no deadline; the same examples every time, so a failure is a change.
settings.register_profile(
    "gaitsmith", deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow], database=None
)
settings.register_profile("explore", settings.get_profile("gaitsmith"), derandomize=False, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "gaitsmith"))
