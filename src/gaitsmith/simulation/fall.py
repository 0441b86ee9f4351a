"""A fall, explained: when, in which phase of the step, how, and which limits had been hit before."""

from __future__ import annotations

from gaitsmith.simulation.monitor import DIVERGED, SANK, TILTED, TOUCHED, Monitor
from gaitsmith.simulation.summary import Fall

_HOW = {
    TILTED: "the torso tilted by more than 60 degrees",
    SANK: "the hip sank below half the commanded height",
    TOUCHED: "a body other than a foot touched the ground",
    DIVERGED: "simulation diverged",
}
_SHOWN = 3


def explain(monitor: Monitor, time: float, phase: str, refused: dict[str, int]) -> Fall:
    """The fall that a monitor has just seen.

    Args:
        monitor: of the run.
        time: s.
        phase: of the step, in words.
        refused: ticks with unusable readings, by sensor.
    """
    now = monitor.ticks - 1
    hits = [(name, time - (now - tick) * monitor.dt) for name, tick in monitor.hits()]
    reason = _HOW[monitor.state]
    if hits:
        (first, when), *others = hits
        reason += f"; first limit hit: {first}, at {when:.3f} s"
        if others:
            reason += "; then " + ", ".join(f"{name} at {when:.3f} s" for name, when in others[:_SHOWN])
    else:
        reason += "; no limit was hit in the last step"
    unusable = ", ".join(f"{count} of {sensor}" for sensor, count in refused.items() if count)
    reason += f"; ticks with unusable readings: {unusable}" if unusable else ""
    return Fall(time=time, phase=phase, reason=reason)
