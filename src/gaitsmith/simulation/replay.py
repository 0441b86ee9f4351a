"""A fall run again with one suspect relaxed: does the robot stand without it?"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from gaitsmith.control import Controller
from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.documents import Frozen
from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.presets import ControlParameters
from gaitsmith.simulation.diagnosis import Suspect
from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.fall import Cause, Fall
from gaitsmith.simulation.orders import first_gait
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.sensors import SensorNoise

_LONGER = 5.0  # s that a run has to stand beyond the time of the fall, as far as the scenario goes
_NUDGE = 1e-9  # rad by which one joint differs at the start
_Run = tuple[Scenario, Robot, ControlParameters]
_Change = Callable[[Scenario, Robot, ControlParameters], _Run]


class Trial(Frozen):
    """One suspect and what became of the run without it.

    Attributes:
        kind, what: of the suspect.
        relaxed: what was changed, in words.
        stands: whether the robot stood beyond the time of the fall.
        fell_at: s; None if it stood.
    """

    kind: str
    what: str
    relaxed: str
    stands: bool
    fell_at: float | None


class Verdict(Frozen):
    """What replaying a fall has shown.

    Attributes:
        fall: as it was seen again.
        kind: of the cause.
        cause: the first suspect without which the robot stands; if there is none, the likeliest, not confirmed.
        trials: in the order tried.
        edge: whether the run as it was stands when one joint begins 1e-9 rad elsewhere: then little says much.
    """

    fall: Fall
    kind: str
    cause: Cause
    trials: tuple[Trial, ...]
    edge: bool


def _of_scenario(**changes: Any) -> _Change:
    return lambda scenario, robot, parameters: (scenario.model_copy(update=changes), robot, parameters)


def _of_parameters(group: str, **factors: float) -> _Change:
    """Parameters of one group, multiplied."""

    def change(scenario: Scenario, robot: Robot, parameters: ControlParameters) -> _Run:
        old = getattr(parameters, group)
        new = old.model_copy(update={name: factor * getattr(old, name) for name, factor in factors.items()})
        return scenario, robot, parameters.model_copy(update={group: new})

    return change


def _stronger(scenario: Scenario, robot: Robot, parameters: ControlParameters) -> _Run:
    return scenario, replace(robot, torque_limit=3.0 * robot.torque_limit), parameters


def _faster(scenario: Scenario, robot: Robot, parameters: ControlParameters) -> _Run:
    return scenario, replace(robot, velocity_limit=100.0 * robot.velocity_limit), parameters


def _level(scenario: Scenario, robot: Robot, parameters: ControlParameters) -> _Run:
    terrain = "flat" if scenario.terrain.startswith("ice") else scenario.terrain
    return scenario.model_copy(update={"friction": max(1.0, scenario.friction), "terrain": terrain}), robot, parameters


def _half(speed: tuple[float, float] | None) -> tuple[float, float] | None:
    return None if speed is None else (0.5 * speed[0], 0.5 * speed[1])


def _usual(scenario: Scenario, robot: Robot, parameters: ControlParameters) -> _Run:
    """The card's own gait, at half the commanded speed."""
    card = robot.card.gait.model_dump()
    others = {name: None for name in scenario.given() if name in card}
    changes = tuple(
        change.model_copy(update=dict.fromkeys(change.given()) | {"speed": _half(change.speed)})
        for change in scenario.changes
        if change.speed is not None
    )
    return scenario.model_copy(update=others | {"speed": _half(scenario.speed), "changes": changes}), robot, parameters


