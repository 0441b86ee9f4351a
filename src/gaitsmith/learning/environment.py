"""The gait template as a Gymnasium environment: one step of it is one step of the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot, load_robot
from gaitsmith.simulation import Scenario, Simulation
from gaitsmith.simulation.loop import Commands, Order, Script
from gaitsmith.simulation.orders import scenario_orders
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.step_policy import MOST_SEEN, PolicyCard, StepView, adjustable, told

try:
    import gymnasium
except ImportError:
    raise BadInput("gymnasium", "not installed", "the extra gym", "pip install 'gaitsmith[gym]'") from None

_ADJUST = ("period", "height", "lift", "width")
_FALL = -1.0
_TOLERANCE = 0.1  # √(g z): a mean speed that is so far off earns nothing
_LONGEST_STEP = 5.0  # s; a robot that takes no step for so long stands
_SEEDS = 2**31

Observation = npt.NDArray[np.float32]


class _Inbox(Commands):
    """Orders of a script, and what the environment adds."""

    def __init__(self, script: Script) -> None:
        self.script = script
        self.added: list[Order] = []

    def poll(self, time: float) -> list[Order]:
        """Orders of this tick."""
        added, self.added = self.added, []
        return [*self.script.poll(time), *added]


class GaitTemplateEnv(gymnasium.Env[Observation, Observation]):
    """Choose the template's parameters at every touchdown while the whole-body controller walks.

    An episode is one scenario. It begins with the first touchdown, ends with a fall (terminated) or when the scenario
    is over (truncated). An action (m,) in -1 to 1 sets the adjusted gait inputs over their ranges; they take effect
    with the step after the one that has just begun (Han 2023, section 2.3). An observation (n,) is what the controller
    knows, in units of the robot's size, mass and gravity, named by :attr:`seen`.

    The reward of a step is its duration, s, times ``1 - min(1, |mean speed - command| / (0.1 √(g z)))``; a fall costs 1
    besides. The best return is therefore the time walked, in s.

    Args:
        robot: name, card, or a loaded robot.
        scenario: fields of :class:`gaitsmith.Scenario`, or one; by default 20 s at 0.3 m/s or what the robot can.
        adjust: gait inputs that an action sets, in its order.
        ranges: (lowest, highest) by input, where they are narrower than the card's limits.
        vary: (lowest, highest) of scenario fields that are numbers, drawn evenly at every reset; ``speed_x`` and
            ``speed_y`` are the speed's parts.

    Attributes:
        seen: names of the observation's numbers.
        card: of a policy that is trained here.

    Raises:
        BadInput: what does not fit the robot.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - as the base class has it

    def __init__(
        self,
        robot: str | Robot = "bhr_b2",
        *,
        scenario: Scenario | Mapping[str, Any] | None = None,
        adjust: Sequence[str] = _ADJUST,
        ranges: Mapping[str, Sequence[float]] | None = None,
        vary: Mapping[str, Sequence[float]] | None = None,
        render_mode: None = None,
    ) -> None:
        self.render_mode = render_mode
        self._robot = load_robot(robot) if isinstance(robot, str) else robot
        fields = scenario.model_dump(exclude_none=True) if isinstance(scenario, Scenario) else dict(scenario or {})
        if not fields:
            fields["speed"] = (min(0.3, self._robot.card.gait_limits.speed_x[1]), 0.0)
        if fields.get("gait"):
            raise BadInput("scenario", "a gait file", "a walk by the template")
        self._fields = {**fields, "robot": self._robot.card.name}
        self._vary = _checked_ranges(vary or {})
        make_scenario(_plain(self._fields))
        self._adjusted = adjustable(adjust, self._robot.card.gait_limits, ranges or {})
        self._simulation = self._simulate(make_scenario(_plain(self._fields)))
        self.seen = self._view.names
        joints = tuple(self._robot.joint_names)
        self.card = PolicyCard(joints=joints, seen=self.seen, adjusted=self._adjusted)
        self.observation_space = gymnasium.spaces.Box(-MOST_SEEN, MOST_SEEN, (len(self.seen),), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(self._adjusted),), np.float32)

    def _simulate(self, scenario: Scenario) -> Simulation:
        """A run at rest, its controller used again."""
        previous = getattr(self, "_simulation", None)
        same = previous is not None and previous.scenario.preset == scenario.preset
        self._inbox = _Inbox(Script([], 1e-3))
        simulation = Simulation(
            scenario,
            robot=self._robot,
            controller=previous.controller if previous is not None and same else None,
            record=False,
            commands=self._inbox,
        )
        self._inbox.script = Script(scenario_orders(scenario), simulation.plant.control_step)
        self._view = StepView(simulation.controller, self._adjusted)
        return simulation

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Stand, begin to walk, and stop at the first touchdown; terrain and noise are drawn anew.

        Args:
            seed: of everything random from here on.
            options: scenario fields for this episode alone.

        Raises:
            BadInput: an option that is no field of a scenario, or does not fit the robot.
        """
        super().reset(seed=seed)
        fields = {**self._fields, "seed": int(self.np_random.integers(_SEEDS)), **(options or {})}
        for name, (low, high) in self._vary.items():
            _put(fields, name, float(self.np_random.uniform(low, high)))
        self._simulation = self._simulate(make_scenario(_plain(fields)))
        self._walk_to_touchdown()
        return self._observe(), self._info()

    def step(self, action: Observation) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One step of the robot.

        Raises:
            BadInput: an action of another shape or with a number that is not finite.
        """
        if np.shape(action) != self.action_space.shape:
            raise BadInput("action", action, f"{self.action_space.shape} numbers from -1 to 1")
        self._inbox.added.append(Order(told(self._adjusted, np.asarray(action, dtype=np.float64)), told=False))
        duration, speed = self._walk_to_touchdown()
        fell = self._simulation.fall is not None
        wanted = np.asarray(self._simulation.controller.gait.speed)
        off = float(np.hypot(*(speed - wanted))) / (_TOLERANCE * self._simulation.controller.scale.speed)
        reward = duration * (1.0 - min(1.0, off)) + (_FALL if fell else 0.0)
        over = self._simulation.tick >= self._simulation.ticks
        return self._observe(), reward, fell, over and not fell, self._info()

    def _walk_to_touchdown(self) -> tuple[float, npt.NDArray[np.float64]]:
        """Tick until the legs have switched; time that passed, s, and mean speed (2,) in the heading frame, m/s."""
        simulation, told = self._simulation, self._simulation.controller.telemetry
        steps, began, ticks, way = float(told.step_count[0]), simulation.time, 0, np.zeros(2)
        going = True
        while going and told.step_count[0] == steps:
            going = simulation.step()
            way += told.com_velocity[:2]
            ticks += 1
            if steps > 0.0 and simulation.time - began > _LONGEST_STEP:
                break
        return simulation.time - began, way / max(ticks, 1)

    def _observe(self) -> Observation:
        return self._view().astype(np.float32)

    def _info(self) -> dict[str, Any]:
        fall = self._simulation.fall
        return {"time": self._simulation.time, "fall": None if fall is None else fall.reason}


def _plain(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Scenario fields as a file would give them."""
    return {name: value.model_dump() if hasattr(value, "model_dump") else value for name, value in fields.items()}


def _put(fields: dict[str, Any], name: str, value: float) -> None:
    """Set a number of a scenario; parts of the speed by name."""
    if name in ("speed_x", "speed_y"):
        speed = list(fields.get("speed") or (0.0, 0.0))
        speed[name == "speed_y"] = value
        fields["speed"] = tuple(speed)
    else:
        fields[name] = value


def _checked_ranges(vary: Mapping[str, Sequence[float]]) -> dict[str, tuple[float, float]]:
    """Ranges of what is drawn.

    Raises:
        BadInput: not two numbers, or the first is the larger one.
    """
    checked = {}
    for name, given in vary.items():
        pair = tuple(given) if isinstance(given, Sequence) else ()
        if len(pair) != 2 or not all(isinstance(value, int | float) for value in pair) or not pair[0] <= pair[1]:
            raise BadInput(f"vary[{name}]", given, "lowest and highest")
        checked[name] = (float(pair[0]), float(pair[1]))
    return checked
