"""The simulated robot and its ground: MuJoCo behind one file, stepped by torques and read through sensors."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping, Sequence

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Arena
from gaitsmith.control import Measurement
from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot
from gaitsmith.simulation.props import Ball, BallState
from gaitsmith.simulation.sensors import SensorNoise
from gaitsmith.simulation.terrain import Region, Terrain
from gaitsmith.simulation.truth import (
    Account,
    Errors,
    Geometry,
    PlantArrays,
    SensorArrays,
    World,
    apply_torque,
    make_truth,
    observe,
    read_sensors,
    track,
)
from gaitsmith.simulation.world import PlantError as PlantError
from gaitsmith.simulation.world import (
    add_ground,
    build,
    change_masses,
    contact_forces,
    let_legs_pass,
    set_options,
    shift_mass,
)

_MOST_WARNINGS = 100


class Plant:
    """Rigid-body physics of one robot on one terrain.

    Args:
        terrain: the ground; level around the origin.
        sensors: sensor errors; None measures the true state.
        joint_friction: Coulomb friction at every joint, N·m.
        joint_frictions: the same by joint, instead, where one differs.
        torque_delay: from command to joint, s, in whole physics steps.
        friction: Coulomb coefficient between sole and ground.
        mass_factor: on every mass and inertia of the robot.
        mass_spread: each body's mass and inertia differ by up to this share besides, drawn from the seed.
        torso_shift: (3,) by which the torso's centre of mass is not where the card has it, torso axes, m.
        region: where boxes or a slope are needed; beyond it boxes give way to the level plane.
        props: what else lies in the world.
        physics_step: s.
        control_step: s, a whole number of physics steps.

    Attributes:
        truth: what is true at this control tick, over ``truth_buffer``.
        truth_buffer: (n,) the same numbers in one array.
        truth_columns: name of every entry of ``truth_buffer``.
        q, v: (nq,), (nv,) true position and velocity of the robot; views.
        torso_rotation: (3, 3) true rotation of the torso to the world; a view.
        com: (3,) true centre of mass of the robot, world, m; a view.
        balls: state of the balls among the props.
        time: s since :meth:`reset`.
        warnings: of the physics engine since :meth:`reset`, at most a hundred.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        terrain: Terrain | None = None,
        sensors: SensorNoise | None = None,
        joint_friction: float = 0.0,
        joint_frictions: Mapping[str, float] | None = None,
        torque_delay: float = 0.0,
        friction: float = 0.8,
        mass_factor: float = 1.0,
        mass_spread: float = 0.0,
        torso_shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
        seed: int = 0,
        region: Region | None = None,
        props: Sequence[Ball] = (),
        passing: bool = False,
        physics_step: float = 5e-4,
        control_step: float = 1e-3,
    ) -> None:
        self._robot = robot
        self._substeps = round(control_step / physics_step)
        if self._substeps < 1 or abs(self._substeps * physics_step - control_step) > 1e-9:
            raise BadInput("control_step", control_step, f"a whole number of physics steps of {physics_step} s")
        self.control_step = control_step
        self.physics_step = physics_step
        spec = robot.make_spec()
        set_options(spec, physics_step)
        ground = terrain or Terrain()
        self._start_height = ground.height(0.0, 0.0)
        add_ground(spec, ground, region or Region(), friction)
        for k, ball in enumerate(props):
            ball.add_to(spec, f"ball_{k + 1}")
        frictions = np.array([(joint_frictions or {}).get(name, joint_friction) for name in robot.joint_names])
        if passing:
            let_legs_pass(spec, robot)
        self._model, self._contact_at, self._imu_at = build(spec, robot, frictions, len(props))
        self._n_bodies = self._imu_at - self._contact_at - 3 * len(robot.legs) - 1
        self._data = data = mujoco.MjData(self._model)
        self._scratch = mujoco.MjData(self._model)
        self.q: npt.NDArray[np.float64] = data.qpos[: robot.model.nq]
        self.v: npt.NDArray[np.float64] = data.qvel[: robot.model.nv]
        self.torso_rotation: npt.NDArray[np.float64] = data.xmat[robot.torso_body].reshape(3, 3)
        self.com: npt.NDArray[np.float64] = data.subtree_com[robot.torso_body]
        self.balls = tuple(
            BallState(self._data.qpos[self._model.nq - 7 * k :][:3], self._data.qvel[self._model.nv - 6 * k :][:3])
            for k in range(len(props), 0, -1)
        )
        if mass_factor != 1.0 or mass_spread != 0.0:
            change_masses(self._model, self._data, robot.model.nbody, mass_factor, mass_spread, seed)
        if any(torso_shift):
            shift_mass(self._model, self._data, robot.torso_body, torso_shift)
        self._sensors = sensors
        self._seed = seed
        self._noise = self._draw()
        self._ticks = -1  # until reset
        self._forces: dict[tuple[int, int | None], npt.NDArray[np.float64]] = {}
        self._levers = False  # forces off a CoM
        self._bind(round(torque_delay / physics_step))

    def _bind(self, delay: int) -> None:
        """Share the engine's arrays with the kernels, once."""
        model, data, robot = self._model, self._data, self._robot
        nj, legs = len(robot.joint_names), robot.legs
        sole, leg, body, imu = np.split(
            data.sensordata[self._contact_at : self._imu_at + 6], np.cumsum([3 * len(legs), 1, self._n_bodies])
        )
        state = (data.qpos, data.qvel, data.xpos, data.xmat, data.M, data.qfrc_applied)
        world = World(*state, imu_readings=imu, sole_readings=sole, leg_reading=leg, body_readings=body)
        geometry = Geometry(
            torso=robot.torso_body,
            nq=robot.model.nq,
            nv=robot.model.nv,
            sole_body=np.array([leg.sole_body for leg in legs], dtype=np.int64),
            sole_position=np.array([leg.sole_position for leg in legs]),
            hip_midpoint=np.asarray(robot.hip_midpoint),
            torque_limit=np.asarray(robot.torque_limit),
            row_address=model.M_rowadr.astype(np.int64),
            mass=float(model.body_subtreemass[robot.torso_body]),
        )
        account = Account(np.zeros(nj), np.zeros((delay + 1, nj)), np.zeros(1, dtype=np.int64), np.zeros(2))
        self.truth, self.truth_buffer, self.truth_columns = make_truth([leg.name for leg in legs])
        self._arena = Arena(PlantArrays(world, geometry, account, self.truth))
        for kept, given in zip(self._arena.view.world, world, strict=True):
            if not np.shares_memory(kept, given):
                raise PlantError("the physics engine's arrays cannot be shared with the kernels")
        self._account: Account = self._arena.view.account
        self._address = self._arena.address
        self._measured: Measurement | None = None

    def reset(self, q: npt.NDArray[np.float64], v: npt.NDArray[np.float64] | None = None) -> None:
        """Put the robot on the level start area: the lowest point of its soles touches the ground at the origin.

        Args:
            q: (nq,) base position (its z is overwritten), base quaternion w x y z, joint positions.
            v: (nv,) velocity; zero if None.

        Raises:
            BadInput: wrong shape or a value that is not finite.
        """
        nq, nv = self._robot.model.nq, self._robot.model.nv
        if np.shape(q) != (nq,) or not np.all(np.isfinite(q)):
            raise BadInput("q", q, f"{nq} finite numbers")
        if v is not None and (np.shape(v) != (nv,) or not np.all(np.isfinite(v))):
            raise BadInput("v", v, f"{nv} finite numbers")
        self.warnings: list[str] = []
        _hearing.warnings = self.warnings
        mujoco.mj_resetData(self._model, self._data)
        self.q[:], self.v[:] = q, 0.0 if v is None else v
        mujoco.mj_kinematics(self._model, self._data)
        self.q[2] += self._start_height - self._lowest_sole_point()
        mujoco.mj_forward(self._model, self._data)
        self._forces.clear()
        self._levers = False
        self._account.torque[:] = self._account.delayed[:] = 0.0
        self.truth_buffer[:] = 0.0
        self._noise = self._draw()
        self._noise_rows: Iterator[npt.NDArray[np.float64]] = iter(())
        self._first_torque = True
        self.time = 0.0
        self._ticks = 0
        self.truth.least_separation[0] = np.inf
        track(self._address)
        self.restart_excursion()
        observe(self._address)
        for ball in self.balls:
            ball.restart()

    def _draw(self) -> Iterator[npt.NDArray[np.float64]] | None:
        """The sensors' noise from its beginning; None for the true state."""
        if self._sensors is None:
            return None
        robot, model = self._robot, self._model
        weight = float(robot.model.body_subtreemass[robot.torso_body]) * float(np.linalg.norm(model.opt.gravity))
        return self._sensors.blocks(len(robot.joint_names), len(robot.legs), weight, self._seed)

    def refresh(self) -> None:
        """Observe anew after ``q`` or ``v`` have been written to; counts and extremes go on."""
        mujoco.mj_forward(self._model, self._data)
        track(self._address)
        observe(self._address)

    def restart_excursion(self) -> None:
        """Count the torso's excursion from where it is now."""
        self.truth.excursion[0] = 0.0
        self._account.start[:] = self._data.xpos[self._robot.torso_body][:2]

    def _lowest_sole_point(self) -> float:
        """World height of the lowest corner of both soles, m."""
        lowest = np.inf
        for leg in self._robot.legs:
            rotation = self._data.xmat[leg.sole_body].reshape(3, 3)
            place = self._data.xpos[leg.sole_body] + rotation @ np.asarray(leg.sole_position)
            up = (rotation @ np.asarray(leg.sole_rotation))[2]
            lowest = min(lowest, place[2] + (leg.sole.corners @ up[:2]).min())
        return float(lowest)

    def step(self, torque: npt.NDArray[np.float64]) -> None:
        """Apply joint torques (nj,) for one control period, N·m in joint order, and observe what comes of it."""
        account, address = self._account, self._address
        if self._ticks < 0:
            raise BadInput("plant", "no posture", "a plant that stands somewhere", "call reset(q) first")
        _hearing.warnings = self.warnings
        if self._levers:
            self._place_forces()
        account.torque[:] = torque
        if self._first_torque:
            account.delayed[:] = torque
            self._first_torque = False
        try:
            for _ in range(self._substeps):
                apply_torque(address)
                self._physics()
                track(address)
        except mujoco.FatalError as error:
            raise PlantError(f"physics engine stopped at {self.time:.3f} s: {error}") from None
        observe(address)
        for ball in self.balls:
            ball.watch()
        self._ticks += 1
        self.time = self._ticks * self.control_step

    def _physics(self) -> None:
        """One physics step, after which the engine's arrays hold its outcome."""
        mujoco.mj_step2(self._model, self._data)
        mujoco.mj_step1(self._model, self._data)

    def measure(self, into: Measurement) -> None:
        """Fill ``into`` with the true state or, with sensor errors, with what the sensors say.

        With sensor errors the base position, the linear and angular base velocity, and the joint velocities are not
        measured and stay as they are.
        """
        if into is not self._measured:
            self._bind_measurement(into)
        if self._noise is not None:
            row = next(self._noise_rows, None)
            if row is None:
                self._noise_rows = iter(next(self._noise))
                row = next(self._noise_rows)
            self._noise_row[:] = row
        read_sensors(self._readings.address, self._noise is not None)

    def _bind_measurement(self, into: Measurement) -> None:
        """Share a measurement's arrays with the kernel."""
        noise = np.zeros(9 + len(self._robot.joint_names) + len(self._robot.legs))
        bias = self._sensors.bias(self._seed) if self._sensors else np.zeros(3)
        step = self._sensors.encoder_step if self._sensors else 0.0
        self._readings = Arena(SensorArrays(self._arena.view.world, into, Errors(noise, bias, step)))
        self._noise_row: npt.NDArray[np.float64] = self._readings.view.errors.noise
        self._measured = into

    def push(self, force: npt.ArrayLike, body: str | None = None, joint: str | None = None) -> None:
        """Set the force (3,) in N, world axes, at a body's CoM (None: the torso's), or at a joint's anchor on its body.

        Raises:
            BadInput: no such body or joint, or no force.
        """
        if np.shape(force) != (3,) or not np.isfinite(force).all():
            raise BadInput("push.force", force, "3 finite numbers, N")
        if joint is not None and joint not in self._robot.joint_names:
            raise BadInput("push.joint", joint, "one of " + ", ".join(self._robot.joint_names))
        number = None if joint is None else 1 + self._robot.joint_names.index(joint)
        place = self.body_id(body) if number is None else int(self._model.jnt_bodyid[number])
        self._forces[place, number] = np.array(force)
        self._place_forces()

    def _place_forces(self) -> None:
        """Forces and their moments about the bodies' CoM, as the robot stands now."""
        data = self._data
        data.xfrc_applied[:] = 0.0
        for (body, joint), force in self._forces.items():
            data.xfrc_applied[body, :3] += force
            if joint is not None:
                data.xfrc_applied[body, 3:] += np.cross(data.xanchor[joint] - data.xipos[body], force)
        self._levers = any(joint is not None and np.any(force) for (_, joint), force in self._forces.items())

    def body_id(self, body: str | None) -> int:
        """Number of a named body.

        Raises:
            BadInput: no such body.
        """
        if body is None:
            return int(self._robot.torso_body)
        found = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_BODY, body)
        if found <= 0:
            names = [self._model.body(b).name for b in range(1, self._model.nbody)]
            raise BadInput("push.body", body, "one of " + ", ".join(names))
        return int(found)

    def ground_forces(self) -> npt.NDArray[np.float64]:
        """(n, 6) place (world, m) and force on the robot (world axes, N) of every contact of robot and ground."""
        return contact_forces(self._model, self._data, self._scratch, self._robot.model.nbody)

    def zmp(self) -> tuple[float, float] | None:
        """Centre of the vertical forces between robot and ground, world, m; None in the air, and before torques act."""
        found = self.ground_forces()
        total = float(found[:, 5].sum())
        x, y = found[:, 5] @ found[:, :2] / max(total, 1.0)
        return (float(x), float(y)) if total > 1.0 and self.time > 0.0 else None


_hearing = threading.local()
"""Where the engine's warnings go in this thread: ``warnings`` of the plant that runs."""


def _hear(message: str) -> None:
    """Keep at most a hundred warnings, instead of the engine's log file in the working folder."""
    heard: list[str] = getattr(_hearing, "warnings", [])
    if len(heard) < _MOST_WARNINGS:
        heard.append(" ".join(str(message).split()))


mujoco.set_mju_user_warning(_hear)
