"""How long the control ticks took."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from gaitsmith.view.canvas import LEFT, LIMIT, RIGHT, above, figure
from gaitsmith.view.recording import Recording

_BINS = 80


def draw_timing(recording: Recording) -> Figure:
    """Histogram of the tick's duration, both axes logarithmic, with median and 99th percentile."""
    ticks, counts = recording.tick_us, recording.tick_counts
    below = np.cumsum(counts)
    with figure(f"{recording.title}: duration of a control tick", 4.2) as made:
        axis = made.subplots()
        median, late = (ticks[np.searchsorted(below, share * below[-1])] for share in (0.5, 0.99))
        edges = np.geomspace(0.9 * ticks.min(), 1.1 * ticks.max(), _BINS)
        axis.hist(ticks, bins=edges.tolist(), weights=counts, color=LEFT, alpha=0.85)
        axis.axvline(median, color=RIGHT, label=f"median {median:.1f} µs")
        axis.axvline(late, color=RIGHT, linestyle="--", label=f"99 % within {late:.1f} µs")
        axis.axvline(ticks.max(), color=LIMIT, linestyle=":", label=f"longest {ticks.max():.0f} µs")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set(xlabel="duration, µs", ylabel="ticks")
        axis.xaxis.set_major_formatter("{x:g}")  # the formatters of logarithmic axes write markup
        axis.yaxis.set_major_formatter("{x:g}")
        axis.yaxis.set_minor_formatter("")
        axis.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))  # more labels would touch each other
        axis.xaxis.set_minor_formatter("{x:g}")
        above(axis, 3)
    return made
