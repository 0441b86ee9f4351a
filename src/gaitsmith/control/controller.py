"""The controller: one object, one ``tick`` from measurement to joint torques."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Arena
from gaitsmith.control.joint_torque import make_joint_feedback
from gaitsmith.control.layout import TickGroups
from gaitsmith.control.state import make_control_state, make_tick_gains
from gaitsmith.control.telemetry import Telemetry, make_telemetry
from gaitsmith.control.tick import tick
from gaitsmith.control.touchdown import make_touchdown_rule
from gaitsmith.dynamics.tree import make_tree_state, read_tree
from gaitsmith.errors import BadInput
from gaitsmith.estimation.estimator import make_estimator_gains, make_estimator_state
from gaitsmith.estimation.measurement import Measurement, make_measurement
from gaitsmith.kinematics.inverse import make_inverse_kinematics, make_leg_kinematics
from gaitsmith.qp.quadratic_program import make_quadratic_program
from gaitsmith.robots import Robot
from gaitsmith.robots.parameters import ControlParameters, GaitParameters, at_rest, check_gait
from gaitsmith.template.foothold import make_foothold_gains
from gaitsmith.template.step import make_gait, make_step_state
from gaitsmith.whole_body.forward_dynamics import make_motion_map
from gaitsmith.whole_body.frames import make_frames, make_legs
from gaitsmith.whole_body.solve import make_whole_body, problem_size
from gaitsmith.whole_body.targets import make_targets, make_task_gains

CONTROL_PERIOD = 1e-3


class Controller:
    """Gait template, inverse kinematics, whole-body QP and joint torque of one robot.

    Args:
        robot: from :func:`gaitsmith.load_robot`.
        preset: name of a preset of the robot's card, or the parameters themselves.
        state: ``"true"`` trusts the measured base and joint velocities; ``"estimated"`` uses the sensors only.
        gait: first gait; the card's default if None.

    Attributes:
        robot: the robot.
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
        self.parameters = _preset(robot, preset)
        self.gait = robot.card.gait if gait is None else gait
        check_gait(self.gait.model_dump(), robot.card.gait_limits)
        n_joints = len(robot.joint_names)
        nv = 6 + n_joints
        tree = read_tree(robot.model)
        estimated = state == "estimated"
        gains = self.parameters.joint_gains_estimated if estimated else self.parameters.joint_gains
        telemetry, self.telemetry_buffer, self.telemetry_columns = make_telemetry(robot.joint_names)
        left, right = robot.legs
        n_leg = len(left.joints)
        groups = TickGroups(
            tree=tree,
            tree_state=make_tree_state(tree),
            legs=make_legs(robot, tree),
            frames=make_frames(nv),
            requested=make_gait(self.gait),
            latched=make_gait(self.gait),
            step=make_step_state(),
            foothold=make_foothold_gains(self.parameters.foothold),
            touchdown=make_touchdown_rule(self.parameters.touchdown),
            gains=make_tick_gains(self.parameters, CONTROL_PERIOD),
            task_gains=make_task_gains(self.parameters),
            targets=make_targets(robot.torque_limit),
            motion=make_motion_map(nv, n_joints),
            whole_body=make_whole_body(nv, n_joints),
            program=make_quadratic_program(*problem_size(n_joints)),
            feedback=make_joint_feedback(gains),
            left_chain=make_leg_kinematics(robot, left),
            right_chain=make_leg_kinematics(robot, right),
            left_inverse=make_inverse_kinematics(n_leg),
            right_inverse=make_inverse_kinematics(n_leg),
            left_program=make_quadratic_program(n_leg, 0),
            right_program=make_quadratic_program(n_leg, 0),
            measurement=make_measurement(n_joints),
            control=make_control_state(robot, estimated),
            estimator_gains=make_estimator_gains(
                self.parameters.estimator,
                robot.imu_position,
                self.parameters.touchdown.force,
                robot.mass * float(np.linalg.norm(robot.model.opt.gravity)),
            ),
            estimator=make_estimator_state(n_joints),
            telemetry=telemetry,
        )
        self._arena = Arena(groups)
        self._groups = self._arena.view
        self._address = self._arena.address
        self.measurement: Measurement = self._groups.measurement
        self.telemetry: Telemetry = self._groups.telemetry
        self._torque = self._groups.control.torque
        self._initial = [[array.copy() for array in group] for group in self._memory()]
        self.reset()

    def reset(self) -> None:
        """Forget everything but the requested gait: at rest on both feet, counters at zero."""
        for group, initial in zip(self._memory(), self._initial, strict=True):
            for array, first in zip(group, initial, strict=True):
                array[...] = first
        whole_body = self._groups.whole_body
        for array in (whole_body.torque, whole_body.counts, whole_body.contact, whole_body.acceleration):
            array[...] = 0
        for program in (self._groups.program, self._groups.left_program, self._groups.right_program):
            program.active[...] = 0
        self._groups.control.standing_height[0] = self.gait.height
        for now, first in zip(self._groups.latched, self._groups.requested, strict=True):
            now[...] = first

    def _memory(self) -> tuple[Any, ...]:
        """Groups that a reset puts back to their first values."""
        return self._groups.step, self._groups.control, self._groups.estimator, self._groups.targets

    def command(self, **inputs: Any) -> None:
        """Change any of the gait's parameters; they take effect when the legs switch (Han 2023, section 2.3).

        Args:
            inputs: by name, as :class:`gaitsmith.robots.parameters.GaitParameters` has them; None leaves one as it is.

        Raises:
            BadInput: an unknown name, or a value outside the card's limits.
        """
        changes = {name: value for name, value in inputs.items() if value is not None}
        check_gait(changes, self.robot.card.gait_limits)
        gait = GaitParameters(**(self.gait.model_dump() | changes))
        self.gait = gait
        for now, value in zip(self._groups.requested, make_gait(gait), strict=True):
            now[...] = value

    def walk(self) -> None:
        """Start walking at the next tick; in place if the commanded speed is zero."""
        self._groups.step.walk_requested[0] = 1

    def stand(self) -> None:
        """Come to rest: command neither speed nor turning, and stay on both feet once slow enough."""
        self.command(**at_rest(self.gait.model_dump()))
        self._groups.step.walk_requested[0] = 0

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


def _preset(robot: Robot, preset: str | ControlParameters) -> ControlParameters:
    if isinstance(preset, ControlParameters):
        return preset
    presets = robot.card.presets
    if preset not in presets:
        raise BadInput("preset", preset, "one of " + ", ".join(sorted(presets)))
    return presets[preset]
