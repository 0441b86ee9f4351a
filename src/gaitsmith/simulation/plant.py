"""The simulated robot and its ground: MuJoCo behind one file, stepped by torques and read through sensors."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import Arena
from gaitsmith.control import Measurement
from gaitsmith.errors import BadInput, GaitsmithError
from gaitsmith.robots import Robot
from gaitsmith.simulation.sensors import SensorNoise
from gaitsmith.simulation.terrain import Region, Terrain
from gaitsmith.simulation.truth import (
    OBSERVED,
    Account,
    Geometry,
    PlantArrays,
    Readings,
    SensorArrays,
    World,
    apply_torque,
    observe,
    read_sensors,
    track,
)

_FOUND, _FORCE = 1, 2  # bits of a contact sensor's data field
_FIRST, _SUM = 0, 3  # how a contact sensor reduces several contacts
_ANY_BIT = 0x7FFFFFFF  # ground collides with every geometry that collides with anything
_SOLREF = (0.005, 1.0)  # s, -: stiff enough that a sole sinks in less than 1 mm
_STICTION = 0.995  # impedance of joint friction: the engine's default lets a held joint creep
_FALLBACK_FRICTION = (0.005, 0.0001)  # torsional and rolling, unused by a contact of dimension 3


class PlantError(GaitsmithError):
    """The physics engine refused the model or stopped; its own message is kept."""


class Plant:
    """Rigid-body physics of one robot on one terrain.

    Args:
        robot: from :func:`gaitsmith.robots.load_robot`.
        terrain: the ground; level around the origin.
        sensors: sensor errors; None measures the true state.
        joint_friction: Coulomb friction at every joint, N·m.
        torque_delay: from command to joint, s, in whole physics steps.
        friction: Coulomb coefficient between sole and ground.
        mass_factor: on every mass and inertia of the robot.
        mass_spread: each body's mass and inertia differ by up to this share besides, drawn from the seed.
        seed: of everything random.
        region: where boxes or a slope are needed; beyond it boxes give way to the level plane.
        physics_step: s.
        control_step: s, a whole number of physics steps.

    Attributes:
        observed: true values at this control tick, one for each name in ``observed_columns``.
        time: s since :meth:`reset`.
    """

    observed_columns: tuple[str, ...] = OBSERVED

    def __init__(
        self,
        robot: Robot,
        *,
        terrain: Terrain | None = None,
        sensors: SensorNoise | None = None,
        joint_friction: float = 0.0,
        torque_delay: float = 0.0,
        friction: float = 0.8,
        mass_factor: float = 1.0,
        mass_spread: float = 0.0,
        seed: int = 0,
        region: Region | None = None,
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
        _set_options(spec, physics_step)
        _add_ground(spec, terrain or Terrain(), region or Region(), friction)
        self._model, self._contact_at, self._imu_at = _compile(spec, robot, joint_friction)
        self._data = mujoco.MjData(self._model)
        if mass_factor != 1.0 or mass_spread != 0.0:
            _change_masses(self._model, self._data, mass_factor, mass_spread, seed)
        self._noise = sensors.blocks(len(robot.joint_names), seed) if sensors else None
        self._sensors = sensors
        self._seed = seed
        self._bind(round(torque_delay / physics_step))

    def _bind(self, delay: int) -> None:
        """Share the engine's arrays with the kernels, once."""
        model, data, robot = self._model, self._data, self._robot
        nj, legs = len(robot.joint_names), robot.legs
        world = World(
            *(data.qpos, data.qvel, data.xpos, data.xmat, data.M, data.qfrc_applied),
            imu_readings=data.sensordata[self._imu_at :][:6],
            contact_readings=data.sensordata[self._contact_at : self._imu_at],
        )
        geometry = Geometry(
            torso=robot.torso_body,
            sole_body=np.array([leg.sole_body for leg in legs], dtype=np.int64),
            sole_position=np.array([leg.sole_position for leg in legs]),
            hip_midpoint=np.asarray(robot.hip_midpoint),
            torque_limit=np.asarray(robot.torque_limit),
            row_address=model.M_rowadr.astype(np.int64),
            mass=float(model.body_subtreemass[0]),
        )
        account = Account(
            torque=np.zeros(nj),
            delayed=np.zeros((delay + 1, nj)),
            head=np.zeros(1, dtype=np.int64),
            observed=np.zeros(len(OBSERVED)),
            start=np.zeros(2),
            extremes=np.array([np.inf, 0.0]),
            counts=np.zeros(4, dtype=np.int64),
        )
        self._arena = Arena(PlantArrays(world, geometry, account))
        for kept, given in zip(self._arena.view.world, world, strict=True):
            if not np.shares_memory(kept, given):
                raise PlantError("the physics engine's arrays cannot be shared with the kernels")
        self._account: Account = self._arena.view.account
        self._address = self._arena.address
        self.observed = self._account.observed
        self._measured: Measurement | None = None

    def reset(self, q: npt.NDArray[np.float64], v: npt.NDArray[np.float64] | None = None) -> None:
        """Put the robot on the level start area: the lowest point of its soles touches z = 0.

        Args:
            q: (nq,) base position (its z is overwritten), base quaternion w x y z, joint positions.
            v: (nv,) velocity; zero if None.

        Raises:
            BadInput: wrong shape or a value that is not finite.
        """
        if np.shape(q) != (self._model.nq,) or not np.all(np.isfinite(q)):
            raise BadInput("q", q, f"{self._model.nq} finite numbers")
        if v is not None and (np.shape(v) != (self._model.nv,) or not np.all(np.isfinite(v))):
            raise BadInput("v", v, f"{self._model.nv} finite numbers")
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[:] = q
        self._data.qvel[:] = 0.0 if v is None else v
        mujoco.mj_kinematics(self._model, self._data)
        self._data.qpos[2] -= self._lowest_sole_point()
        mujoco.mj_forward(self._model, self._data)
        account = self._account
        account.torque[:] = 0.0
        account.delayed[:] = 0.0
        account.counts[:] = 0
        account.observed[20] = 0.0
        if self._sensors is not None:
            self._noise = self._sensors.blocks(len(self._robot.joint_names), self._seed)
        self._noise_rows: Iterator[npt.NDArray[np.float64]] = iter(())
        self._first_torque = True
        self.time = 0.0
        self._ticks = 0
        track(self._address)
        account.counts[2] = 0
        account.extremes[0] = self.observed[19]
        self.restart_excursion()
        observe(self._address)

    def refresh(self) -> None:
        """Observe anew after ``q`` or ``v`` have been written to; counts and extremes go on."""
        mujoco.mj_forward(self._model, self._data)
        track(self._address)
        observe(self._address)

    def restart_excursion(self) -> None:
        """Count the torso's excursion from where it is now."""
        self._account.extremes[1] = 0.0
        self._account.start[:] = self._data.xpos[self._robot.torso_body][:2]

    def _lowest_sole_point(self) -> float:
        """World height of the lowest corner of both soles, m."""
        lowest = np.inf
        for leg in self._robot.legs:
            rotation = self._data.xmat[leg.sole_body].reshape(3, 3)
            place = self._data.xpos[leg.sole_body] + rotation @ np.asarray(leg.sole_position)
            up = (rotation @ np.asarray(leg.sole_rotation))[2]
            for x in (-leg.sole.heel, leg.sole.toe):
                for y in (-leg.sole.half_width, leg.sole.half_width):
                    lowest = min(lowest, place[2] + up[0] * x + up[1] * y)
        return float(lowest)

    def step(self, torque: npt.NDArray[np.float64]) -> None:
        """Apply joint torques (nj,) for one control period, N·m in joint order, and observe what comes of it."""
        account, address, model, data = self._account, self._address, self._model, self._data
        account.torque[:] = torque
        if self._first_torque:
            account.delayed[:] = torque
            self._first_torque = False
        try:
            for _ in range(self._substeps):
                apply_torque(address)
                mujoco.mj_step2(model, data)
                mujoco.mj_step1(model, data)
                track(address)
        except mujoco.FatalError as error:
            raise PlantError(f"physics engine stopped at {self.time:.3f} s: {error}") from None
        observe(address)
        self._ticks += 1
        self.time = self._ticks * self.control_step

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
        read_sensors(self._readings_address, self._noise is not None)

    def _bind_measurement(self, into: Measurement) -> None:
        """Share a measurement's arrays with the kernel."""
        noise = np.zeros(9 + len(self._robot.joint_names))
        bias = self._sensors.bias(self._seed) if self._sensors else np.zeros(3)
        step = self._sensors.encoder_step if self._sensors else 0.0
        self._readings = Arena(
            SensorArrays(self._arena.view.world, Readings(*into, noise=noise, bias=bias, encoder_step=step))
        )
        self._readings_address = self._readings.address
        self._noise_row: npt.NDArray[np.float64] = self._readings.view.readings.noise
        self._measured = into

    def push(self, force: npt.ArrayLike, body: str | None = None) -> None:
        """Set the force (3,) in N, world axes, at a body's CoM (None: the torso) until it is set again."""
        self._data.xfrc_applied[self.body_id(body), :3] = force

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

    @property
    def q(self) -> npt.NDArray[np.float64]:
        """(nq,) true position; a view."""
        position: npt.NDArray[np.float64] = self._data.qpos
        return position

    @property
    def v(self) -> npt.NDArray[np.float64]:
        """(nv,) true velocity; a view."""
        velocity: npt.NDArray[np.float64] = self._data.qvel
        return velocity

    @property
    def min_separation(self) -> float:
        """Smallest lateral distance, left minus right, of the sole frames' origins in the heading frame, m."""
        return float(self._account.extremes[0])

    @property
    def excursion(self) -> float:
        """Largest horizontal distance of the torso from where it was at :meth:`restart_excursion`, m."""
        return float(self._account.extremes[1])

    @property
    def leg_contacts(self) -> int:
        """How many times one leg came to touch the other."""
        return int(self._account.counts[0])

    @property
    def diverged(self) -> bool:
        """Whether the state stopped being finite."""
        return bool(self._account.counts[3])


