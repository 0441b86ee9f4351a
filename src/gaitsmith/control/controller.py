"""The controller: one object, one ``tick`` from measurement to joint torques."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Arena
from gaitsmith.control.defaults import preset_parameters, robot_scale
from gaitsmith.control.state import DAMPING, FOLLOWING, OFF, STANDING, STATE_NAMES
from gaitsmith.control.storage import make_storage, memory_of
from gaitsmith.control.telemetry import Telemetry, make_telemetry
from gaitsmith.control.tick import tick
from gaitsmith.errors import BadInput
from gaitsmith.estimation.measurement import Measurement
from gaitsmith.planned.clock import PlanClock
from gaitsmith.planned.law import FollowParameters, make_following, restart_following
from gaitsmith.planned.replay import BY_CLOCK_ALONE
from gaitsmith.planned.table import Plan, PlanTable
from gaitsmith.robots import Robot
from gaitsmith.robots.parameters import GaitParameters, at_rest, check_gait, gait_numbers
from gaitsmith.robots.presets import ControlParameters
from gaitsmith.template.posture import commanded
from gaitsmith.template.step import make_gait_inputs

TRACKINGS = ("whole-body", "replay")
_BELIEVED = 20  # ticks


class Controller:
    """Gait template, inverse kinematics, whole-body QP and joint torque of one robot.

    Args:
        robot: from :func:`gaitsmith.load_robot`.
        preset: name of a preset of the robot's card, or the parameters themselves.
        state: ``"true"`` trusts the measured base and joint velocities; ``"estimated"`` uses the sensors only.
        gait: first gait; the card's default if None.

    Attributes:
        robot: the robot.
        scale: its own units of length, time and mass.
        parameters: of the preset, SI units.
        gait: the inputs last commanded.
        estimated: whether the state is estimated from sensors.
        plan: that was loaded, None without one.
        reference: what the last tick asked of the whole body; views.
        sole_pitch: (n,) of every sole, toe down positive, as the last tick saw it, rad; a view.
        measurement: preallocated; fill it before :meth:`tick`.
        telemetry: views of what the last tick did, over ``telemetry_buffer``.
        telemetry_buffer: (n,) the same numbers in one array.
        telemetry_columns: name of every entry of ``telemetry_buffer``.

    Raises:
        BadInput: unknown preset or state, or a gait outside the card's limits.
    """

    def __init__(
        self,
        robot: Robot,
        preset: str | ControlParameters = "default",
        state: Literal["true", "estimated"] = "true",
        gait: GaitParameters | None = None,
    ) -> None:
        if state not in ("true", "estimated"):
            raise BadInput("state", state, "true or estimated")
        self.robot = robot
        self.scale = robot_scale(robot)
        self.parameters = preset_parameters(robot, self.scale, preset) if isinstance(preset, str) else preset
        self.gait = robot.card.gait if gait is None else gait
        self.estimated = state == "estimated"
        self.plan: Plan | None = None
        self._replays = False
        check_gait(self.gait.model_dump(), robot.card.gait_limits)
        soles = tuple(leg.name for leg in robot.legs)
        inputs = tuple(name for name, _, _ in gait_numbers(self.gait.model_dump()))
        telemetry, self.telemetry_buffer, self.telemetry_columns = make_telemetry(robot.joint_names, soles, inputs)
        self._arena = Arena(make_storage(robot, self.scale, self.parameters, self.gait, self.estimated, telemetry))
        self._g = self._arena.view
        self._address = self._arena.address
        self.measurement: Measurement = self._g.measurement
        self.telemetry: Telemetry = self._g.telemetry
        self._torque = self._g.control.torque
        self.reference = self._g.reference
        self.sole_pitch = self._g.body.frames.sole_pitch
        self._initial = [[array.copy() for array in group] for group in memory_of(self._g)]
        self.reset()

    def reset(self) -> None:
        """Forget everything but the requested gait: at rest on both feet, counters at zero."""
        for group, initial in zip(memory_of(self._g), self._initial, strict=True):
            for array, first in zip(group, initial, strict=True):
                array[...] = first
        template = self._g.template
        template.step.standing_height[0] = self.gait.height
        for inputs in (template.requested.values, template.latched.values, self._g.control.mailbox):
            inputs[...] = make_gait_inputs(self.gait).values

    @property
    def state(self) -> str:
        """Control state after the last tick: off, damping, standing, walking, fault or airborne."""
        return STATE_NAMES[int(self._g.control.state[0])]

    def command(self, **inputs: Any) -> None:
        """Change any of the gait's parameters; they take effect when the legs switch (Han 2023, section 2.3).

        All that one call changes is taken over at once, also if a tick runs meanwhile in another thread.

        Args:
            inputs: by name, as :class:`gaitsmith.robots.parameters.GaitParameters` has them; None leaves one as it is.

        Raises:
            BadInput: an unknown name, or a value outside the card's limits.
        """
        self._refuse_while_following("command", inputs)
        changes = {name: value for name, value in inputs.items() if value is not None}
        check_gait(changes, self.robot.card.gait_limits)
        self.gait = GaitParameters(**(self.gait.model_dump() | changes))
        control = self._g.control
        control.letters[0] += 1
        control.mailbox[...] = make_gait_inputs(self.gait).values
        control.letters[0] += 1

    def posture(self, angles: Mapping[str, float], rates: Mapping[str, float] | None = None) -> None:
        """Command joints outside the legs, while the legs stand or walk; each moves there smoothly and stays.

        All that one call changes is taken over at once; joints that it does not name keep what they were told.

        Args:
            angles: by joint, rad.
            rates: greatest speeds on the way, by joint, rad/s; a joint's velocity limit where not given.

        Raises:
            BadInput: no joint outside the legs, an angle or rate outside the joint's limits, or a plan is followed.
        """
        self._refuse_while_following("posture", dict(angles))
        mailbox, letters = self._g.template.posture.mailbox, self._g.control.letters
        goal = commanded(mailbox, self.robot, angles, rates or {})
        letters[0] += 1
        mailbox[...] = goal
        letters[0] += 1

    def load(self, plan: Plan, tracking: str = "whole-body", parameters: FollowParameters | None = None) -> None:
        """Make ready to :meth:`follow` a plan.

        Args:
            plan: of this robot.
            tracking: ``whole-body``, or ``replay`` by the joints alone.
            parameters: of the law; None for the default ones.

        Raises:
            BadInput: a plan for another robot, an unknown tracking, or a plan that is followed now and has not ended.
        """
        if tracking not in TRACKINGS:
            raise BadInput("tracking", tracking, " or ".join(TRACKINGS))
        self._refuse_while_following("load", plan.name)
        replays = tracking == "replay"
        turns = bool(self._g.control.turns[0])
        following = make_following(self.robot, plan, BY_CLOCK_ALONE if replays else parameters, turns)
        if any(a.shape[1:] != b.shape[1:] for a, b in zip(following.plan[4:], self._g.following.plan[4:], strict=True)):
            raise BadInput("plan", plan.name, f"a plan for {self.robot.card.name}")
        self._arena = Arena(self._g._replace(following=following))
        self._g, self._address = self._arena.view, self._arena.address
        self.plan, self._replays = plan, replays

    def follow(self) -> None:
        """Follow the plan that was loaded, from the next tick on; its x axis is where its first support sole points to.

        The robot stands in the plan's first posture, or moves as the plan begins.

        Raises:
            BadInput: no plan was loaded, or it runs.
        """
        self._begin()

    def rest(self) -> None:
        """Stay as the plan that was loaded ends, from the next tick on.

        Raises:
            BadInput: no plan was loaded, it runs, or it does not end at rest.
        """
        if self.plan is not None and not self.plan.at_rest[1]:
            raise BadInput("rest", self.plan.name, "a plan that ends at rest")
        plan = self._begin()
        clock, last = self.plan_clock, len(plan.sequence) - 1
        clock.visit[0], clock.time[0], clock.ended[0] = last, plan.duration[plan.sequence[last]], 1

    def leave_loop(self) -> None:
        """Go on to what comes after the plan's loop as soon as the present pass of it is over."""
        self._passes[0] = self.plan_clock.pass_number[0] + 1

    @property
    def _passes(self) -> npt.NDArray[np.int64]:
        """(1,) how often the plan's loop is gone through; a view."""
        return np.asarray(self._g.following.plan.passes)

    def _begin(self) -> PlanTable:
        """Put the plan to its beginning, and ask for it."""
        if self.plan is None:
            raise BadInput("follow", "no plan", "a plan that was loaded", "load(plan) first")
        self._refuse_while_following("follow", self.plan.name)
        restart_following(self._g.following)
        self._passes[0] = self.plan.table.passes
        self._g.control.replays[0] = int(self._replays)
        self._g.control.asked[0] = FOLLOWING
        self._g.whole_body.solution.fresh[0], self._g.control.sent[0] = 1, 0
        return self.plan.table

    @property
    def plan_clock(self) -> PlanClock:
        """Where the plan is; views."""
        clock: PlanClock = self._g.following.clock
        return clock

    @property
    def plan_ended(self) -> bool:
        """Whether a plan was followed to its end."""
        return bool(self._g.following.clock.ended[0])

    @property
    def follows(self) -> bool:
        """Whether a plan is followed that has not ended."""
        return bool(self._g.control.asked[0] == FOLLOWING and self._g.following.clock.ended[0] == 0)

    def _refuse_while_following(self, field: str, value: object) -> None:
        if self.plan is not None and self.follows:
            raise BadInput(field, value, f"nothing while {self.plan.name} runs", "wait for its end, or damp()")

    def walk(self) -> None:
        """Start walking at the next tick; in place if the commanded speed is zero."""
        self._refuse_while_following("walk", True)
        self._g.control.asked[0] = STANDING
        self._g.template.step.walk_requested[0] = 1

    def stand(self) -> None:
        """Come to rest: command neither speed nor turning, and stay on both feet once slow enough."""
        self.command(**at_rest(self.gait.model_dump()))
        self._g.control.asked[0] = STANDING
        self._g.template.step.walk_requested[0] = 0

    def damp(self) -> None:
        """Brake all joints and do nothing else, until :meth:`stand` or :meth:`walk`."""
        self._g.control.asked[0] = DAMPING
        self._g.template.step.walk_requested[0] = 0

    def off(self) -> None:
        """Take the torque away, until :meth:`stand` or :meth:`walk`."""
        self._g.control.asked[0] = OFF
        self._g.template.step.walk_requested[0] = 0

    @property
    def planned_landing(self) -> tuple[int, int, npt.NDArray[np.float64]]:
        """Stance leg, swing leg, and where the swing sole will land: from the stance sole, heading frame, m; a view."""
        stance = int(self._g.template.step.stance[0])
        return stance, int(self._g.body.legs.other[stance]), self._g.template.ground.planned

    def see(self, shift: npt.ArrayLike, rise: float, highest: float) -> None:
        """Tell the ground at the next landing: believed for 20 ticks, after which the walk goes on by what it feels.

        Args:
            shift: (2,) how much farther than :attr:`planned_landing` to land, heading frame, m.
            rise: height of the ground there above the stance sole, m.
            highest: greatest height on the way there above the stance sole, m.

        Raises:
            BadInput: a number that is not finite.
        """
        told = (*np.asarray(shift, dtype=np.float64), rise, highest)
        if len(told) != 4 or not np.isfinite(told).all():
            raise BadInput("ground", told, "finite numbers: a shift (2), a rise and the highest ground, m")
        ground = self._g.template.ground
        ground.shift[:], ground.rise[0], ground.highest[0] = told[:2], rise, highest
        ground.known[0] = _BELIEVED

    def missed(self, ticks: int) -> None:
        """Say that this many ticks could not be done in time; after too many in a row the joints are braked.

        Args:
            ticks: since the last one, 0 or more.
        """
        self._g.checking.readings.late[0] = ticks

    def tick(self, measurement: Measurement | None = None) -> npt.NDArray[np.float64]:
        """Advance by one control period.

        Args:
            measurement: sensor readings; None if ``self.measurement`` has been filled in place.

        Returns:
            (nj,) joint torques, N·m, inside the limits and never NaN; a view that the next tick overwrites.
        """
        if measurement is not None and measurement is not self.measurement:
            for kept, given in zip(self.measurement, measurement, strict=True):
                kept[...] = given
        tick(self._address)
        return self._torque
