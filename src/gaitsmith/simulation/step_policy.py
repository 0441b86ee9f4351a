"""A policy that sets gait inputs once a step: what it sees, what it may change, and the file that it comes from.

The file is ONNX. Its metadata say for which joints it was made, which numbers it sees, and which gait inputs its
outputs are, with the range that -1 to 1 stands for.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Protocol

import numpy as np
import numpy.typing as npt
from pydantic import Field

from gaitsmith.documents import Frozen, Name, checked
from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded
from gaitsmith.robots.parameters import GAIT_INPUTS
from gaitsmith.simulation.loop import Commands, Order

if TYPE_CHECKING:
    from gaitsmith.control import Controller
    from gaitsmith.robots import Robot
    from gaitsmith.robots.parameters import GaitLimits

KEY = "gaitsmith.policy"
ADJUSTABLE = tuple(name for name, about in GAIT_INPUTS.items() if not about.stops)
"""Gait inputs that say how to walk, not where to."""
MOST_SEEN = 10.0
"""What a policy sees is cut off here, in the robot's own units."""

_LARGEST_FILE = 50_000_000  # bytes
_INSTALL = "pip install 'gaitsmith[policy]'"


class Adjusted(Frozen):
    """One output of a policy: the gait input, and its values at -1 and at 1."""

    name: Annotated[str, Field(max_length=64)]
    low: float
    high: float


class PolicyCard(Frozen):
    """What a policy was made for, in the order of its numbers."""

    joints: tuple[Name, ...]
    seen: tuple[str, ...]
    adjusted: Annotated[tuple[Adjusted, ...], Field(min_length=1, max_length=len(ADJUSTABLE))]