def _set_options(spec: mujoco.MjSpec, physics_step: float) -> None:
    """Step, friction cone, and no silent reset of a diverged state."""
    spec.option.timestep = physics_step
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET | mujoco.mjtDisableBit.mjDSBL_ACTUATION


def _add_ground(spec: mujoco.MjSpec, terrain: Terrain, region: Region, friction: float) -> None:
    """Plane and blocks; their contact parameters take priority over the robot's."""
    surface = {
        "contype": _ANY_BIT,
        "conaffinity": _ANY_BIT,
        "condim": 3,
        "priority": 1,
        "friction": (friction, *_FALLBACK_FRICTION),
        "solref": _SOLREF,
    }
    if terrain.has_plane:
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0), **surface)
    for block in terrain.blocks(region):
        half = block.pitch / 2
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=block.centre,
            size=block.half_size,
            quat=(np.cos(half), 0.0, np.sin(half), 0.0),
            **surface,
        )


def _compile(spec: mujoco.MjSpec, robot: Robot, joint_friction: float) -> tuple[mujoco.MjModel, int, int]:
    """Add the sensors that the kernels read and build the model; also the sensors' first addresses."""
    body, subtree = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_XBODY
    names = [robot.model.body(b).name for b in range(robot.model.nbody)]
    feet = [leg.sole_body for leg in robot.legs]
    roots = [names[robot.model.jnt_bodyid[leg.joint_indices[0] + 1]] for leg in robot.legs]

    def contact(objtype: object, first: str, reftype: object, second: str, what: int, reduce: int) -> None:
        spec.add_sensor(
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=objtype,
            objname=first,
            reftype=reftype,
            refname=second,
            intprm=[what, reduce, 1],
        )

    n_before = len(spec.sensors)
    for foot in feet:
        contact(body, names[foot], body, "world", _FORCE, _SUM)
    contact(subtree, roots[0], subtree, roots[1], _FOUND, _FIRST)
    for b in range(1, len(names)):
        if b not in feet:
            contact(body, names[b], body, "world", _FOUND, _FIRST)
    n_imu = len(spec.sensors)
    torso = spec.body(names[robot.torso_body])
    imu = torso.add_site(name="gaitsmith_imu", pos=robot.imu_position)
    for kind in (mujoco.mjtSensor.mjSENS_ACCELEROMETER, mujoco.mjtSensor.mjSENS_GYRO):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=imu.name)
    try:
        model = spec.compile()
    except ValueError as error:
        raise PlantError(f"the physics engine refused the model: {error}") from None
    if joint_friction > 0.0:
        model.dof_frictionloss[6:] += joint_friction
        model.dof_solref[6:] = _SOLREF
        model.dof_solimp[6:, :2] = _STICTION
    return model, int(model.sensor_adr[n_before]), int(model.sensor_adr[n_imu])


def _change_masses(model: mujoco.MjModel, data: mujoco.MjData, factor: float, spread: float, seed: int) -> None:
    """Multiply every body's mass and inertia by ``factor (1 ± spread)``."""
    draws = np.random.default_rng([seed, 0xB3]).uniform(-spread, spread, model.nbody)
    model.body_mass[:] *= factor * (1.0 + draws)
    model.body_inertia[:] *= (factor * (1.0 + draws))[:, None]
    mujoco.mj_setConst(model, data)


heard: list[str] = []
"""Warnings of the physics engine, oldest first, instead of its log file in the working folder."""


def _hear(message: str) -> None:
    """Keep at most a hundred warnings."""
    if len(heard) < 100:
        heard.append(" ".join(str(message).split()))


mujoco.set_mju_user_warning(_hear)
