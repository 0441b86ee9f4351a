"""The same robot and ground in Bullet, the engine of the first paper's simulation.

Bullet does the physics; MuJoCo's arrays mirror its state, so that what is measured, observed and drawn is computed by
the same code for both engines. Bullet has no rotor inertia A: the torque that the rotors take, A q̈, is subtracted from
that of the joints, with q̈ of the inverse of M + A under the ground's forces of the step before.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import os
import sys
import tempfile
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot
from gaitsmith.simulation.bullet_model import BulletModel, write_model
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.terrain import Region, Terrain

Array = npt.NDArray[np.float64]
_ITERATIONS = 100  # of the contact solver, in every physics step
_RESIDUAL = 1e-12  # at which it may stop earlier
_ROTORS = "Bullet has no rotor inertia: the torque that rotors take is subtracted from that of the joints"
_PLANE = ("flat", "boxes", "stairs")


def _engine() -> Any:
    if sys.modules.get("pybullet") is not None:
        return sys.modules["pybullet"]
    try:
        with _silent():
            return importlib.import_module("pybullet")
    except ImportError:
        raise BadInput("engine", "bullet", "the extra bullet", "pip install 'gaitsmith[bullet]'") from None


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Keep what a library prints by itself, here when it was built, out of standard output and error."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept, nowhere = {number: os.dup(number) for number in (1, 2)}, os.open(os.devnull, os.O_WRONLY)
    try:
        for number in kept:
            os.dup2(nowhere, number)
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        for number, copy in kept.items():
            os.dup2(copy, number)
            os.close(copy)
        os.close(nowhere)


class BulletPlant(Plant):
    """One robot on one terrain in Bullet; arguments and attributes as :class:`Plant`.

    Raises:
        BadInput: no package pybullet, a ball among the props, or a model with what Bullet does not have.
    """

    def __init__(self, robot: Robot, **options: Any) -> None:
        self._bullet = _engine()
        if options.get("props"):
            raise BadInput("engine", "bullet", "mujoco", "only there is a ball to kick")
        super().__init__(robot, **options)
        p = self._bullet
        self._client: int = p.connect(p.DIRECT)
        weakref.finalize(self, p.disconnect, self._client)
        self._known = {"physicsClientId": self._client}
        self._gravity = np.asarray(robot.model.opt.gravity, dtype=float)
        p.setGravity(*self._gravity, **self._known)
        p.setPhysicsEngineParameter(
            fixedTimeStep=self.physics_step,
            numSolverIterations=_ITERATIONS,
            solverResidualThreshold=_RESIDUAL,
            deterministicOverlappingPairs=1,
            **self._known,
        )
        self._add_ground(options.get("terrain") or Terrain(), options.get("region"), options.get("friction", 0.8))
        with tempfile.TemporaryDirectory() as folder:
            made = write_model(self._model, robot.model.nbody, Path(folder))
            flags = p.URDF_USE_INERTIA_FROM_FILE | p.URDF_USE_SELF_COLLISION | p.URDF_MAINTAIN_LINK_ORDER
            try:
                self._uid: int = p.loadURDF(str(made.path), flags=flags, **self._known)
            except p.error as error:
                raise BadInput("engine", "bullet", "mujoco", f"Bullet refused the model: {error}") from None
        self._index(made, bool(options.get("passing")))

    def _add_ground(self, terrain: Terrain, region: Region | None, friction: float) -> None:
        """Plane and blocks."""
        p = self._bullet

        def add(shape: int, mu: float, place: Any = (0.0, 0.0, 0.0), turn: Any = (0.0, 0.0, 0.0)) -> None:
            orientation = p.getQuaternionFromEuler(turn)
            uid = p.createMultiBody(0.0, shape, -1, place, orientation, **self._known)
            p.changeDynamics(uid, -1, lateralFriction=mu, restitution=0.0, **self._known)

        if terrain.kind in _PLANE:
            add(p.createCollisionShape(p.GEOM_PLANE, **self._known), friction)
        for block in terrain.blocks(region or Region()):
            shape = p.createCollisionShape(p.GEOM_BOX, halfExtents=block.half_size, **self._known)
            add(shape, block.friction or friction, block.centre, (block.roll, block.pitch, 0.0))

    def _index(self, made: BulletModel, passing: bool) -> None:
        """Which of Bullet's links and joints are which bodies and joints, and what may touch what."""
        p, robot, model = self._bullet, self._robot, self._model
        links, joints = {p.getBodyInfo(self._uid, **self._known)[0].decode(): -1}, dict[str, int]()
        for index in range(p.getNumJoints(self._uid, **self._known)):
            info = p.getJointInfo(self._uid, index, **self._known)
            joints[info[1].decode()], links[info[12].decode()] = index, index
        self._link_of = {body: links[name] for body, name in enumerate(made.link_names) if name}
        self._body_of = {link: body for body, link in self._link_of.items()}
        order = [f"joint_{number}" for number in range(1, 1 + len(robot.joint_names))]
        self._joints = [joints[name] for name in order]
        self._zero = np.array(model.qpos0[7 : 7 + len(order)])
        self._rotors = np.array(model.dof_armature[6 : 6 + len(order)])
        self._damping = np.array(model.dof_damping[6 : 6 + len(order)])
        self._stiffness = np.array(model.jnt_stiffness[1 : 1 + len(order)])
        self._spring = np.array(model.qpos_spring[7 : 7 + len(order)])
        friction = model.dof_frictionloss[6 : 6 + len(order)].tolist()
        still = [0.0] * len(order)
        # A motor that wants to stand still with no more than this torque is Coulomb friction.
        p.setJointMotorControlArray(
            self._uid, self._joints, p.VELOCITY_CONTROL, targetVelocities=still, forces=friction, **self._known
        )
        for link in links.values():
            p.changeDynamics(
                self._uid,
                link,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                lateralFriction=1.0,
                restitution=0.0,
                maxJointVelocity=1e3,
                **self._known,
            )
        frame = p.getDynamicsInfo(self._uid, -1, **self._known)
        self._base_place, turn = np.array(frame[3]), p.getMatrixFromQuaternion(frame[4])
        self._base_turn = np.array(turn).reshape(3, 3)
        self._legs = [self._below(leg.joint_indices[0]) for leg in robot.legs]
        everything = [-1, *range(p.getNumJoints(self._uid, **self._known))]
        for k, one in enumerate(everything):
            for other in everything[k + 1 :]:
                crossed = any(
                    self._body_of.get(one) in first and self._body_of.get(other) in second
                    for first, second in (self._legs, self._legs[::-1])
                )
                touches = int(crossed and not passing)
                p.setCollisionFilterPair(self._uid, self._uid, one, other, touches, **self._known)
        rigid = robot.model.body_weldid
        self._feet = [int(rigid[leg.sole_body]) for leg in robot.legs]
        self._rigid = rigid
        self._others = [body for body in range(1, robot.model.nbody) if rigid[body] not in self._feet]
        readings = self._data.sensordata
        sizes = np.cumsum([self._contact_at, 3 * len(self._feet), 1, self._n_bodies, 6])
        _, self._sole_reading, self._leg_reading, self._body_reading, self._imu_reading = np.split(readings, sizes)[:5]
        self._imu = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "gaitsmith_imu")
        self._imu_velocity = np.zeros(3)
        self._touching: list[tuple[int, Array, Array]] = []

    def _below(self, joint: int) -> set[int]:
        """A leg's bodies, from that of its first joint on."""
        model = self._robot.model
        found = {int(model.jnt_bodyid[joint + 1])}
        for body in range(1, model.nbody):
            if int(model.body_parentid[body]) in found:
                found.add(body)
        return found

    def reset(self, q: Array, v: Array | None = None) -> None:
        """Put the robot on the level start area; see :meth:`Plant.reset`."""
        super().reset(q, v)
        if np.any(self._rotors):
            self.warnings.append(_ROTORS)
        self._send()

    def refresh(self) -> None:
        """Observe anew after ``q`` or ``v`` have been written to."""
        super().refresh()
        self._send()

    def _send(self) -> None:
        """Give Bullet the state that the arrays hold."""
        p, data, known = self._bullet, self._data, self._known
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, self.q[3:7])
        rotation = turn.reshape(3, 3)
        offset = rotation @ self._base_place
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, (rotation @ self._base_turn).ravel())
        w, x, y, z = quaternion.tolist()
        p.resetBasePositionAndOrientation(self._uid, (self.q[:3] + offset).tolist(), (x, y, z, w), **known)
        spin = rotation @ self.v[3:6]
        p.resetBaseVelocity(self._uid, (self.v[:3] + np.cross(spin, offset)).tolist(), spin.tolist(), **known)
        for joint, angle, rate in zip(self._joints, self.q[7:] - self._zero, self.v[6:], strict=True):
            p.resetJointState(self._uid, joint, angle, rate, **known)
        mujoco.mj_comVel(self._model, data)
        self._imu_velocity, self._touching = self._velocity_of_imu()[1], []

    def _physics(self) -> None:
        """One step of Bullet, and its state into the arrays."""
        p, data, known = self._bullet, self._data, self._known
        torque = data.qfrc_applied[6 : 6 + len(self._joints)] - self._damping * self.v[6:]
        torque -= self._stiffness * (self.q[7:] - self._spring)
        torque -= self._taken_by_rotors(torque)
        p.setJointMotorControlArray(self._uid, self._joints, p.TORQUE_CONTROL, forces=torque.tolist(), **known)
        for (body, joint), force in self._forces.items():
            if np.any(force):
                place = data.xipos[body] if joint is None else data.xanchor[joint]
                link = self._link_of[body]
                p.applyExternalForce(self._uid, link, force.tolist(), place.tolist(), p.WORLD_FRAME, **known)
        p.stepSimulation(**known)
        self._take_state()
        self._take_contacts()
        self._take_imu()

    def _taken_by_rotors(self, torque: Array) -> Array:
        """A q̈ of every joint, N·m."""
        model, data = self._model, self._data
        bias, applied, found = np.zeros(model.nv), np.zeros(model.nv), np.zeros((1, model.nv))
        mujoco.mj_rne(model, data, 0, bias)
        applied[6 : 6 + len(torque)] = torque
        pushes = [(b, data.xipos[b] if j is None else data.xanchor[j], f) for (b, j), f in self._forces.items()]
        for body, place, force in (*self._touching, *pushes):
            mujoco.mj_applyFT(model, data, force, np.zeros(3), place, body, applied)
        mujoco.mj_solveM(model, data, found, (applied - bias)[None])
        return np.asarray(self._rotors * found[0, 6 : 6 + len(torque)])

    def _take_state(self) -> None:
        p, data, model, known = self._bullet, self._data, self._model, self._known
        place, (x, y, z, w) = p.getBasePositionAndOrientation(self._uid, **known)
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, np.array([w, x, y, z]))
        rotation = turn.reshape(3, 3) @ self._base_turn.T
        linear, spin = p.getBaseVelocity(self._uid, **known)
        offset = rotation @ self._base_place
        self.q[:3] = np.array(place) - offset
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, rotation.ravel())
        self.q[3:7] = quaternion if quaternion @ self.q[3:7] >= 0.0 else -quaternion
        self.v[:3] = np.array(linear) - np.cross(spin, offset)
        self.v[3:6] = rotation.T @ np.array(spin)
        states = p.getJointStates(self._uid, self._joints, **known)
        self.q[7:] = self._zero + [state[0] for state in states]
        self.v[6:] = [state[1] for state in states]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_factorM(model, data)
        mujoco.mj_comVel(model, data)

    def _take_contacts(self) -> None:
        """Forces on the soles, and which bodies touch the ground or the other leg."""
        self._sole_reading[:] = 0.0
        self._body_reading[:] = self._leg_reading[:] = 0.0
        found, between = list[tuple[int, Array, Array]](), 0
        for point in self._bullet.getContactPoints(bodyA=self._uid, **self._known):
            normal, size = np.array(point[7]), point[9]
            if point[2] == self._uid:
                between += point[8] <= 0.0
                continue
            body = self._body_of.get(point[3], 0)
            force = size * normal + point[10] * np.array(point[11]) + point[12] * np.array(point[13])
            if point[8] > 0.0 and not size:
                continue
            found.append((body, np.array(point[5]), force))
            foot = int(self._rigid[body])
            if foot in self._feet:
                leg = self._feet.index(foot)
                self._sole_reading[3 * leg : 3 * leg + 3] += force
            elif body in self._others:
                self._body_reading[self._others.index(body)] = 1.0
        self._leg_reading[0] = float(between > 0)
        self._touching = found

    def _velocity_of_imu(self) -> tuple[Array, Array]:
        """Angular velocity, its own axes, and linear velocity, world axes."""
        local, world = np.zeros(6), np.zeros(6)
        kind = mujoco.mjtObj.mjOBJ_SITE
        mujoco.mj_objectVelocity(self._model, self._data, kind, self._imu, local, 1)
        mujoco.mj_objectVelocity(self._model, self._data, kind, self._imu, world, 0)
        return local[:3], world[3:]

    def _take_imu(self) -> None:
        spin, velocity = self._velocity_of_imu()
        specific = (velocity - self._imu_velocity) / self.physics_step - self._gravity
        self._imu_velocity = velocity
        self._imu_reading[:3] = self._data.site_xmat[self._imu].reshape(3, 3).T @ specific
        self._imu_reading[3:] = spin

    def ground_forces(self) -> Array:
        """(n, 6) place (world, m) and force on the robot (world axes, N) of every contact of robot and ground."""
        return np.array([(*place, *force) for _, place, force in self._touching]).reshape(-1, 6)
