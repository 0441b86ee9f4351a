"""The trees that the dynamics are tested on, and random states of them."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np

import gaitsmith
from gaitsmith.compiled import Matrix, Vector
from gaitsmith.dynamics import Tree, TreeState, make_tree_state, read_tree, update_dynamics

_ROBOTS = Path(gaitsmith.__file__).parent / "robots"
_MODELS = Path(__file__).parent.parent / "models"

# Everything that the robots do not have: ball joint, welded bodies, several anchored joints on one body, reference
# angles, turned bodies and inertial frames, a second root.
IRREGULAR = """
<mujoco><compiler angle="radian"/><option gravity="0.3 -0.2 -9.7"/><worldbody>
  <body name="bracket" pos="0.1 0.2 0.3" euler="0.1 0.2 0.3">
    <body name="cart" pos="0.2 0 0.1" euler="0.3 0 0.1">
      <joint type="slide" axis="1 2 3" ref="0.2" armature="0.4"/>
      <joint axis="0 1 0.5" pos="0.1 0.05 -0.1" ref="0.3" armature="0.02"/>
      <joint axis="1 0 0.2" pos="-0.1 0.02 0.1" ref="-0.2"/>
      <inertial pos="0.02 0.01 0.03" mass="3" diaginertia="0.02 0.03 0.04" euler="0.3 0.4 0.5"/>
      <body name="pod" pos="0 0.1 0.2" euler="0.5 0.1 0">
        <joint type="ball" pos="0.05 -0.02 0.1" armature="0.01"/>
        <inertial pos="0.1 0 0" mass="2" fullinertia="0.05 0.06 0.04 0.005 -0.004 0.003"/>
        <body name="lamp" pos="0.1 0.1 0.1" euler="0 0.4 0.2">
          <inertial pos="0 0.1 0" mass="0.5" diaginertia="0.002 0.003 0.004"/>
          <body name="arm" pos="0.2 0 0"><joint axis="0 0 1"/>
            <inertial pos="0.1 0 0.1" mass="1" diaginertia="0.01 0.02 0.02"/></body>
        </body>
      </body>
    </body>
  </body>
  <body name="drone" pos="1 1 1"><freejoint/>
    <inertial pos="0.1 0 0.2" mass="4" diaginertia="0.1 0.2 0.15" euler="0.1 0.2 0.3"/>
    <body name="rotor" pos="0 0 0.3"><joint axis="0 0 1"/>
      <inertial pos="0.01 0 0" mass="0.2" diaginertia="0.001 0.001 0.002"/></body>
  </body>
</worldbody></mujoco>
"""
NAMES = ("bhr_b2", "planar", "six_joint_legs", "with_arms", "irregular")


class State(NamedTuple):
    """A tree of the package and MuJoCo's data, both at the same random configuration and velocity."""

    model: mujoco.MjModel
    data: mujoco.MjData
    tree: Tree
    state: TreeState
    q: Vector
    v: Vector


@functools.cache
def model_of(name: str) -> mujoco.MjModel:
    if name == "irregular":
        return mujoco.MjModel.from_xml_string(IRREGULAR)
    path = _ROBOTS / name / f"{name}.xml" if name == "bhr_b2" else _MODELS / f"{name}.xml"
    return mujoco.MjModel.from_xml_path(str(path))


def random_state(name: str, seed: int) -> State:
    """Anything a configuration can be: joints within ±2 rad, base within ±5 m, v of 3 rad/s, unnormalised q."""
    model = model_of(name)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-2.0, 2.0, model.nq), rng.normal(0.0, 3.0, model.nv)
    q[:2] *= 2.5
    for joint in range(model.njnt):
        if model.jnt_type[joint] in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL):
            first = model.jnt_qposadr[joint] + (3 if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE else 0)
            q[first : first + 4] = rng.normal(size=4)
    data.qpos, data.qvel = q, v
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    tree = read_tree(model)
    state = make_tree_state(tree)
    update_dynamics(tree, state, q, v)
    return State(model, data, tree, state, q, v)


def shifted(model: mujoco.MjModel, q: Vector, v: Vector, step: float) -> Vector:
    """The configuration reached by moving with v for ``step`` seconds."""
    moved = q.copy()
    mujoco.mj_normalizeQuat(model, moved)
    mujoco.mj_integratePos(model, moved, v, step)
    return moved


def relative_error(got: Vector | Matrix, expected: Vector | Matrix) -> float:
    """Largest difference over the largest expected entry (over 1 if that is smaller than rounding)."""
    scale = float(np.max(np.abs(expected)))
    return float(np.max(np.abs(got - expected))) / (scale if scale > 1e-12 else 1.0)
