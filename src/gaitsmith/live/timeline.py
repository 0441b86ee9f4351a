"""What happened when in a run: touchdowns, limits, pushes, the fall; as data and as a picture."""

from __future__ import annotations

import html
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.live.run import Run

Array = npt.NDArray[np.float64]
_AT_LIMIT = 0.995  # of a joint's torque limit
_SHORTEST = 0.012  # s of a limit that is shown
_WIDTH, _ROW = 1000.0, 26.0
_COUNTED = {"qp_fallbacks": "QP fell back", "ik_fallbacks": "IK fell back", "touchdowns_forced": "touchdown forced"}


class Span(NamedTuple):
    """Something that lasted from begin to end, s."""

    begin: float
    end: float
    words: str


class Timeline(NamedTuple):
    """What happened when.

    Attributes:
        touchdowns: time (s) and leg, 0 left, 1 right, 2 both.
        limits: that were reached.
        pushes: while they acted.
        fall: s; None without one.
    """

    touchdowns: list[tuple[float, int]]
    limits: list[Span]
    pushes: list[Span]
    fall: float | None

    @property
    def moments(self) -> list[float]:
        """When something happened that one may want to see, s: the beginnings of pushes, and the fall."""
        return sorted([push.begin for push in self.pushes] + ([] if self.fall is None else [self.fall]))


def timeline_of(run: Run) -> Timeline:
    """What happened in a run."""
    log = run.log
    steps = np.flatnonzero(np.diff(log.column("step_count")) > 0.0) + 1
    stance = log.column("stance")
    touchdowns = [(float(log.time[k]), int(stance[k])) for k in steps]
    limits = _spans(log.time, log.column("foothold_bound") > 0.5, "foothold at its bound")
    for joint, most in zip(run.robot.joint_names, run.robot.torque_limit, strict=True):
        limits += _spans(log.time, np.abs(log.column(f"torque.{joint}")) >= _AT_LIMIT * most, f"torque of {joint}")
    for column, words in _COUNTED.items():
        if column in log.columns:
            rose = np.flatnonzero(np.diff(log.column(column)) > 0.0) + 1
            limits += [Span(float(log.time[k]), float(log.time[k]) + _SHORTEST, words) for k in rose]
    pushes = [Span(push.begin, push.end, f"push {push.words}") for push in run.pushes]
    fall = min(run.fall.time, float(log.time[-1])) if run.fall else None  # rows are sparser than ticks
    return Timeline(touchdowns, sorted(limits), pushes, fall)


def _spans(time: Array, mask: npt.NDArray[np.bool_], words: str) -> list[Span]:
    """Stretches in which something held, and that are long enough to matter."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    found = [Span(float(time[a]), float(time[b - 1]), words) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return [span for span in found if span.end - span.begin >= _SHORTEST]


def drawn(timeline: Timeline, begin: float, end: float, colours: tuple[str, str, str]) -> str:
    """The timeline as SVG, from begin to end, s; colours of the left leg, the right one, and of both."""
    scale = _WIDTH / max(end - begin, 1e-9)
    rows = ("left", "right", "limits", "pushes")
    height = _ROW * len(rows)

    def x(time: float) -> float:
        return round((time - begin) * scale, 1)

    parts = [f'<rect width="{_WIDTH}" height="{height}" fill="#f4f6f8"/>']
    for k in range(1, len(rows)):
        parts.append(f'<line x1="0" x2="{_WIDTH}" y1="{k * _ROW}" y2="{k * _ROW}" stroke="white" stroke-width="2"/>')
    for time, leg in timeline.touchdowns:
        for row in (0, 1) if leg > 1 else (leg,):
            top = row * _ROW + 5
            parts.append(
                f'<line x1="{x(time)}" x2="{x(time)}" y1="{top}" y2="{top + 16}" '
                f'stroke="{colours[leg]}" stroke-width="3"/>'
            )
    for k, (spans, colour) in enumerate(((timeline.limits, "#eba614"), (timeline.pushes, "#d62828"))):
        for span in spans:
            width = max((span.end - span.begin) * scale, 4.0)
            parts.append(
                f'<rect x="{x(span.begin)}" y="{(2 + k) * _ROW + 5}" width="{width:.1f}" height="16" rx="2" '
                f'fill="{colour}"><title>{html.escape(span.words)}, {span.begin:.2f} s</title></rect>'
            )
    if timeline.fall is not None:
        at = x(timeline.fall)
        parts.append(f'<line x1="{at}" x2="{at}" y1="0" y2="{height}" stroke="#2b323b" stroke-width="4"/>')
    names = "".join(f'<div style="height:{_ROW / 2 + 4}px">{name}</div>' for name in rows)
    picture = (
        f'<svg viewBox="0 0 {_WIDTH} {height}" preserveAspectRatio="none" style="width:100%;height:'
        f'{(_ROW / 2 + 4) * len(rows)}px;display:block;border-radius:4px">{"".join(parts)}</svg>'
    )
    return (
        '<div style="display:flex;gap:6px;padding:4px 12px 8px 12px;font-size:11px;color:#5b6573">'
        f'<div>{names}</div><div style="flex:1">{picture}</div></div>'
    )
