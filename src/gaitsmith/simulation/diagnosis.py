"""Why a robot fell: what disturbed it since its last undisturbed step, the likeliest first.

What comes from outside goes before what the robot's own limits did about it: whoever is pushed hard enough hits them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from gaitsmith.simulation.library_run import plans_for_slopes
from gaitsmith.simulation.limits import MISTAKEN
from gaitsmith.simulation.reactions import Reaction
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.simulation.sensors import SensorNoise
from gaitsmith.simulation.terrain import SLOPE_START, parse_terrain

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gaitsmith.robots import Robot

_BEFORE = 0.6  # s before the first limit in which a disturbance counts as its cause
_WEAK, _FAST = 0.1, 0.3  # m√(gH), √(gH): pushes below, and speeds up to which, any walk withstands
_AFTER_PUSH = 3.0  # s for which a push may be felt
_NOT_READ = ("balance", "controller")  # of what reactions are about
_NEAR = 0.4  # m before a slope at which a foot may already stand on it
_NOISY = 3.0  # times the usual noise
_USUAL_FRICTION, _SMALL_DELAY, _SMALL_MASS = 0.6, 1.5e-3, 0.03
OWN_LIMITS = {
    "torque of": "torque",
    "foothold at its reach": "reach",
    "foothold at its spread": "spread",
    "foothold at its separation": "separation",
    "foot behind": "lag",
    "legs touching": "legs",
    "speed limit": "velocity",
    "joint limit": "position",
    "ZMP": "zmp",
    "friction limit": "slip",
    "sole slipping": "slip",
    "whole-body QP": "qp",
    "ended by the clock": "clock",
}
"""Kinds of limits by what their names contain."""


class Suspect(NamedTuple):
    """What may have caused a fall: a kind that :mod:`gaitsmith.simulation.replay` can relax, and words."""

    kind: str
    what: str


def suspects(
    scenario: Scenario,
    hits: Sequence[tuple[str, float]],
    pushes: Sequence[float | None],
    reactions: Sequence[Reaction],
    place: float,
    fell: float,
    robot: Robot | None = None,
) -> list[Suspect]:
    """What may have caused a fall, the likeliest first.

    Args:
        scenario: what was run.
        hits: limits since the last undisturbed step and when, s, oldest first.
        pushes: when each began, s; None if it did not.
        reactions: of the controller.
        place: x of the torso when it was upright last, m.
        fell: s.
        robot: whose size says which pushes are less likely than uneven ground or a plant that differs, and which
            commands less likely than a limit; None: none are.
    """
    weak, fast = (0.0, 0.0) if robot is None else (_WEAK * robot.mass * _speed_unit(robot), _FAST * _speed_unit(robot))
    onset = min([when for _, when in hits], default=fell)
    stopped = [Suspect("controller", f"the controller {e.type}") for e in reactions if e.component == "controller"]
    pushed = [_pushed(scenario, pushes, onset, fell, *span) for span in ((weak, math.inf), (0.0, weak))]
    found = [*stopped, *_failed(scenario, onset, fell), *pushed[0]]
    found += _noise(scenario)
    slips = [(name, when) for name, when in hits if "slipping" in name]
    slippery = scenario.friction < _USUAL_FRICTION or scenario.terrain.startswith("ice")
    believed = _believed(scenario, hits, reactions, onset, fell)
    first = slips and slippery and (not believed or slips[0][1] <= believed[0][1])
    found += [_friction(scenario, slips)] if first else []
    found += [suspect for suspect, _ in believed]
    if slips and slippery and not first:
        found.append(_friction(scenario, slips))
    found += _ground(scenario, place)
    found += [*_plant(scenario), *pushed[1]]
    if slippery and not slips:
        found.append(_friction(scenario, slips))
    if not believed:
        found += _noticed(scenario, reactions, onset, fell)
    if scenario.state == "estimated" and not believed:
        found.append(Suspect("estimated", "state estimated from noisy sensors"))
    commanded, asks = _commanded(scenario, fell, fast)
    limits = _limits([hit for hit in hits if not slippery or "slipping" not in hit[0]])
    found += [*commanded, *limits] if asks else [*limits, *commanded]
    return found or [Suspect("none", "nothing that is known")]


def _failed(scenario: Scenario, onset: float, fell: float) -> list[Suspect]:
    """Faults of the scenario that were on."""
    found = []
    for fault in scenario.faults:
        if fault.time <= fell and fault.time + fault.duration >= onset - _BEFORE:
            found.append(Suspect("fault", f"{fault.component} {fault.type} from {fault.time:.3f} s on"))
    return found


def _noticed(scenario: Scenario, reactions: Sequence[Reaction], onset: float, fell: float) -> list[Suspect]:
    """What the controller noticed by itself, if nothing was made to fail: a cause, or how something else shows."""
    seen = [e for e in reactions if onset - _BEFORE <= e.time <= fell and e.component not in _NOT_READ]
    if scenario.faults or not seen:
        return []
    return [Suspect("reading", f"{seen[0].component}, {seen[0].type} at {seen[0].time:.3f} s")]


def _believed(
    scenario: Scenario, hits: Sequence[tuple[str, float]], reactions: Sequence[Reaction], onset: float, fell: float
) -> list[tuple[Suspect, float]]:
    """What the estimated state was wrong about well before the fall, the first first, and when, s.

    A speed that is far from the true one, or sensors taken for broken; what comes while it falls does not count.
    """
    if scenario.state != "estimated" or scenario.faults:
        return []
    wrong = [(Suspect("estimated", f"{name} at {when:.3f} s"), when) for name, when in hits if name == MISTAKEN]
    for e in reactions:
        if e.time >= onset - _BEFORE and e.component not in _NOT_READ and not e.component.endswith(".motor"):
            wrong.append((Suspect("reading", f"{e.component}, {e.type} at {e.time:.3f} s"), e.time))
            break
    return sorted([entry for entry in wrong if entry[1] <= fell - _BEFORE], key=lambda entry: entry[1])


def _speed_unit(robot: Robot) -> float:
    """√(gH), m/s."""
    return math.sqrt(-float(robot.model.opt.gravity[2]) * robot.card.gait.height)


def _pushed(
    scenario: Scenario, pushes: Sequence[float | None], onset: float, fell: float, least: float, most: float
) -> list[Suspect]:
    """Pushes of at least one and less than another size, N·s, the latest first."""
    found = []
    for push, began in zip(scenario.pushes, pushes, strict=False):
        if began is not None and began <= fell and began + push.duration >= onset - _AFTER_PUSH:
            size = sum(part * part for part in push.impulse) ** 0.5
            if least <= size < most:
                found.append((began, Suspect("push", f"push of {size:.1f} N·s at {began:.3f} s")))
    return [suspect for _, suspect in sorted(found, key=lambda entry: -entry[0])]


def _friction(scenario: Scenario, slips: Sequence[tuple[str, float]]) -> Suspect:
    ground = scenario.terrain if scenario.terrain.startswith("ice") else f"friction {scenario.friction:g}"
    return Suspect(
        "friction", f"slippery ground, {ground}" + (f": {slips[0][0]} at {slips[0][1]:.3f} s" if slips else "")
    )


def _noise(scenario: Scenario) -> list[Suspect]:
    """Sensors that are far noisier than the usual ones: what is estimated from them, and blamed in them, follows."""
    given, usual = scenario.sensors.model_dump(), SensorNoise().model_dump()
    loud = {name: value for name, value in given.items() if value > _NOISY * usual[name]}
    if scenario.state != "estimated" or not loud:
        return []
    return [Suspect("noise", "sensor noise: " + ", ".join(f"{name} {value:g}" for name, value in loud.items()))]


def _ground(scenario: Scenario, place: float) -> list[Suspect]:
    """Ground that is not level, if the robot has come to it."""
    terrain = parse_terrain(scenario.terrain, scenario.seed)
    words = {"slope": f"slope of {terrain.amount:g}°", "cross": f"slope across of {terrain.amount:g}°"}
    if terrain.kind in words and place > SLOPE_START - _NEAR and terrain.amount != 0.0:
        return [Suspect("terrain", words[terrain.kind])]
    if terrain.kind == "ramp" and terrain.amount != 0.0 and not plans_for_slopes(scenario):
        return [Suspect("terrain", f"ground that rises by {terrain.amount:g}°")]
    if terrain.kind == "boxes" and terrain.amount > 0.0:
        return [Suspect("terrain", f"boxes of {terrain.amount:g} m")]
    return []


def _plant(scenario: Scenario) -> list[Suspect]:
    """A plant that is not what the controller takes it for."""
    found = []
    if scenario.torque_delay > _SMALL_DELAY:
        found.append(Suspect("delay", f"torque delay of {1000 * scenario.torque_delay:g} ms"))
    if abs(scenario.mass_factor - 1.0) > _SMALL_MASS or scenario.mass_spread > _SMALL_MASS:
        found.append(Suspect("mass", f"masses × {scenario.mass_factor:g} ± {100 * scenario.mass_spread:g} %"))
    elif any(scenario.torso_shift):
        x, y, z = scenario.torso_shift
        found.append(Suspect("mass", f"torso's centre of mass off by {x:g}, {y:g}, {z:g} m"))
    if scenario.joint_friction > 0.0 or scenario.joint_frictions:
        found.append(Suspect("joint_friction", f"joint friction of {scenario.joint_friction:g} N·m"))
    return found


def _commanded(scenario: Scenario, fell: float, fast: float) -> tuple[list[Suspect], bool]:
    """What was commanded besides the card's gait; whether it asks for much, more than a speed below ``fast``, m/s."""
    given = [(0.0, scenario.given()), *((change.time, change.given()) for change in scenario.changes)]
    latest: dict[str, object] = {}
    for when, inputs in given:
        latest |= inputs if when <= fell else {}
    words = ", ".join(f"{name} {_shown(value)}" for name, value in latest.items())
    speed = latest.get("speed", (0.0, 0.0))
    asks = latest.keys() != {"speed"} or (isinstance(speed, tuple) and math.hypot(*speed) >= fast)
    return [Suspect("command", f"commanded gait: {words}")] if words else [], asks


def _shown(value: object) -> str:
    return " ".join(f"{part:g}" for part in value) if isinstance(value, tuple) else f"{value:g}"


def _limits(hits: Sequence[tuple[str, float]]) -> list[Suspect]:
    """The robot's own limits, each kind once, the first first; a ZMP at the edge says least."""
    found: dict[str, Suspect] = {}
    for name, when in hits:
        kind = next((kind for part, kind in OWN_LIMITS.items() if part in name), None)
        if kind is not None and kind not in found:
            found[kind] = Suspect(kind, f"{name} at {when:.3f} s")
    return sorted(found.values(), key=lambda suspect: suspect.kind == "zmp")