_RELAXED: dict[str, tuple[str, _Change]] = {
    "push": ("no push", _of_scenario(pushes=())),
    "fault": ("nothing fails", _of_scenario(faults=())),
    "reading": ("the true state", _of_scenario(state="true")),
    "friction": ("friction 1, no ice", _level),
    "terrain": ("level ground", _of_scenario(terrain="flat")),
    "delay": ("no delay", _of_scenario(torque_delay=0.0)),
    "mass": ("the card's masses", _of_scenario(mass_factor=1.0, mass_spread=0.0, torso_shift=(0.0, 0.0, 0.0))),
    "joint_friction": ("no joint friction", _of_scenario(joint_friction=0.0, joint_frictions={})),
    "noise": ("the usual sensor noise", _of_scenario(sensors=SensorNoise())),
    "estimated": ("the true state", _of_scenario(state="true")),
    "command": ("half the speed, the card's gait", _usual),
    "torque": ("torque limits × 3", _stronger),
    "reach": ("reach × 1.5", _of_parameters("foothold", reach=1.5)),
    "spread": ("spread × 1.5", _of_parameters("foothold", spread=1.5)),
    "separation": ("separation × 1.5", _of_parameters("foothold", separation=1.5)),
    "velocity": ("speed limits × 100", _faster),
    "lag": (
        "swing leg's gains × 4",
        _of_parameters("tracking", foot_stiffness=4.0, foot_damping=2.0, joint_stiffness=4.0, joint_damping=2.0),
    ),
    "slip": ("friction 1, no ice", _level),
    "legs": ("legs that pass through each other", lambda *given: given),
}


def why(
    scenario: Scenario, progress: Callable[[str], None] = lambda _: None, robot: Robot | None = None
) -> Verdict | None:
    """Run a fall again, then with each suspect relaxed in turn, until the robot stands; None if it does not fall.

    Args:
        scenario: as it was run.
        progress: told what is tried.
        robot: instead of loading the scenario's.
    """
    if scenario.controller:
        raise BadInput("controller", scenario.controller, "a run of the package's own controller", "its report is all")
    robot = robot or load_robot(scenario.robot)
    progress("the run as it was")
    run = Simulation(scenario, robot=robot, record=False)
    while run.step():
        pass
    if run.fall is None:
        return None
    until, listed, trials = run.fall.time + _LONGER, run.suspects(), []
    for trial in _trials(scenario, robot, listed, until, progress):
        trials.append(trial)
        if trial.stands:
            break
    progress("one joint 1e-9 rad elsewhere")
    edge = _fall_of(scenario, robot, None, until, nudge=_NUDGE) is None
    found = trials[-1] if trials and trials[-1].stands else None
    cause = Cause(what=found.what if found else listed[0].what, confirmed=found is not None)
    kind = found.kind if found else listed[0].kind
    return Verdict(fall=run.fall, kind=kind, cause=cause, trials=tuple(trials), edge=edge)


def _trials(
    scenario: Scenario, robot: Robot, listed: list[Suspect], until: float, progress: Callable[[str], None]
) -> Iterator[Trial]:
    """One suspect after the other; those that nothing relaxes are passed over."""
    parameters = preset_parameters(robot, robot_scale(robot), scenario.preset)
    for kind, what in dict.fromkeys(listed):
        if kind not in _RELAXED:
            continue
        relaxed, change = _RELAXED[kind]
        changed, stronger, other = change(scenario, robot, parameters)
        if kind != "legs" and (changed, stronger, other) == (scenario, robot, parameters):
            continue
        progress(f"{what}: {relaxed}")
        fell = _fall_of(changed, stronger, other, until, passing=kind == "legs")
        yield Trial(kind=kind, what=what, relaxed=relaxed, stands=fell is None, fell_at=fell)


def _fall_of(
    scenario: Scenario,
    robot: Robot,
    parameters: ControlParameters | None,
    until: float,
    nudge: float = 0.0,
    passing: bool = False,
) -> float | None:
    """When a run falls, s; None if it stands until then."""
    controller = None
    if parameters is not None:
        controller = Controller(robot, parameters, scenario.state, first_gait(scenario, robot))
    run = Simulation(scenario, robot=robot, controller=controller, record=False, passing=passing)
    if nudge:
        run.plant.q[7] += nudge
        run.plant.refresh()
    while run.time < until and run.step():
        pass
    return None if run.fall is None else run.fall.time
