"""What is true in the simulated world, read from the physics engine's arrays by compiled kernels."""

from __future__ import annotations

import math
from typing import NamedTuple

from gaitsmith.compiled import IntVector, Matrix, Vector, bind, kernel

OBSERVED = (
    *("com_velocity_x", "com_velocity_y", "com_velocity_z"),
    *("torso_x", "torso_y", "torso_z", "torso_roll", "torso_pitch", "torso_yaw"),
    *("hip_height_left", "hip_height_right"),
    *("left_sole_x", "left_sole_y", "left_sole_z", "right_sole_x", "right_sole_y", "right_sole_z"),
    *("left_force", "right_force", "foot_separation", "leg_contact", "body_contact"),
)
"""Columns of :attr:`Account.observed`: SI units; CoM velocity in the heading frame, positions in the world."""


class World(NamedTuple):
    """Arrays of the physics engine, shared with it; names and layouts are MuJoCo's.

    Attributes:
        contact_readings: sensor readings: left sole force (3), right sole force (3), number of leg-to-leg contacts,
            number of ground contacts of every body that is not a foot.
        imu_readings: accelerometer (3), gyro (3).
    """

    qpos: Vector
    qvel: Vector
    xpos: Matrix
    xmat: Matrix
    M: Vector
    qfrc_applied: Vector
    imu_readings: Vector
    contact_readings: Vector


class Geometry(NamedTuple):
    """Constants of the robot: body ids, sole frames, torque limits, addresses in the sparse inertia matrix."""

    torso: int
    sole_body: IntVector
    sole_position: Matrix
    hip_midpoint: Vector
    torque_limit: Vector
    row_address: IntVector
    mass: float


class Account(NamedTuple):
    """What the plant keeps about the run.

    Attributes:
        torque: (nj,) commanded at this control tick, N·m.
        delayed: (n + 1, nj) ring of torques, one row a physics step.
        head: (1,) row of the ring written last.
        observed: one value for each name in :data:`OBSERVED`.
        start: (2,) torso position from which the excursion counts, world.
        extremes: smallest foot separation, largest horizontal torso excursion, m.
        counts: leg contact episodes, physics steps with one, physics steps, steps with a state that is not finite.
    """

    torque: Vector
    delayed: Matrix
    head: IntVector
    observed: Vector
    start: Vector
    extremes: Vector
    counts: IntVector


class Readings(NamedTuple):
    """A measurement's arrays and the errors to add to them; see :class:`gaitsmith.control.Measurement`."""

    base_position: Vector
    base_quaternion: Vector
    base_velocity: Vector
    joint_position: Vector
    joint_velocity: Vector
    accelerometer: Vector
    gyro: Vector
    sole_force: Vector
    noise: Vector
    bias: Vector
    encoder_step: float


class PlantArrays(NamedTuple):
    """All that the plant's kernels read and write."""

    world: World
    geometry: Geometry
    account: Account


class SensorArrays(NamedTuple):
    """What a measurement is read from and written to."""

    world: World
    readings: Readings


@kernel
def _sole_height(world: World, geometry: Geometry, leg: int, place: Vector) -> None:
    """World position of a sole frame's origin, into ``place`` (3)."""
    body = geometry.sole_body[leg]
    for i in range(3):
        place[i] = world.xpos[body, i]
        for k in range(3):
            place[i] += world.xmat[body, 3 * i + k] * geometry.sole_position[leg, k]


@kernel
def apply_torque(address: int) -> None:
    """Put the torque that has come through the delay on the joints, within their limits, for one physics step."""
    plant = bind(PlantArrays, address)
    world, geometry, account = plant.world, plant.geometry, plant.account
    rows = account.delayed.shape[0]
    head = (account.head[0] + 1) % rows
    tail = (head + 1) % rows
    account.head[0] = head
    for j in range(account.torque.shape[0]):
        account.delayed[head, j] = account.torque[j]
    for j in range(account.torque.shape[0]):
        limit = geometry.torque_limit[j]
        world.qfrc_applied[6 + j] = min(max(account.delayed[tail, j], -limit), limit)


