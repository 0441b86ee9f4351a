"""What is true in the simulated world, read from the physics engine's arrays by compiled kernels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector, bind, kernel
from gaitsmith.dynamics.rotation import turn_quaternion, world_to_heading
from gaitsmith.estimation.measurement import Measurement


class Truth(NamedTuple):
    """What is true at one control tick, as views of one buffer; SI units, world axes where not said.

    Attributes:
        com_velocity: (3,) heading frame.
        torso: (3,) position.
        attitude: (3,) roll, pitch, yaw of the torso.
        hip_height: (n,) hip midpoint above every sole.
        sole: (3 n,) position of every sole frame.
        force: (n,) normal force on every sole.
        foot_separation: lateral distance, left minus right, of the sole frames, heading frame.
        leg_contact: number of contacts between the legs.
        body_contact: number of contacts between the ground and bodies that are not feet.
        least_separation: smallest foot separation so far, over all physics steps.
        leg_contacts: how many times one leg came to touch the other.
        excursion: largest horizontal distance of the torso from where it was when the walk began.
        diverged: physics steps with a state that is not finite.
    """

    com_velocity: Vector
    torso: Vector
    attitude: Vector
    hip_height: Vector
    sole: Vector
    force: Vector
    foot_separation: Vector
    leg_contact: Vector
    body_contact: Vector
    least_separation: Vector
    leg_contacts: Vector
    excursion: Vector
    diverged: Vector


def truth_columns(legs: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Names of the numbers of every field."""
    axes = ("x", "y", "z")
    return {field: (field,) for field in Truth._fields} | {
        "com_velocity": tuple(f"com_velocity_{axis}" for axis in axes),
        "torso": tuple(f"torso_{axis}" for axis in axes),
        "attitude": ("torso_roll", "torso_pitch", "torso_yaw"),
        "hip_height": tuple(f"hip_height_{leg}" for leg in legs),
        "sole": tuple(f"{leg}_sole_{axis}" for leg in legs for axis in axes),
        "force": tuple(f"{leg}_force" for leg in legs),
    }


def make_truth(legs: Sequence[str]) -> tuple[Truth, Vector, tuple[str, ...]]:
    """Views over one buffer, the buffer, and the name of every number of it."""
    columns = list(truth_columns(legs).values())
    buffer, views, start = np.zeros(sum(map(len, columns))), [], 0
    for members in columns:
        views.append(buffer[start : start + len(members)])
        start += len(members)
    return Truth(*views), buffer, tuple(name for members in columns for name in members)


class World(NamedTuple):
    """Arrays of the physics engine, shared with it; names and layouts are MuJoCo's."""

    qpos: Vector
    qvel: Vector
    xpos: Matrix
    xmat: Matrix
    M: Vector
    qfrc_applied: Vector
    imu_readings: Vector  # accelerometer (3), gyro (3)
    sole_readings: Vector  # force on every sole (3), by contact sensors
    leg_reading: Vector  # (1,) number of contacts between the legs
    body_readings: Vector  # number of ground contacts of every body that is not a foot


class Geometry(NamedTuple):
    """Constants of the robot: body ids, sizes, sole frames, torque limits, addresses in the sparse inertia matrix."""

    torso: int
    nq: int
    nv: int
    sole_body: IntVector
    sole_position: Matrix
    hip_midpoint: Vector
    torque_limit: Vector
    row_address: IntVector
    mass: float


class Account(NamedTuple):
    """What the plant keeps about the run."""

    torque: Vector  # (nj,) commanded at this control tick, N·m
    delayed: Matrix  # (n + 1, nj) ring of torques, one row a physics step
    head: IntVector  # (1,) row of the ring written last
    start: Vector  # (2,) torso position from which the excursion counts, world


class Errors(NamedTuple):
    """What to add to a measurement; see :class:`gaitsmith.simulation.SensorNoise`."""

    noise: Vector
    bias: Vector
    encoder_step: float


class PlantArrays(NamedTuple):
    """All that the plant's kernels read and write."""

    world: World
    geometry: Geometry
    account: Account
    truth: Truth


class SensorArrays(NamedTuple):
    """What a measurement is read from and written to."""

    world: World
    measured: Measurement
    errors: Errors


