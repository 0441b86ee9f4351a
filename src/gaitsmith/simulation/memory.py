"""Memory of this process."""

from __future__ import annotations

import os
import resource
import sys


def resident_mb() -> float:
    """Resident memory of this process, MB; where the system does not tell, the most that it has been so far."""
    try:
        with open("/proc/self/statm", "rb") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    except (OSError, ValueError, IndexError):
        unit = 1.0 if sys.platform == "darwin" else 1024.0
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
