"""The controls of a walk: sliders, buttons and keys. Each can say only what it allows, whatever a browser sends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from gaitsmith.live.buttons import button_row
from gaitsmith.live.desk import Desk
from gaitsmith.live.server import Server
from gaitsmith.live.wishes import TERRAINS, Kind
from gaitsmith.robots import Robot
from gaitsmith.robots.parameters import GAIT_INPUTS, gait_numbers

_LABELS = {
    "speed_x": "Speed forward, m/s",
    "speed_y": "Speed to the left, m/s",
    "yaw_rate": "Turning to the left, rad/s",
    "period": "Step period T, s",
    "lift": "Foot lift h, m",
    "height": "Hip height H, m",
    "width": "Half width W, m",
    "alpha": "Lifting share α",
}
"""Sliders in the order in which they stand."""
_STEPS = 100  # of a slider
_PUSH = 0.09  # of m √(g H): the push that the slider begins with; the paper's 15 N·s on BHR-B2
_HARDEST = 0.4  # of the same: where it ends
PACES = {"1×": 1.0, "½": 0.5, "⅕": 0.2, "1⁄20": 0.05}
_ROUND = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
_HIGHEST, _STEEPEST = 0.15, 15.0  # of the hips' height; °
_KEYS = """| key | does |
|---|---|
| **W** **S** | faster, slower |
| **A** **D** | turn left, right |
| **Q** **E** | step to the left, right |
| **X** | no speed, no turning |
| **↑ ↓ ← →** | push |
| **space** **N** | pause, one tick |
| **R** | begin anew |

Drag the torso to pull at it. Drag beside it to look from elsewhere. A gamepad: left stick speed, right stick turning,
cross pushes, A pauses, B stops.
"""
_DIRECTIONS = {
    "↑": (1.0, 0.0),
    "↓": (-1.0, 0.0),
    "←": (0.0, 1.0),
    "→": (0.0, -1.0),
}


def clamped(value: Any, low: float, high: float, otherwise: float) -> float:
    """The value within its range; ``otherwise`` for what is no finite number."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        return otherwise
    return min(max(float(value), low), high)