class StepPolicy(Protocol):
    """What chooses gait inputs at the beginning of a step."""

    card: PolicyCard

    def act(self, seen: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """From what is seen (n,) to adjustments (m,), -1 to 1."""


@dataclass(frozen=True)
class _Sight:
    """One thing that is seen: names of its numbers, and their unit."""

    names: tuple[str, ...]
    unit: float


class StepView:
    """What a policy sees of a controller, in units of the robot's size, mass and gravity.

    Args:
        controller: whose telemetry is read; all of it is what the controller knows, not what is true.
        adjusted: gait inputs whose present values are seen too, -1 to 1 over their range.

    Attributes:
        names: of the numbers.
    """

    def __init__(self, controller: Controller, adjusted: Sequence[Adjusted]) -> None:
        self._controller, self._adjusted = controller, tuple(adjusted)
        scale = controller.scale
        soles = [f"{leg.name}.{axis}" for leg in controller.robot.legs for axis in "xyz"]
        self._sights = (
            _Sight(("command.speed_x", "command.speed_y"), scale.speed),
            _Sight(("command.yaw_rate",), scale.rate),
            _Sight(("velocity.x", "velocity.y"), scale.speed),
            _Sight(("roll", "pitch"), 1.0),
            _Sight(("roll_rate", "pitch_rate"), scale.rate),
            _Sight(("hip_height",), scale.height),
            _Sight(tuple(f"sole.{name}" for name in soles), scale.height),
            _Sight(("foothold.x", "foothold.y"), scale.height),
            _Sight(("stance",), 1.0),
            _Sight(("step_duration",), 1.0 / scale.rate),
        )
        units = [unit for sight in self._sights for unit in [sight.unit] * len(sight.names)]
        self._units = np.array(units)
        seen = [name for sight in self._sights for name in sight.names]
        self.names = (*seen, *(f"present.{entry.name}" for entry in adjusted))

    def __call__(self) -> npt.NDArray[np.float64]:
        """The numbers now, (n,), each within ±:data:`MOST_SEEN`."""
        told, gait = self._controller.telemetry, self._controller.gait
        stance = 1.0 - 2.0 * min(float(told.stance[0]), 1.0)
        seen = np.concatenate(
            [
                *((*gait.speed, gait.yaw_rate), told.com_velocity[:2], told.tilt, told.hip_height),
                *(told.foot_actual.ravel(), told.foothold.ravel(), [stance], told.step_duration),
            ]
        )
        present = [_share(float(getattr(gait, entry.name)), entry) for entry in self._adjusted]
        numbers: npt.NDArray[np.float64] = np.concatenate([seen / self._units, present])
        return numbers.clip(-MOST_SEEN, MOST_SEEN)


def _share(value: float, entry: Adjusted) -> float:
    """Where a value lies in a range, -1 to 1."""
    return 2.0 * (value - entry.low) / (entry.high - entry.low) - 1.0


def adjustable(names: Iterable[str], limits: GaitLimits, ranges: Mapping[str, Sequence[float]]) -> tuple[Adjusted, ...]:
    """Outputs of a policy.

    Args:
        names: of gait inputs, of :data:`ADJUSTABLE`.
        ranges: (lowest, highest) by name where it is narrower than the limits.

    Raises:
        BadInput: no such input, one that is named twice, or a range that is empty or outside the limits.
    """
    names = tuple(names)
    for name in (*names, *ranges):
        if name not in ADJUSTABLE or names.count(name) != 1:
            raise BadInput("adjust", name, f"each once, of {', '.join(ADJUSTABLE)}")
    if not names:
        raise BadInput("adjust", "nothing", f"at least one of {', '.join(ADJUSTABLE)}")
    made = []
    for name in names:
        low, high = ranges.get(name, getattr(limits, name))
        made.append(Adjusted(name=name, low=low, high=high))
    _check_ranges(made, limits, "adjust")
    return tuple(made)


def _check_ranges(adjusted: Iterable[Adjusted], limits: GaitLimits, field: str) -> None:
    for entry in adjusted:
        lowest, highest = getattr(limits, entry.name)
        if not lowest <= entry.low < entry.high <= highest:
            given = f"{entry.low:g} to {entry.high:g}"
            raise BadInput(f"{field} {entry.name}", given, f"a range within {lowest:g} to {highest:g}")


def told(adjusted: Sequence[Adjusted], action: npt.NDArray[np.float64]) -> dict[str, float]:
    """Gait inputs of adjustments (m,); beyond ±1 they are cut off.

    Raises:
        BadInput: a number that is not finite.
    """
    if not np.all(np.isfinite(action)):
        raise BadInput("policy", action.tolist(), "finite numbers")
    shares = 0.5 * (1.0 + np.clip(action, -1.0, 1.0))
    return {
        entry.name: float(np.clip(entry.low + share * (entry.high - entry.low), entry.low, entry.high))
        for entry, share in zip(adjusted, shares, strict=True)
    }


class PolicyCommands:
    """Orders of a script, and at every touchdown what a policy adjusts.

    Args:
        script: gives speeds, and when to walk and stand.
        policy: made for its robot.
    """

    def __init__(self, script: Commands, controller: Controller, policy: StepPolicy) -> None:
        self._script, self._controller, self._policy = script, controller, policy
        self._view = StepView(controller, policy.card.adjusted)
        self._steps = 0.0

    def poll(self, time: float) -> Iterable[Order]:
        """Orders of this tick."""
        orders = list(self._script.poll(time))
        steps = float(self._controller.telemetry.step_count[0])
        if steps != self._steps:
            self._steps = steps
            if steps > 0.0:
                orders.append(Order(told(self._policy.card.adjusted, self._policy.act(self._view())), told=False))
        return orders


class OnnxPolicy:
    """A policy of an ONNX file.

    Raises:
        BadInput: no file, none that ONNX Runtime reads, made for other joints, other numbers or other ranges; or ONNX
            Runtime is not installed.
    """

    def __init__(self, path: str | Path, robot: Robot) -> None:
        content = read_bounded(Path(path), _LARGEST_FILE)
        try:
            import onnxruntime
        except ImportError:
            raise BadInput("policy", str(path), "ONNX Runtime to be installed", _INSTALL) from None
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 4
        source = Path(path).name
        try:
            session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
            described = json.loads(session.get_modelmeta().custom_metadata_map[KEY])
        except KeyError:
            valid = f"metadata {KEY}: joints, seen, adjusted"
            raise BadInput(source, "an ONNX file without them", valid, "gaitsmith.learning.write_policy") from None
        except Exception as error:  # of the engine; it has no base of its own
            raise BadInput(source, _first_line(error), "an ONNX file of a policy") from None
        self.card = checked(PolicyCard, described, source)
        self._session, self._source = session, source
        self._check(robot)

    def _check(self, robot: Robot) -> None:
        from gaitsmith.control import Controller  # compiled; reading a scenario does without

        source, card = self._source, self.card
        if card.joints != tuple(robot.joint_names):
            valid = f"{len(robot.joint_names)} joints of {robot.card.name}: {', '.join(robot.joint_names)}"
            raise BadInput(f"{source}: joints", ", ".join(card.joints), valid, "a policy that was trained on it")
        for entry in card.adjusted:
            if entry.name not in ADJUSTABLE:
                raise BadInput(f"{source}: adjusted", entry.name, f"of {', '.join(ADJUSTABLE)}")
        _check_ranges(card.adjusted, robot.card.gait_limits, f"{source}: adjusted")
        names = StepView(Controller(robot), card.adjusted).names
        if card.seen != names:
            pairs = zip(card.seen, names, strict=False)
            differs = next((f"{a} for {b}" for a, b in pairs if a != b), f"{len(card.seen)} numbers")
            raise BadInput(f"{source}: seen", differs, f"{len(names)} numbers: {', '.join(names)}")
        shapes = [[entry.shape[-1:] for entry in group] for group in (self._inputs(), self._session.get_outputs())]
        wanted = [[[len(names)]], [[len(card.adjusted)]]]
        if shapes != wanted:
            raise BadInput(
                f"{source}: shapes", shapes, f"one input of {len(names)}, one output of {len(card.adjusted)}"
            )
        told(card.adjusted, self.act(np.zeros(len(names))))  # whether it runs at all is found before a walk begins

    def _inputs(self) -> Any:
        return self._session.get_inputs()

    def act(self, seen: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """From what is seen (n,) to adjustments (m,).

        Raises:
            BadInput: the file's graph cannot be run.
        """
        name = self._inputs()[0].name
        try:
            (out,) = self._session.run(None, {name: seen.astype(np.float32)[None]})
        except Exception as error:  # of the engine; it has no base of its own
            raise BadInput(self._source, _first_line(error), "a graph that runs on one row of float32") from None
        return np.asarray(out, dtype=np.float64).reshape(len(self.card.adjusted))


def _first_line(error: Exception) -> str:
    return " ".join(str(error).split())[:200]
