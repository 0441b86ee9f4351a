"""The end of a run that fell: attitude, what touched and which limit was hit when, the last steps from above."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitsmith.view.canvas import BAD, COMMAND, FAULT, LEFT, LIMIT, PUSH, RIGHT, THIRD, above, figure, mark_events
from gaitsmith.view.footprints import draw_path
from gaitsmith.view.recording import Recording

_BEFORE = 3.0  # s that are shown
_SATURATED = 0.999  # of a torque's limit
_BEARS = 0.02  # of the largest force: a sole that bears
_SLIDES, _GRAVITY = 0.1, 9.81  # of √(gH): a sole that bears and moves faster slips, as the report of limits has it
Flags = npt.NDArray[np.bool_]


def draw_fall(recording: Recording) -> Figure:
    """The last seconds: torso and height, a line for each thing that happened, and where the feet went."""
    time = recording.time
    start = max(recording.fell or float(time[-1]), float(time[0])) - _BEFORE
    earlier = [push.begin - 0.3 for push in recording.pushes if push.begin < start + _BEFORE]
    start = max(min([start, *earlier[-1:]]), float(time[0]), start - 2.0 * _BEFORE)
    first = min(int(np.searchsorted(time, start)), len(time) - 2)
    span = slice(first, len(time))
    rows = _rows(recording)
    rows = [row for row in rows if np.any(row[1][span])]
    with figure(f"{recording.title}: the fall", 9.6 + 0.22 * len(rows), recording.conditions) as made:
        tilt, height, what, top = made.subplots(
            4, 1, height_ratios=(1.5, 1.0, 0.4 + 0.24 * len(rows), 3.0), gridspec_kw={"hspace": 0.06}
        )
        for column, (name, colour) in enumerate((("roll", RIGHT), ("pitch", THIRD))):
            tilt.plot(time[span], np.degrees(recording.tilt[span, column]), color=colour, label=name)
        tilt.set_ylabel("torso, °")
        above(tilt, 2)
        height.plot(time[span], recording.height[span], color=LEFT, label="hip above the stance sole")
        height.plot(time[span], recording.height_command[span], color=COMMAND, linestyle="--", label="commanded")
        height.set_ylabel("height, m")
        above(height, 2)
        _bars(what, recording, rows, span)
        for axis in (tilt, height, what):
            axis.set_xlim(float(time[first]), float(time[-1]) + 0.02 * (float(time[-1]) - float(time[first])))
        what.set_xlabel("time, s")
        mark_events((tilt, height, what), recording)
        draw_path(top, recording, 1, span)
        top.margins(0.1)
        top.set_aspect("equal", adjustable="box")
        top.set(xlabel="x, m", ylabel="y, m", title="from above")
        made.legend(*top.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return made


def _rows(recording: Recording) -> list[tuple[str, Flags, str]]:
    """What happened: name, when, and colour."""
    robot, force = recording.robot, recording.sole_force
    bears = force > _BEARS * max(float(force.max()), 1.0)
    pushed = np.zeros(len(recording.time), dtype=bool)
    for push in recording.pushes:
        pushed |= (recording.time >= push.begin) & (recording.time <= push.end)
    rows: list[tuple[str, Flags, str]] = [("push", pushed, PUSH)]
    for side, colour in ((0, LEFT), (1, RIGHT)):
        rows.append((f"{robot.legs[side].name} sole bears", bears[:, side], colour))
    bound = _SLIDES * np.sqrt(_GRAVITY * recording.height_command)
    for side in (0, 1):
        way = np.diff(recording.sole_position[:, 3 * side : 3 * side + 2], axis=0, prepend=np.nan)
        fast = np.hypot(*way.T) > bound * np.diff(recording.time, prepend=-np.inf)
        rows.append((f"{robot.legs[side].name} sole slips", fast & bears[:, side], BAD))
    for name in dict.fromkeys(fault.words for fault in recording.faults):
        acts = np.zeros(len(recording.time), dtype=bool)
        for fault in recording.faults:
            acts |= (fault.words == name) & (recording.time >= fault.begin) & (recording.time <= fault.end)
        rows.append((name, acts, FAULT))
    limit = _SATURATED * np.asarray(robot.torque_limit)
    saturated = np.abs(recording.torque) >= limit
    rows += [(f"torque limit {name}", saturated[:, j], BAD) for j, name in enumerate(robot.joint_names)]
    rows.append(("foothold at a bound", recording.foothold_bound & recording.walking, BAD))
    rows.append(("QP fell back", np.diff(recording.qp_fallbacks, prepend=recording.qp_fallbacks[:1]) > 0.0, BAD))
    rows.append(("legs touch", recording.leg_contact > 0.0, BAD))
    rows.append(("body on the ground", recording.body_contact > 0.0, BAD))
    return rows


def _bars(axis: Axes, recording: Recording, rows: list[tuple[str, Flags, str]], span: slice) -> None:
    """A bar wherever a thing is so."""
    time = recording.time[span]
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    for line, (_, flags, colour) in enumerate(rows):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], flags[span], [False]]).astype(int))).reshape(-1, 2)
        for a, b in edges:
            axis.barh(line, time[b - 1] - time[a] + step, left=time[a], height=0.7, color=colour, linewidth=0.0)
    axis.set_yticks(range(len(rows)), [name for name, _, _ in rows], fontsize=9.0)
    axis.set_ylim(len(rows) - 0.4, -0.6)
    axis.grid(visible=False, axis="y")
    axis.axhline(-0.5, color=LIMIT, linewidth=0.0)
