"""Strip charts of the last seconds: speed against command, torso, height, torques against limits, tick time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.live.frame import Frame
from gaitsmith.live.server import Server
from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]
_BLUE, _ORANGE, _GREY, _GREEN, _RED = "#2d7dd2", "#e6732d", "#8a94a3", "#3caf5a", "#d62828"
_PALE = "#b5d3ef"
_AXIS = {"stroke": "#5b6573", "grid": {"stroke": "#e7eaee", "width": 1}, "ticks": {"stroke": "#e7eaee", "width": 1}}


class _Line(NamedTuple):
    """One line of a chart."""

    label: str
    colour: str
    width: float = 1.5
    dash: tuple[float, ...] = ()


class _Chart(NamedTuple):
    """One chart: its title with the unit, and its lines; guides are constants that are always in sight."""

    title: str
    lines: tuple[_Line, ...]
    guides: tuple[tuple[float, str], ...] = ()


_COMMAND = _Line("command", _GREY, 2.0, (6, 4))
_BAND = _Line("", "#d5dae1", 1.0)
CHARTS = {
    "speed": _Chart(
        "Speed, m/s",
        (
            *(_COMMAND, _Line("forward", _PALE, 1.0), _Line("mean of a step", _BLUE, 2.5)),
            _Line("to the left", _ORANGE, 1.5),
        ),
        ((0.0, "#d5dae1"),),
    ),
    "torso": _Chart("Torso, °", (_Line("roll", _ORANGE), _Line("pitch", _BLUE)), ((-2.0, "#e7eaee"), (2.0, "#e7eaee"))),
    "height": _Chart("Hip height, m", (_COMMAND, _Line("actual", _BLUE, 2.0), _BAND, _BAND)),
    "torque": _Chart(
        "Largest torque, % of its limit",
        (_Line("left leg", _BLUE), _Line("right leg", _ORANGE), _Line("others", _GREEN)),
        ((0.0, "#d5dae1"), (100.0, _RED)),
    ),
    "tick": _Chart("Time of a tick, ms (1 is due)", (_Line("longest", _BLUE, 1.5),), ((0.0, "#d5dae1"), (1.0, _RED))),
}
"""Charts by name."""


class History:
    """What the charts show, of the last seconds; a row every 20 ms of the robot's time or more.

    Args:
        robot: whose torque limits count.
        length: s.
        every: s of the robot's time between two rows.
    """

    def __init__(self, robot: Robot, length: float = 10.0, every: float = 0.02) -> None:
        self._every, self._size = every, round(length / every)
        self._limit = robot.torque_limit
        in_legs = [leg.joint_indices for leg in robot.legs]
        others = np.setdiff1d(np.arange(len(self._limit)), np.concatenate(in_legs))
        self._groups = [*in_legs, others]
        self.has_others = len(others) > 0
        self._speeds: list[tuple[float, float, float]] = []
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self.rows = np.zeros((0, 15))
        self._speeds.clear()
        self._episode = -1.0

    def add(self, frame: Frame, rows: Array) -> None:
        """Take note of some rows of frames, oldest first."""
        at = {name: frame.index(name) for name in _WANTED}
        torque = frame.index("torque." + frame.columns.labels("torque")[0])
        for row in rows:
            time = row[at["live.time"]]
            if row[at["live.episode"]] != self._episode or (len(self.rows) and time < self.rows[-1, 0] - 1e-9):
                self.clear()
                self._episode = row[at["live.episode"]]
            busy = row[at["live.busy"]]
            if len(self.rows) and time - self.rows[-1, 0] < self._every - 1e-9:
                self.rows[-1, 11] = max(self.rows[-1, 11], 1e3 * busy)
                continue
            share = 100.0 * np.abs(row[torque : torque + len(self._limit)]) / self._limit
            loads = [float(share[group].max()) if len(group) else math.nan for group in self._groups]
            walks = row[at["mode"]] > 0.0
            speed, height = row[at["true.com_velocity_x"]], row[at["hip_height"]]
            self._speeds.append((time, speed, row[at["true.com_velocity_y"]]))
            while self._speeds and self._speeds[0][0] < time - 2.0 * row[at["command.period"]]:
                self._speeds.pop(0)
            _, mean, left = np.mean(self._speeds, axis=0)
            tilt = np.degrees(row[[at["true.torso_roll"], at["true.torso_pitch"]]])
            command = row[at["command.speed_x"]] if walks else 0.0
            told = row[at["command.height"]]
            new = (time, command, speed, mean, *tilt, told, height, *loads, 1e3 * busy, 0.95 * told, 1.03 * told, left)
            self.rows = np.vstack([self.rows[-self._size + 1 :], new])


_WANTED = (
    *("live.time", "live.episode", "live.busy", "mode", "true.com_velocity_x", "hip_height", "command.period"),
    "true.com_velocity_y",
    *("true.torso_roll", "true.torso_pitch", "command.speed_x", "command.height"),
)
_COLUMNS = {"speed": (1, 2, 3, 14), "torso": (4, 5), "height": (6, 7, 12, 13), "torque": (8, 9, 10), "tick": (11,)}


class Charts:
    """The charts on a page.

    Args:
        without: names of charts that say nothing here.
    """

    def __init__(self, server: Server, history: History, without: tuple[str, ...] = ()) -> None:
        self._history, self._handles = history, dict[str, Any]()
        for name, chart in CHARTS.items():
            if name in without:
                continue
            lines = list(zip(_COLUMNS[name], chart.lines, strict=True))
            if name == "torque" and not history.has_others:
                lines = lines[:-1]
            columns = tuple(column for column, _ in lines)
            series: list[Any] = [{"label": "s"}]
            series += [{"stroke": colour, "width": 1, "points": {"show": False}} for _, colour in chart.guides]
            series += [
                {
                    "label": line.label,
                    "stroke": line.colour,
                    "width": line.width,
                    "dash": line.dash,
                    "points": {"show": False},
                    "spanGaps": False,
                }
                for _, line in lines
            ]
            self._handles[name] = (self._add(server, chart, tuple(series), columns), columns, chart.guides)

    def _add(self, server: Server, chart: _Chart, series: tuple[Any, ...], columns: tuple[int, ...]) -> Any:
        """An empty chart."""
        server.gui.add_html(_legend(chart, len(columns)))
        axes: Any = ({**_AXIS, "size": 28}, {**_AXIS, "size": 46})
        return server.gui.add_uplot(
            data=tuple(np.array([0.0, 1.0]) for _ in series),
            series=series,
            scales={"x": {"time": False}},
            axes=axes,
            legend={"show": False},
            cursor={"show": False},
            height=112,
            padding=(4, 10, 0, 0),
        )

    def draw(self) -> None:
        """Show what there is now."""
        rows = self._history.rows
        if len(rows) < 2:
            return
        for handle, columns, guides in self._handles.values():
            constants = (np.full(len(rows), value) for value, _ in guides)
            handle.data = (rows[:, 0].copy(), *constants, *(rows[:, column].copy() for column in columns))


def _legend(chart: _Chart, count: int) -> str:
    """Title, and the lines' names in their colours."""
    keys = "".join(
        f'<span style="color:{line.colour if line.colour != _PALE else "#7fb2e2"};margin-left:9px">{line.label}</span>'
        for line in chart.lines[:count]
        if line.label
    )
    return f'<div style="padding:2px 12px 0 12px;font-size:12.5px"><b>{chart.title}</b>{keys}</div>'