@kernel
def track(address: int) -> None:
    """After a physics step: foot separation, torso excursion, leg contacts, and whether the state is finite."""
    plant = bind(PlantArrays, address)
    world, geometry, account = plant.world, plant.geometry, plant.account
    observed = account.observed
    _sole_height(world, geometry, 0, observed[11:14])
    _sole_height(world, geometry, 1, observed[14:17])
    torso = geometry.torso
    forward_x, forward_y = world.xmat[torso, 0], world.xmat[torso, 3]
    length = math.sqrt(forward_x * forward_x + forward_y * forward_y)
    if length > 1e-9:
        across = forward_x * (observed[12] - observed[15]) - forward_y * (observed[11] - observed[14])
        observed[19] = across / length
    account.extremes[0] = min(account.extremes[0], observed[19])
    away_x, away_y = world.xpos[torso, 0] - account.start[0], world.xpos[torso, 1] - account.start[1]
    account.extremes[1] = max(account.extremes[1], math.sqrt(away_x * away_x + away_y * away_y))
    touching = world.contact_readings[6]
    if touching > 0.0:
        account.counts[1] += 1
        if observed[20] == 0.0:
            account.counts[0] += 1
    observed[20] = touching
    account.counts[2] += 1
    total = 0.0
    for k in range(world.qpos.shape[0]):
        total += abs(world.qpos[k])
    for k in range(world.qvel.shape[0]):
        total += abs(world.qvel[k])
    if not total < 1e6:
        account.counts[3] += 1


@kernel
def observe(address: int) -> None:
    """Fill the observed columns that are wanted once a control tick; :func:`track` has filled the others."""
    plant = bind(PlantArrays, address)
    world, geometry, account = plant.world, plant.geometry, plant.account
    observed = account.observed
    torso = geometry.torso
    rotation = world.xmat[torso]
    yaw = math.atan2(rotation[3], rotation[0])
    cos_yaw, sin_yaw = math.cos(yaw), math.sin(yaw)
    nv = world.qvel.shape[0]
    velocity_x, velocity_y, velocity_z = world.qvel[0], world.qvel[1], world.qvel[2]
    for j in range(3, nv):
        row = geometry.row_address[j]
        velocity_x += world.M[row] * world.qvel[j] / geometry.mass
        velocity_y += world.M[row + 1] * world.qvel[j] / geometry.mass
        velocity_z += world.M[row + 2] * world.qvel[j] / geometry.mass
    observed[0] = cos_yaw * velocity_x + sin_yaw * velocity_y
    observed[1] = cos_yaw * velocity_y - sin_yaw * velocity_x
    observed[2] = velocity_z
    for i in range(3):
        observed[3 + i] = world.xpos[torso, i]
    observed[6] = math.atan2(rotation[7], rotation[8])
    observed[7] = math.atan2(-rotation[6], math.sqrt(rotation[7] ** 2 + rotation[8] ** 2))
    observed[8] = yaw
    hip = world.xpos[torso, 2]
    for k in range(3):
        hip += rotation[6 + k] * geometry.hip_midpoint[k]
    observed[9] = hip - observed[13]
    observed[10] = hip - observed[16]
    observed[17] = abs(world.contact_readings[2])
    observed[18] = abs(world.contact_readings[5])
    bodies = 0.0
    for k in range(7, world.contact_readings.shape[0]):
        bodies += world.contact_readings[k]
    observed[21] = bodies


@kernel
def read_sensors(address: int, noisy: int) -> None:
    """Fill a measurement: the true state, or, if ``noisy``, what the sensors say (and nothing they cannot know)."""
    sensors = bind(SensorArrays, address)
    world, out = sensors.world, sensors.readings
    nj = out.joint_position.shape[0]
    for i in range(3):
        out.accelerometer[i] = world.imu_readings[i]
        out.gyro[i] = world.imu_readings[3 + i]
    out.sole_force[0] = abs(world.contact_readings[2])
    out.sole_force[1] = abs(world.contact_readings[5])
    for i in range(4):
        out.base_quaternion[i] = world.qpos[3 + i]
    for j in range(nj):
        out.joint_position[j] = world.qpos[7 + j]
    if noisy == 0:
        for i in range(3):
            out.base_position[i] = world.qpos[i]
        for i in range(6):
            out.base_velocity[i] = world.qvel[i]
        for j in range(nj):
            out.joint_velocity[j] = world.qvel[6 + j]
        return
    noise = out.noise
    for i in range(3):
        out.gyro[i] += noise[i]
        out.accelerometer[i] += noise[3 + i] + out.bias[i]
    for j in range(nj):
        angle = out.joint_position[j] + noise[9 + j]
        out.joint_position[j] = (
            math.floor(angle / out.encoder_step + 0.5) * out.encoder_step if out.encoder_step > 0.0 else angle
        )
    w, x, y, z = world.qpos[3], world.qpos[4], world.qpos[5], world.qpos[6]
    a, b, c = 0.5 * noise[6], 0.5 * noise[7], 0.5 * noise[8]
    scale = 1.0 / math.sqrt(1.0 + a * a + b * b + c * c)
    out.base_quaternion[0] = scale * (w - x * a - y * b - z * c)
    out.base_quaternion[1] = scale * (x + w * a + y * c - z * b)
    out.base_quaternion[2] = scale * (y + w * b + z * a - x * c)
    out.base_quaternion[3] = scale * (z + w * c + x * b - y * a)