@kernel
def _sole_position(world: World, geometry: Geometry, leg: int, place: Vector) -> None:
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
    world, geometry, account, truth = plant.world, plant.geometry, plant.account, plant.truth
    left, right = truth.sole[:3], truth.sole[3:6]
    _sole_position(world, geometry, 0, left)
    _sole_position(world, geometry, 1, right)
    torso = geometry.torso
    forward_x, forward_y = world.xmat[torso, 0], world.xmat[torso, 3]
    length = math.sqrt(forward_x * forward_x + forward_y * forward_y)
    if length > 1e-9:
        truth.foot_separation[0] = (forward_x * (left[1] - right[1]) - forward_y * (left[0] - right[0])) / length
    truth.least_separation[0] = min(truth.least_separation[0], truth.foot_separation[0])
    away_x, away_y = world.xpos[torso, 0] - account.start[0], world.xpos[torso, 1] - account.start[1]
    truth.excursion[0] = max(truth.excursion[0], math.sqrt(away_x * away_x + away_y * away_y))
    touching = world.leg_reading[0]
    if touching > 0.0 and truth.leg_contact[0] == 0.0:
        truth.leg_contacts[0] += 1.0
    truth.leg_contact[0] = touching
    total = 0.0
    for k in range(geometry.nq):
        total += abs(world.qpos[k])
    for k in range(geometry.nv):
        total += abs(world.qvel[k])
    if not total < 1e6:
        truth.diverged[0] += 1.0


@kernel
def observe(address: int) -> None:
    """Fill what is wanted of the truth once a control tick; :func:`track` has filled the rest."""
    plant = bind(PlantArrays, address)
    world, geometry, truth = plant.world, plant.geometry, plant.truth
    torso = geometry.torso
    rotation = world.xmat[torso]
    yaw = math.atan2(rotation[3], rotation[0])
    velocity_x, velocity_y, velocity_z = world.qvel[0], world.qvel[1], world.qvel[2]
    for j in range(3, geometry.nv):
        row = geometry.row_address[j]
        velocity_x += world.M[row] * world.qvel[j] / geometry.mass
        velocity_y += world.M[row + 1] * world.qvel[j] / geometry.mass
        velocity_z += world.M[row + 2] * world.qvel[j] / geometry.mass
    truth.com_velocity[0], truth.com_velocity[1] = world_to_heading(
        math.cos(yaw), math.sin(yaw), velocity_x, velocity_y
    )
    truth.com_velocity[2] = velocity_z
    for i in range(3):
        truth.torso[i] = world.xpos[torso, i]
    truth.attitude[0] = math.atan2(rotation[7], rotation[8])
    truth.attitude[1] = math.atan2(-rotation[6], math.sqrt(rotation[7] ** 2 + rotation[8] ** 2))
    truth.attitude[2] = yaw
    hip = world.xpos[torso, 2]
    for k in range(3):
        hip += rotation[6 + k] * geometry.hip_midpoint[k]
    for leg in range(truth.force.shape[0]):
        truth.hip_height[leg] = hip - truth.sole[3 * leg + 2]
        truth.force[leg] = abs(world.sole_readings[3 * leg + 2])
    truth.body_contact[0] = 0.0
    for k in range(world.body_readings.shape[0]):
        truth.body_contact[0] += world.body_readings[k]


@kernel
def read_sensors(address: int, noisy: int) -> None:
    """Fill a measurement: the true state, or, if ``noisy``, what the sensors say (and nothing they cannot know)."""
    sensors = bind(SensorArrays, address)
    world, out, errors = sensors.world, sensors.measured, sensors.errors
    nj = out.joint_position.shape[0]
    for i in range(3):
        out.accelerometer[i] = world.imu_readings[i]
        out.gyro[i] = world.imu_readings[3 + i]
    for leg in range(out.sole_force.shape[0]):
        out.sole_force[leg] = abs(world.sole_readings[3 * leg + 2])
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
    noise, step = errors.noise, errors.encoder_step
    for i in range(3):
        out.gyro[i] += noise[i]
        out.accelerometer[i] += noise[3 + i] + errors.bias[i]
    for j in range(nj):
        angle = out.joint_position[j] + noise[9 + j]
        out.joint_position[j] = math.floor(angle / step + 0.5) * step if step > 0.0 else angle
    for leg in range(out.sole_force.shape[0]):
        out.sole_force[leg] = max(out.sole_force[leg] + noise[9 + nj + leg], 0.0)
    turn_quaternion(out.base_quaternion, noise[6], noise[7], noise[8])
