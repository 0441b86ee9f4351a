"""A robot in any state under any reference, and MuJoCo's view of the same state."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt
from tests.control.walking import DT, parameters, robot

from gaitsmith.compiled import Arena
from gaitsmith.control.gains import make_gains
from gaitsmith.dynamics.algorithms import update_dynamics
from gaitsmith.dynamics.tree import read_tree
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import Robot
from gaitsmith.whole_body.contact import ContactBounds
from gaitsmith.whole_body.frames import make_body, observe_frames
from gaitsmith.whole_body.legs import make_legs
from gaitsmith.whole_body.problem import JointBounds, make_whole_body
from gaitsmith.whole_body.reference import FLAT, HEEL, NONE, TOE, make_reference
from gaitsmith.whole_body.solve import solve_whole_body
from gaitsmith.whole_body.tasks import Task, TaskTable

Array = npt.NDArray[np.float64]

CONTACTS = ((FLAT, FLAT), (FLAT, NONE), (NONE, FLAT), (FLAT, HEEL), (TOE, FLAT), (NONE, HEEL), (TOE, NONE), (TOE, HEEL))
UNBOUNDED = JointBounds(torque_step=np.inf, stop_rate=1e6)


class Body:
    """Everything that the whole-body QP reads and writes, of one robot.

    Args:
        name: of the robot.
        machine: instead of it, a variant of it.
        **tasks: tasks or weights of the table that differ from the default preset's.
    """

    def __init__(self, name: str, machine: Robot | None = None, **tasks: Any) -> None:
        self.robot, self.parameters = machine or robot(name), parameters(name)
        self.name, self.nj, self.n = name, len(self.robot.joint_names), len(self.robot.legs)
        gains = make_gains(self.parameters, DT)
        self.tasks: TaskTable = gains["tasks"]._replace(**tasks)
        self.bounds: ContactBounds = gains["contact_bounds"]
        self.joints: JointBounds = gains["joint_bounds"]
        self.seen = make_body(read_tree(self.robot.model), make_legs(self.robot))
        self.tree, self.state, self.legs, self.frames, self.q, self.v = self.seen
        self.reference = make_reference(self.n, self.nj)
        self.problem = make_whole_body(self.seen, self.reference, self.bounds, self.joints)
        self.contacts, self.motion, self.program = self.problem.contacts, self.problem.motion, self.problem.program
        self.result = self.problem.solution
        self.q[:] = standing(name)

    def place(self, q: Array, v: Array) -> Body:
        """Put the robot into a state; every reference is that state, at rest."""
        self.q[:], self.v[:] = q, v
        update_dynamics(self.tree, self.state, self.q, self.v)
        observe_frames(Arena(self.seen._replace(legs=self.legs)))
        reference, frames = self.reference, self.frames
        reference.sole_position[:], reference.sole_rotation[:] = frames.sole_position, frames.sole_rotation
        reference.torso_rotation[:] = self.state.body_rotation[self.legs.torso[0]]
        reference.com[:], reference.com[0] = 0.0, self.state.com
        reference.hip_height[:] = frames.hip_position[2], 0.0, 0.0
        reference.joint[:], reference.joint[0] = 0.0, self.q[7:]
        return self

    def solve(self, *kinds: int, fresh: bool = True) -> bool:
        """Solve with these contacts; whether it was solved."""
        self.reference.contact[:] = kinds
        self.result.fresh[0] = int(fresh)
        seen = self.seen._replace(legs=self.legs)
        problem = self.problem._replace(body=seen, contact_bounds=self.bounds, joint_bounds=self.joints)
        return solve_whole_body(Arena(problem), Arena(self.tasks))


@cache
def standing(name: str) -> Array:
    """Standing posture of the card's gait."""
    gait = robot(name).card.gait
    return standing_posture(robot(name), gait.height, gait.width)


def moving(name: str, seed: int, share: float = 1.0) -> tuple[Array, Array]:
    """A random state: near the standing posture, turned, tilted and moving."""
    rng = np.random.default_rng(seed)
    q, nv = standing(name), robot(name).model.nv
    tangent = share * rng.normal(size=nv) * np.array([0.1] * 3 + [0.05, 0.05, 1.0] + [0.08] * (nv - 6))
    q = q.copy()
    mujoco.mj_integratePos(robot(name).model, q, tangent, 1.0)
    machine = robot(name)
    room = 0.15 * (machine.position_high - machine.position_low)
    q[7:] = np.clip(q[7:], machine.position_low + room, machine.position_high - room)
    return q, share * rng.normal(size=nv) * np.array([0.1] * 3 + [0.2] * (nv - 3))


class Sole(NamedTuple):
    """A sole as MuJoCo sees it: world pose, Jacobian (6, nv) of a point, and J̇ v there."""

    position: Array
    rotation: Array
    jacobian: Array
    bias: Array


class Engine:
    """MuJoCo's kinematics and dynamics of a state."""

    def __init__(self, name: str, q: Array, v: Array) -> None:
        self.robot = robot(name)
        self.model, self.data = self.robot.model, mujoco.MjData(self.robot.model)
        self.data.qpos[:], self.data.qvel[:] = q, v
        mujoco.mj_fwdPosition(self.model, self.data)
        mujoco.mj_fwdVelocity(self.model, self.data)
        self.bias = self.data.qfrc_bias.copy()
        self.mass_matrix = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, self.mass_matrix)

    def point(self, body: int, place: Array) -> tuple[Array, Array]:
        """Jacobian of a point of a body, and J̇ v."""
        jacobian, rate = np.zeros((6, self.model.nv)), np.zeros((6, self.model.nv))
        mujoco.mj_jac(self.model, self.data, jacobian[:3], jacobian[3:], place, body)
        mujoco.mj_jacDot(self.model, self.data, rate[:3], rate[3:], place, body)
        return jacobian, rate @ self.data.qvel

    def sole(self, leg: int, along: float = 0.0) -> Sole:
        """The sole's site, and what the robot does at a point ``along`` its x axis."""
        site = self.data.site(self.robot.legs[leg].sole_site)
        rotation = site.xmat.reshape(3, 3).copy()
        place = site.xpos + along * rotation[:, 0]
        return Sole(place, rotation, *self.point(self.robot.legs[leg].sole_body, place))


def task(weight: float, stiffness: float = 0.0, damping: float = 0.0) -> Task:
    """A row of the table."""
    return Task(weight, stiffness, damping)
