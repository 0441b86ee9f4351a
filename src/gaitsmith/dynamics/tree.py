"""A floating-base tree as arrays: constants read once from MuJoCo's model, and room for one configuration's results.

Spatial vectors are angular part first, then linear part, in world axes about one common point (the base), so no
frame transform appears anywhere; Featherstone, *Rigid Body Dynamics Algorithms*, chapters 5 and 6.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gaitsmith.compiled import Cube, IntVector, Matrix, Vector
from gaitsmith.dynamics.rotation import rotation_matrix
from gaitsmith.errors import BadInput

if TYPE_CHECKING:
    import mujoco

FREE, BALL, SLIDE, HINGE = 0, 1, 2, 3  # MuJoCo's joint kinds


class Tree(NamedTuple):
    """Constants of a tree of ``n_body`` bodies (world included), ``n_joint`` joints and ``nv`` degrees of freedom.

    Attributes:
        body_parent: (n_body,) parent of every body; parents come first.
        body_offset: (n_body, 3) origin in the parent's axes before the joints move, m.
        body_turn: (n_body, 3, 3) body axes in the parent's before the joints move.
        body_joint: (n_body,) first joint of the body.
        body_joint_count: (n_body,) how many joints it has.
        body_dof: (n_body,) last degree of freedom that moves the body, -1 if none does.
        joint_kind: (n_joint,) one of FREE, BALL, SLIDE, HINGE.
        joint_q: (n_joint,) first index in q.
        joint_v: (n_joint,) first index in v.
        joint_axis: (n_joint, 3) axis in body axes, unit length.
        joint_anchor: (n_joint, 3) a point of the axis in body axes, m.
        joint_zero: (n_joint,) the value of q at which the body stands as ``body_turn`` and ``body_offset`` say.
        dof_body: (nv,) body that a degree of freedom belongs to.
        dof_parent: (nv,) the degree of freedom before it on the way to the root, -1 if none.
        armature: (nv,) reflected rotor inertia, kg·m² or kg.
        mass: (n_body,) kg.
        mass_centre: (n_body, 3) centre of mass in body axes, m.
        inertia: (n_body, 3, 3) about the centre of mass in body axes, kg·m².
        gravity: (3,) m/s².
        total_mass: kg.
    """

    body_parent: IntVector
    body_offset: Matrix
    body_turn: Cube
    body_joint: IntVector
    body_joint_count: IntVector
    body_dof: IntVector
    joint_kind: IntVector
    joint_q: IntVector
    joint_v: IntVector
    joint_axis: Matrix
    joint_anchor: Matrix
    joint_zero: Vector
    dof_body: IntVector
    dof_parent: IntVector
    armature: Vector
    mass: Vector
    mass_centre: Matrix
    inertia: Cube
    gravity: Vector
    total_mass: float


class TreeState(NamedTuple):
    """One configuration and velocity: what :func:`gaitsmith.dynamics.update_dynamics` finds, world axes throughout.

    Attributes:
        body_rotation: (n_body, 3, 3) body axes to world.
        body_position: (n_body, 3) body origins, m.
        mass_matrix: (nv, nv) symmetric, armature included.
        bias: (nv,) C(q, v) v + g(q), MuJoCo's ``qfrc_bias``.
        com: (3,) centre of mass, m.
        com_velocity: (3,) m/s.
        com_jacobian: (3, nv).
        com_bias: (3,) J̇_com v, m/s².
        reference: (3,) the point that all spatial vectors are about, m.
        motion: (nv, 6) motion subspace of every degree of freedom.
        velocity: (n_body, 6) spatial velocity.
        acceleration: (n_body, 6) spatial acceleration while v is constant, without gravity.
        composite: (n_body, 10) inertia of the subtree about the reference: mass, first moment, xx yy zz xy xz yz.
        force: (n_body, 6) moment and force that the subtree needs while v is constant, gravity included.
    """

    body_rotation: Cube
    body_position: Matrix
    mass_matrix: Matrix
    bias: Vector
    com: Vector
    com_velocity: Vector
    com_jacobian: Matrix
    com_bias: Vector
    reference: Vector
    motion: Matrix
    velocity: Matrix
    acceleration: Matrix
    composite: Matrix
    force: Matrix


def read_tree(model: mujoco.MjModel) -> Tree:
    """The constants of a compiled MuJoCo model; later changes to ``model`` are not seen.

    Raises:
        BadInput: nothing in the model moves, or it has a mocap body or a tendon with armature.
    """
    if model.nv == 0:
        raise BadInput("model", model.nv, "at least one joint", "add a free joint to the torso")
    if model.nmocap:
        raise BadInput("model", model.nmocap, "no mocap body", "remove the mocap attribute")
    if np.any(model.tendon_armature != 0.0):
        largest = float(np.max(model.tendon_armature))
        raise BadInput("model", largest, "tendons without armature", "set it on the joints")
    n_body = model.nbody
    body_dof = np.full(n_body, -1, dtype=np.int64)
    inertia = np.zeros((n_body, 3, 3))
    for body in range(1, n_body):
        count = model.body_dofnum[body]
        own = model.body_dofadr[body] + count - 1
        body_dof[body] = own if count else body_dof[model.body_parentid[body]]
        principal = rotation_matrix(model.body_iquat[body])
        inertia[body] = principal @ np.diag(model.body_inertia[body]) @ principal.T
    return Tree(
        body_parent=_integers(model.body_parentid),
        body_offset=model.body_pos.copy(),
        body_turn=np.array([rotation_matrix(quaternion) for quaternion in model.body_quat]),
        body_joint=_integers(model.body_jntadr),
        body_joint_count=_integers(model.body_jntnum),
        body_dof=body_dof,
        joint_kind=_integers(model.jnt_type),
        joint_q=_integers(model.jnt_qposadr),
        joint_v=_integers(model.jnt_dofadr),
        joint_axis=model.jnt_axis.copy(),
        joint_anchor=model.jnt_pos.copy(),
        joint_zero=model.qpos0[model.jnt_qposadr].copy(),
        dof_body=_integers(model.dof_bodyid),
        dof_parent=_integers(model.dof_parentid),
        armature=model.dof_armature.copy(),
        mass=model.body_mass.copy(),
        mass_centre=model.body_ipos.copy(),
        inertia=inertia,
        gravity=np.array(model.opt.gravity, dtype=np.float64),
        total_mass=float(np.sum(model.body_mass[1:])),
    )


def _integers(values: object) -> IntVector:
    """A copy as 64-bit integers."""
    return np.array(values, dtype=np.int64)


def make_tree_state(tree: Tree) -> TreeState:
    """Zeroed arrays for one configuration of ``tree``."""
    n_body, nv = len(tree.body_parent), len(tree.dof_body)
    return TreeState(
        body_rotation=np.tile(np.eye(3), (n_body, 1, 1)),
        body_position=np.zeros((n_body, 3)),
        mass_matrix=np.zeros((nv, nv)),
        bias=np.zeros(nv),
        com=np.zeros(3),
        com_velocity=np.zeros(3),
        com_jacobian=np.zeros((3, nv)),
        com_bias=np.zeros(3),
        reference=np.zeros(3),
        motion=np.zeros((nv, 6)),
        velocity=np.zeros((n_body, 6)),
        acceleration=np.zeros((n_body, 6)),
        composite=np.zeros((n_body, 10)),
        force=np.zeros((n_body, 6)),
    )
