"""What the figures draw: plain arrays of one run, read from its log."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gaitsmith.log import Log
from gaitsmith.robots import Robot

Array = npt.NDArray[np.float64]
_UNUSUAL = (
    ("friction", 0.8, "friction {:g}"),
    ("mass_factor", 1.0, "masses times {:g}"),
    ("mass_spread", 0.0, "masses within {:.0%}"),
    ("torso_shift", [0.0, 0.0, 0.0], "torso's centre of mass moved"),
    ("engine", "mujoco", "physics of {}"),
    ("footholds", "", "known ground"),
    ("library", "", "a library's gaits"),
    ("policy", "", "a policy"),
    ("controller", "", "another controller"),
)
"""What is told where a run differs: the scenario's field, its default, and words."""
_SIDES, _AXES = ("left", "right"), ("x", "y", "z")


class Stage(NamedTuple):
    """Stretch of constant commanded speed: begin and end (s), forward and lateral speed (m/s)."""

    begin: float
    end: float
    speed_x: float
    speed_y: float


class PushMark(NamedTuple):
    """A push: when it began and ended, s, impulse (3,), world, N·s (0 if nobody has written it down), and in words."""

    begin: float
    end: float
    impulse: tuple[float, ...]
    words: str


class FaultMark(NamedTuple):
    """A fault: when it began and ended, s, and in words."""

    begin: float
    end: float
    words: str


class Recording:
    """One run, sampled at n instants; SI units, radians.

    Args:
        log: of the run; speed, attitude and places are the true ones, or those believed where nobody knew the truth.
        robot: that walked; gives joint names, limits and soles.
        ticks: durations of control ticks, µs, from short to long, and how many took so long, if they are known.
        fell: when the robot fell, s; None for one that did not.

    Attributes:
        title: the robot, for the figures' titles.
        conditions: gait, preset, state, ground and seed, for the line below, and what is not usual.
        pushes, faults: when they acted.
        time: (n,) s.
        speed_command, speed: (n, 2) forward and lateral, of the CoM in the heading frame, m/s.
        tilt: (n, 2) roll and pitch of the torso, rad.
        yaw: (n,) rad.
        height_command, height: (n,) hip midpoint above the stance sole, m.
        stance: (n,) 0 left, 1 right, 2 both.
        joint_desired, joint_position: (n, nj) rad.
        torque: (n, nj) N·m.
        foot_desired, foot_actual: (n, 6) left and right sole relative to the hip midpoint, heading frame, m.
        sole_position: (n, 6) left and right sole frame, world, m.
        torso_position: (n, 2) world, m.
        zmp: (n, 4) planned, x and y in the left and the right sole frame, m.
        walking: (n,) whether the gait template walks.
        foothold: (n, 2) where the swing sole is told to land, hip midpoint, heading frame, m.
        foothold_bound: (n,) whether that lies on one of its bounds.
        sole_force: (n, 2) true normal force on the left and the right sole, N.
        leg_contact, body_contact: (n,) contacts between the legs, and of other bodies than feet with the ground.
        qp_fallbacks: (n,) ticks so far in which the whole-body QP fell back.

    Raises:
        BadInput: a column is missing from the log.
    """

    def __init__(
        self,
        log: Log,
        robot: Robot,
        ticks: tuple[Array, npt.NDArray[np.int64]] = (np.zeros(0), np.zeros(0, dtype=np.int64)),
        fell: float | None = None,
    ) -> None:
        def columns(*names: str) -> Array:
            return np.column_stack([log.column(name) for name in names])

        def per_joint(field: str) -> Array:
            return columns(*(f"{field}.{name}" for name in robot.joint_names))

        true = "true." if "true.torso_yaw" in log.columns else "believed."
        ends = [f"{side}.{axis}" for side in _SIDES for axis in _AXES]
        left, right = log.column(true + "hip_height_left"), log.column(true + "hip_height_right")
        self.robot, self.title, self.time, self.fell = robot, robot.card.name, log.time, fell
        self.conditions, self.pushes = _conditions(log.notes), pushes_of(log)
        self.faults = tuple(
            FaultMark(fault["time"], fault["time"] + fault["duration"], f"{fault['component']} {fault['type']}")
            for fault in (log.notes.get("scenario") or {}).get("faults", ())
        )
        self.tick_us, self.tick_counts = ticks
        self.speed_command = columns("command.speed_x", "command.speed_y") * (log.column("mode") != 0.0)[:, None]
        self.speed = columns(true + "com_velocity_x", true + "com_velocity_y")
        self.tilt = columns(true + "torso_roll", true + "torso_pitch")
        self.yaw = log.column(true + "torso_yaw")
        self.stance = log.column("stance")
        self.height_command = log.column("command.height")
        self.height = np.choose(np.clip(self.stance, 0, 2).astype(int), [left, right, 0.5 * (left + right)])
        self.joint_desired, self.joint_position = per_joint("joint_desired"), per_joint("joint_position")
        self.torque = per_joint("torque")
        self.foot_desired = columns(*(f"foot_desired.{end}" for end in ends))
        self.foot_actual = columns(*(f"foot_actual.{end}" for end in ends))
        self.sole_position = columns(*(f"{true}{side}_sole_{axis}" for side in _SIDES for axis in _AXES))
        self.torso_position = columns(true + "torso_x", true + "torso_y")
        self.zmp = columns("zmp.left.x", "zmp.left.y", "zmp.right.x", "zmp.right.y")

        self.walking = log.column("mode") == 1.0
        self.foothold = columns("foothold.x", "foothold.y")
        self.foothold_bound = log.column("foothold_bound") != 0.0
        self.sole_force = columns(*(f"{true}{side}_force" for side in _SIDES))
        self.leg_contact, self.body_contact = log.column(true + "leg_contact"), log.column(true + "body_contact")
        self.qp_fallbacks = log.column("qp_fallbacks")

    def stages(self) -> list[Stage]:
        """Stretches of constant commanded speed, in order."""
        changes = np.any(np.diff(self.speed_command, axis=0) != 0.0, axis=1)
        starts = [0, *(np.flatnonzero(changes) + 1).tolist()]
        ends = [*starts[1:], len(self.time) - 1]
        return [
            Stage(float(self.time[a]), float(self.time[b]), *map(float, self.speed_command[a]))
            for a, b in zip(starts, ends, strict=True)
        ]

    def window(self, length: float) -> slice:
        """The last ``length`` seconds of the fastest commanded stage, where a gait shows best."""
        fastest = max(self.stages(), key=lambda stage: (np.hypot(stage.speed_x, stage.speed_y), stage.end))
        begin, end = np.searchsorted(self.time, [max(fastest.begin, fastest.end - length), fastest.end])
        return slice(int(begin), max(int(end), int(begin) + 2))