class Controls:
    """What can be asked of a walk.

    Args:
        robot: whose card limits the gait.
        gait: the inputs at the beginning, by name; empty if a plan is followed.

    Attributes:
        gait: the numbers commanded, by name as in the limits.
    """

    def __init__(self, server: Server, robot: Robot, desk: Desk, gait: Mapping[str, Any]) -> None:
        self._server, self._desk, self._robot = server, desk, robot
        self._parts = [part for part, _, _ in gait_numbers(gait)] if gait else []
        self.gait = {part: float(value) for part, _, value in gait_numbers(gait)} if gait else {}
        self._sliders: dict[str, Any] = {}
        self._unit = robot.mass * math.sqrt(float(abs(robot.model.opt.gravity[2])) * robot.card.gait.height)
        self.paused = self.recording = False

    def add_buttons(self) -> None:
        """Pause, one tick, anew; the pace of time; walking and standing; recording."""
        gui = self._server.gui
        button_row(self._server, "Run", {"Pause": self._pause, "One tick": self._step, "Reset": self._reset})
        button_row(
            self._server, "Time", {name: partial(self._desk.ask, Kind.FACTOR, pace) for name, pace in PACES.items()}
        )
        if self.gait:
            button_row(
                self._server, "Legs", {name: partial(self._walk, on) for name, on in (("Walk", 1.0), ("Stand", 0.0))}
            )
        self._record = gui.add_button("Record a run", icon=None, color="gray")

        async def record(_: Any) -> None:
            self._desk.ask(Kind.RECORD, 0.0 if self.recording else 1.0)

        self._record.on_click(record)

    def add_gait(self) -> None:
        """A slider for every input of the gait that the robot can change."""
        limits = self._robot.card.gait_limits
        with self._server.gui.add_folder("Gait"):
            for part, label in _LABELS.items():
                low, high = getattr(limits, part)
                if part in self.gait and low < high:
                    self._add_slider(part, label, low, high)
            fixed = [GAIT_INPUTS[part].fixed for part in self.gait if part in GAIT_INPUTS and part not in self._sliders]
            if any(fixed):
                self._server.gui.add_markdown(f"*No turning: {next(filter(None, fixed))}.*")

    def _add_slider(self, part: str, label: str, low: float, high: float) -> None:
        value, step = self.gait[part], _fine((high - low) / _STEPS)
        slider = self._server.gui.add_slider(label, low, high, step, min(max(value, low), high))
        self._sliders[part] = slider

        async def moved(event: Any) -> None:
            if event.client_id is not None:  # not by the page itself
                self.set_gait(part, slider.value)

        slider.on_update(moved)

    def set_gait(self, part: str, value: Any) -> None:
        """Command one number of the gait, within the robot's limits."""
        if part not in self._sliders:
            return
        low, high = getattr(self._robot.card.gait_limits, part)
        self.gait[part] = clamped(value, low, high, self.gait[part])
        if self._sliders[part].value != self.gait[part]:
            self._sliders[part].value = self.gait[part]
        self._desk.ask(Kind.GAIT, *(self.gait[name] for name in self._parts))

    def _nudge(self, part: str, steps: float) -> None:
        """Change a speed by some twentieths of its range."""
        if part in self._sliders:
            low, high = getattr(self._robot.card.gait_limits, part)
            size = _fine((high - low) / 25.0)
            self.set_gait(part, round(self.gait[part] / size + steps) * size)

    def halt(self) -> None:
        """No speed and no turning."""
        for part in ("speed_x", "speed_y", "yaw_rate"):
            self.set_gait(part, 0.0)

    def add_push(self) -> None:
        """Size and direction of a push."""
        gui = self._server.gui
        with gui.add_folder("Push"):
            size, most = _fine(_PUSH * self._unit), _fine(_HARDEST * self._unit)
            self._impulse = gui.add_slider("Impulse, N·s", 0.0, most, _fine(most / _STEPS), size)
            self._hardest = most
            button_row(self._server, "To", {name: partial(self._push, way) for name, way in _DIRECTIONS.items()})

    def _push(self, way: tuple[float, float]) -> None:
        size = clamped(self._impulse.value, 0.0, self._hardest, 0.0)
        self._desk.ask(Kind.PUSH, size * way[0], size * way[1], 0.0)

    def pull(self, way: Any, goes_on: bool) -> None:
        """Pull at the torso by a way, world axes, m: half the weight for a leg's length."""
        stiffness = self._unit**2 / (2.0 * self._robot.mass * self._robot.card.gait.height**2)
        reach = 2.0 * self._robot.card.gait.height
        self._desk.ask(Kind.HOLD, *(stiffness * clamped(x, -reach, reach, 0.0) if goes_on else 0.0 for x in way))

    def add_ground(self, terrain: str) -> None:
        """Another ground, on which the walk begins anew."""
        gui, height = self._server.gui, self._robot.card.gait.height
        kind, _, amount = terrain.partition(":")
        with gui.add_folder("Ground", expand_by_default=False):
            chosen = gui.add_dropdown("Kind", TERRAINS, initial_value=kind if kind in TERRAINS else TERRAINS[0])
            most = round(_HIGHEST * height, 3)
            start = float(amount or 0.0)
            boxes = min(start, most) if kind == "boxes" else round(0.03 * height, 3)
            steep = min(max(start, -_STEEPEST), _STEEPEST) if kind == "slope" else 5.0
            high = gui.add_slider("Boxes up to, m", 0.0, most, round(most / 30.0, 4), boxes)
            slope = gui.add_slider("Slope, °", -_STEEPEST, _STEEPEST, 0.5, steep)
            seed = gui.add_slider("Seed", 0, 99, 1, 0)
            button = gui.add_button("Begin on this ground", color="gray")

            async def begin(_: Any) -> None:
                if chosen.value not in TERRAINS:
                    return
                amounts = (0.0, clamped(slope.value, -_STEEPEST, _STEEPEST, 0.0), clamped(high.value, 0.0, most, 0.0))
                number = TERRAINS.index(chosen.value)
                self._desk.ask(Kind.TERRAIN, number, amounts[number], clamped(seed.value, 0, 99, 0))

            button.on_click(begin)

    def add_keys(self) -> None:
        """Keys, and what they do."""
        ways = list(_DIRECTIONS.values())
        keys: list[tuple[str, Any, Callable[[], None]]] = [
            ("Faster", "W", lambda: self._nudge("speed_x", 1)),
            ("Slower", "S", lambda: self._nudge("speed_x", -1)),
            ("Turn left", "A", lambda: self._nudge("yaw_rate", 1)),
            ("Turn right", "D", lambda: self._nudge("yaw_rate", -1)),
            ("Step left", "Q", lambda: self._nudge("speed_y", 1)),
            ("Step right", "E", lambda: self._nudge("speed_y", -1)),
            ("No speed", "X", self.halt),
            ("Push forward", "arrowup", lambda: self._push(ways[0])),
            ("Push back", "arrowdown", lambda: self._push(ways[1])),
            ("Push left", "arrowleft", lambda: self._push(ways[2])),
            ("Push right", "arrowright", lambda: self._push(ways[3])),
            ("Pause", "space", self._pause),
            ("One tick", "N", self._step),
            ("Reset", "R", self._reset),
        ]
        for label, key, act in keys:

            async def triggered(_: Any, act: Callable[[], None] = act) -> None:
                act()

            self._server.gui.add_command(label, hotkey=key).on_trigger(triggered)
        with self._server.gui.add_folder("Keys", expand_by_default=False):
            self._server.gui.add_markdown(_KEYS)

    def show_state(self, paused: bool, recording: bool) -> None:
        """Let the buttons say what they will do."""
        self.paused = paused
        if recording != self.recording:
            self.recording = recording
            self._record.label = "Stop recording" if recording else "Record a run"
            self._record.color = "red" if recording else "gray"

    def _pause(self) -> None:
        self._desk.ask(Kind.PAUSE, 0.0 if self.paused else 1.0)

    def _step(self) -> None:
        self._desk.ask(Kind.STEP, 1.0)

    def _reset(self) -> None:
        self._desk.ask(Kind.RESET)

    def _walk(self, on: float) -> None:
        if not on:
            self.halt()
        self._desk.ask(Kind.WALK, on)


def _fine(value: float) -> float:
    """A number near this one with one figure, or 1.5, 2.5 of one: a step that people can count with."""
    size = 10.0 ** math.floor(math.log10(value))
    return round(min(_ROUND, key=lambda number: abs(number - value / size)) * size, 9)
