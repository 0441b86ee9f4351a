"""The model that the physics engine runs: robot, ground, props, and the sensors that the plant reads."""

from __future__ import annotations

import mujoco
import numpy as np
import numpy.typing as npt

from gaitsmith.errors import GaitsmithError
from gaitsmith.robots import Robot
from gaitsmith.simulation.terrain import Region, Terrain

_FOUND, _FORCE = 1, 2  # bits of a contact sensor's data field
_FIRST, _SUM = 0, 3  # how a contact sensor reduces several contacts
_ANY_BIT = 0x7FFFFFFF  # ground collides with every geometry that collides with anything
_SOLREF = (0.005, 1.0)  # s, -: stiff enough that a sole sinks in less than 1 mm
_STICTION = 0.995  # impedance of joint friction: the engine's default lets a held joint creep
_FALLBACK_FRICTION = (0.005, 0.0001)  # torsional and rolling, unused by a contact of dimension 3


class PlantError(GaitsmithError):
    """The physics engine refused the model or stopped; its own message is kept."""


def set_options(spec: mujoco.MjSpec, physics_step: float) -> None:
    """Step, friction cone, and no silent reset of a diverged state."""
    spec.option.timestep = physics_step
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET | mujoco.mjtDisableBit.mjDSBL_ACTUATION


def add_ground(spec: mujoco.MjSpec, terrain: Terrain, region: Region, friction: float) -> None:
    """Plane and blocks; their contact parameters take priority over the robot's."""
    surface = {
        "contype": _ANY_BIT,
        "conaffinity": _ANY_BIT,
        "condim": 3,
        "priority": 1,
        "friction": (friction, *_FALLBACK_FRICTION),
        "solref": _SOLREF,
    }
    if terrain.kind in ("flat", "boxes", "stairs"):
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0), **surface)
    for block in terrain.blocks(region):
        pitch, roll = block.pitch / 2, block.roll / 2
        own = surface if block.friction is None else surface | {"friction": (block.friction, *_FALLBACK_FRICTION)}
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=block.centre,
            size=block.half_size,
            quat=(np.cos(pitch) * np.cos(roll), np.sin(roll), np.sin(pitch), 0.0),  # one of both turns is none
            **own,
        )


def let_legs_pass(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Take away the contacts between the legs."""
    model, below = robot.model, []
    for leg in robot.legs:
        body, found = leg.sole_body, []
        while body != robot.torso_body and body > 0:
            found.append(model.body(body).name)
            body = int(model.body_parentid[body])
        below.append(found)
    known = {frozenset((pair.bodyname1, pair.bodyname2)) for pair in spec.excludes}
    for one in below[0]:
        for other in below[1]:
            if frozenset((one, other)) not in known:
                spec.add_exclude(bodyname1=one, bodyname2=other)


def build(
    spec: mujoco.MjSpec, robot: Robot, joint_friction: npt.NDArray[np.float64], balls: int
) -> tuple[mujoco.MjModel, int, int]:
    """Add the sensors that the kernels read and build the model; also the sensors' first addresses."""
    body, subtree = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_XBODY
    names = [robot.model.body(b).name for b in range(robot.model.nbody)]
    rigid = robot.model.body_weldid
    feet = [int(rigid[leg.sole_body]) for leg in robot.legs]  # what is fixed to the sole is the foot
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
        contact(subtree, names[foot], body, "world", _FORCE, _SUM)
    contact(subtree, roots[0], subtree, roots[1], _FOUND, _FIRST)
    for b in range(1, len(names)):
        if rigid[b] not in feet:
            contact(body, names[b], body, "world", _FOUND, _FIRST)
    n_imu = len(spec.sensors)
    torso = spec.body(names[robot.torso_body])
    turned = np.zeros(4)
    mujoco.mju_mat2Quat(turned, np.asarray(robot.imu_rotation).ravel())
    imu = torso.add_site(name="gaitsmith_imu", pos=robot.imu_position, quat=turned)
    for kind in (mujoco.mjtSensor.mjSENS_ACCELEROMETER, mujoco.mjtSensor.mjSENS_GYRO):
        spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=imu.name)
    try:
        model = spec.compile()
    except ValueError as error:
        raise PlantError(f"the physics engine refused the model: {error}") from None
    joints = 6 + np.flatnonzero(joint_friction > 0.0)
    model.dof_armature[model.nv - 6 * balls :] = model.dof_damping[model.nv - 6 * balls :] = 0.0  # no robot's joints
    model.dof_frictionloss[joints] += joint_friction[joints - 6]
    model.dof_solref[joints] = _SOLREF
    model.dof_solimp[joints, :2] = _STICTION
    return model, int(model.sensor_adr[n_before]), int(model.sensor_adr[n_imu])


def shift_mass(model: mujoco.MjModel, data: mujoco.MjData, body: int, shift: tuple[float, float, float]) -> None:
    """Move a body's centre of mass by ``shift``, body axes, m; its inertia about it stays."""
    model.body_ipos[body] += shift
    mujoco.mj_setConst(model, data)


def change_masses(
    model: mujoco.MjModel, data: mujoco.MjData, bodies: int, factor: float, spread: float, seed: int
) -> None:
    """Multiply mass and inertia of the first bodies by ``factor (1 ± spread)``."""
    factors = factor * (1.0 + np.random.default_rng([seed, 0xB3]).uniform(-spread, spread, bodies))
    model.body_mass[:bodies] *= factors
    model.body_inertia[:bodies] *= factors[:, None]
    mujoco.mj_setConst(model, data)


def contact_forces(
    model: mujoco.MjModel, now: mujoco.MjData, data: mujoco.MjData, bodies: int
) -> npt.NDArray[np.float64]:
    """(n, 6) place (world, m) and force (world axes, N) of the ground's contacts with bodies 1 to ``bodies - 1``.

    After a step the engine knows the contacts of ``now``, but the forces of those before: ``data`` is used for both.
    """
    mujoco.mj_copyData(data, model, now)
    mujoco.mj_forward(model, data)
    pairs, force = model.geom_bodyid[data.contact.geom], np.zeros(6)
    here = np.flatnonzero((pairs.min(axis=1) == 0) & (pairs.max(axis=1) < bodies))
    found, frames = np.zeros((len(here), 6)), data.contact.frame.reshape(-1, 3, 3)
    found[:, :3] = data.contact.pos[here]
    for row, index in zip(found, here, strict=True):
        mujoco.mj_contactForce(model, data, index, force)
        # The contact frame's first axis points from the first body to the second.
        row[3:] = (1.0 if pairs[index, 0] == 0 else -1.0) * frames[index].T @ force[:3]
    return found