def _conditions(notes: dict[str, Any]) -> str:
    """What was run, in a line: the gait's numbers, then what is not usual."""
    gait, run = notes.get("gait") or {}, notes.get("scenario") or {}
    changed = {name for change in run.get("changes", ()) for name, value in change.items() if value is not None}
    signs = {"period": ("T", "s"), "height": ("H", "m"), "lift": ("lift", "m"), "width": ("W", "m")}
    words = [
        f"{sign} {gait[name]:g} {unit}" + (" at first" if name in changed else "")
        for name, (sign, unit) in signs.items()
        if name in gait and not run.get("gait")
    ]
    words += [f"{run[name]} {what}" for name, what in (("state", "state"), ("terrain", "ground")) if name in run]
    words += [f"preset {run['preset']}"] if "preset" in run else []
    uneven = (run.get("joint_frictions") or {}).values()
    for name, unit in (("joint_friction", "N·m of joint friction"), ("torque_delay", "s of torque delay")):
        words += [f"{run[name]:g} {unit}"] if run.get(name) else []
        words += [f"up to {max(uneven):g} in some"] if name == "joint_friction" and uneven else []
    words += [told.format(run[name]) for name, usual, told in _UNUSUAL if run.get(name, usual) not in (usual, None)]
    return ", ".join(words + ([f"seed {run['seed']}"] if "seed" in run else []))


def pushes_of(log: Log) -> tuple[PushMark, ...]:
    """Pushes that a log tells of: those of the scenario, and those of somebody who steered."""
    asked, begun = (log.notes.get("scenario") or {}).get("pushes", ()), dict[int, tuple[float, float, dict[str, Any]]]()
    for event in log.events:
        number, time = event.get("push"), float(event["time"])
        if number is None:
            continue
        if not event.get("over"):
            given = asked[number] if 0 <= number < len(asked) else event
            begun[number] = (time, time + given.get("duration", float(log.time[-1]) - time), given)
        elif number in begun:
            begun[number] = (begun[number][0], time, begun[number][2])
    found = []
    for begin, end, given in begun.values():
        impulse = np.array(given.get("impulse", (end - begin) * np.array(given.get("force", (0.0, 0.0, 0.0)))))
        words = f"{float(np.linalg.norm(impulse)):.3g} N·s" if impulse.any() else "by hand"
        found.append(PushMark(begin, end, tuple(impulse.tolist()), words))
    return tuple(found)
