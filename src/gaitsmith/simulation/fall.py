"""A fall, explained: when, in which phase of the step, how, and which limits had been hit before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from gaitsmith.simulation.monitor import DIVERGED, MEMORY, SANK, TILTED, TOUCHED, Monitor

_HOW = {
    TILTED: "the torso tilted by more than 60 degrees",
    SANK: "the hip sank below half the commanded height",
    TOUCHED: "a body other than a foot touched the ground",
    DIVERGED: "simulation diverged",
}
_HELD = 5  # ticks that a limit has to be hit in a row; shorter ones are the solver's business
_AT_ONCE = ("legs touching each other", "whole-body QP infeasible", "step ended by the clock")
_SHOWN = 3


@dataclass(frozen=True)
class Fall:
    """A fall.

    Attributes:
        time: s since the beginning of the run.
        phase: stance leg and share of the step, in words.
        reason: how it fell, then the limits hit in the last 1.5 s, first one first.
    """

    time: float
    phase: str
    reason: str


@dataclass(frozen=True)
class LimitHit:
    """A limit that was hit: its name, and how long before the last tick it was hit first, s."""

    name: str
    before: float


def first_hits(
    limits: npt.NDArray[np.int64], ticks: int, names: tuple[str, ...], control_step: float
) -> list[LimitHit]:
    """Limits hit within the memory, ordered by when each was hit first.

    Args:
        limits: (MEMORY, n) ring of flags, row ``tick % MEMORY``.
        ticks: number of ticks written; the last one is ``ticks - 1``.
        names: of the columns.
        control_step: s per row.

    A limit counts once it has been hit for 5 ticks in a row; single events count at once.
    """
    length = min(ticks, MEMORY)
    rows = limits[(np.arange(ticks - length, ticks)) % MEMORY] > 0
    found = []
    for column, name in enumerate(names):
        need = 1 if name in _AT_ONCE else _HELD
        if length < need:
            continue
        held = np.lib.stride_tricks.sliding_window_view(rows[:, column], need).all(axis=1)
        if held.any():
            found.append(LimitHit(name, (length - 1 - int(np.argmax(held))) * control_step))
    return sorted(found, key=lambda hit: -hit.before)


def explain(kind: int, time: float, monitor: Monitor, mode: int, stance: int, step_time: float, period: float) -> Fall:
    """The fall that :meth:`Monitor.watch` has just reported.

    Args:
        kind: what ``watch`` returned.
        time: s.
        monitor: of the run.
        mode: 0 standing, 1 walking.
        stance: 0 left, 1 right, 2 both.
        step_time: since the step began, s.
        period: of the step, s.
    """
    phase = "standing"
    if mode == 1 and stance < 2 and period > 0.0:
        phase = f"{('left', 'right')[stance]} stance, {100.0 * step_time / period:.0f} % of the step"
    hits = first_hits(monitor.kept.limits, monitor.ticks, monitor.limit_names, monitor.control_step)
    if not hits:
        return Fall(time, phase, f"{_HOW[kind]}; no limit was hit in the {MEMORY * monitor.control_step:g} s before")
    first, *others = hits
    reason = f"{_HOW[kind]}; first limit hit: {first.name}, at {time - first.before:.3f} s"
    if others:
        reason += "; then " + ", ".join(f"{hit.name} at {time - hit.before:.3f} s" for hit in others[:_SHOWN])
    return Fall(time, phase, reason)
