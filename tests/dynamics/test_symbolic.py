"""The symbolic recursion against MuJoCo's inverse dynamics, on every tree the tests have."""

from pathlib import Path

import casadi as ca
import mujoco
import numpy as np
import pytest

from gaitsmith.dynamics import make_tree_state, read_tree, update_dynamics
from gaitsmith.dynamics.rotation import scaled_rotation_entries
from gaitsmith.dynamics.symbolic import BodyMotion, at_rest, newton_euler
from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot

MODELS = Path(__file__).resolve().parent.parent / "models"
AGREEMENT = 1e-9  # relative, as the synthesis promises; both sum the same terms in another order
TREES = ("bhr_b2", "thbip_ii", "planar", "six_joint_legs", "with_arms")


def _model(name):
    if name in ("bhr_b2", "thbip_ii"):
        return load_robot(name).model
    return mujoco.MjModel.from_xml_path(str(MODELS / f"{name}.xml"))


def inverse_dynamics(model):
    """CasADi function (qpos, qvel, qacc) -> generalized forces (nv); the tree hangs on the world or on a free joint."""
    q, v, a = ca.SX.sym("q", model.nq), ca.SX.sym("v", model.nv), ca.SX.sym("a", model.nv)
    tau = ca.SX.zeros(model.nv)
    if model.jnt_type[0] != mujoco.mjtJoint.mjJNT_FREE:
        found = newton_euler(model, 0, at_rest(model), q, v, a)
    else:
        entries = scaled_rotation_entries(2.0, *(q[3 + k] for k in range(4)))
        R = ca.vertcat(*(ca.horzcat(*entries[3 * k : 3 * k + 3]) for k in range(3)))
        linear = ca.mtimes(R.T, a[:3] - ca.DM(model.opt.gravity))
        start = BodyMotion(R, q[:3], v[3:6], ca.mtimes(R.T, v[:3]), a[3:6], linear)
        found = newton_euler(model, int(model.jnt_bodyid[0]), start, q, v, a)
        own = ca.DM(model.dof_armature[:6]) * a[:6] + ca.DM(model.dof_damping.ravel()[:6]) * v[:6]
        tau[:6] = ca.vertcat(ca.mtimes(R, found.root_force), found.root_moment) + own
    for dof, value in found.generalized.items():
        tau[dof] = value
    return ca.Function("inverse_dynamics", [q, v, a], [tau])


@pytest.mark.parametrize("name", TREES)
def test_inverse_dynamics_equal_mujocos(name):
    model = _model(name)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    function, data, rng = inverse_dynamics(model), mujoco.MjData(model), np.random.default_rng(1)
    for _ in range(20):
        data.qpos[:] = rng.normal(size=model.nq) * 0.6
        mujoco.mj_normalizeQuat(model, data.qpos)
        data.qvel[:], data.qacc[:] = rng.normal(size=model.nv), rng.normal(size=model.nv) * 5.0
        q, v, a = data.qpos.copy(), data.qvel.copy(), data.qacc.copy()
        mujoco.mj_inverse(model, data)
        found = np.array(function(q, v, a)).ravel()
        scale = max(1.0, float(np.abs(data.qfrc_inverse).max()))
        assert np.abs(found - data.qfrc_inverse).max() < AGREEMENT * scale


@pytest.mark.parametrize("name", ["bhr_b2", "thbip_ii"])
def test_symbolic_and_compiled_dynamics_are_one(name):
    """M q̈ + h by the kernels, with the joints' damping, is the recursion's force."""
    model = load_robot(name).model
    tree = read_tree(model)
    state, rng = make_tree_state(tree), np.random.default_rng(2)
    q, v, a = rng.normal(size=model.nq) * 0.6, rng.normal(size=model.nv), rng.normal(size=model.nv) * 5.0
    q[3:7] /= np.linalg.norm(q[3:7])
    update_dynamics(tree, state, q, v)
    compiled = state.mass_matrix @ a + state.bias + model.dof_damping.ravel()[: model.nv] * v
    symbolic = np.array(inverse_dynamics(model)(q, v, a)).ravel()
    assert np.abs(compiled - symbolic).max() < AGREEMENT * np.abs(symbolic).max()


def test_reflected_inertia_damping_and_springs_are_the_models():
    text = """<mujoco><worldbody><body><joint axis="0 1 0" pos=".1 0 .05" armature=".3" damping=".7" stiffness="2"
    springref=".4"/><geom type="box" size=".1 .2 .3" pos=".05 0 -.2"/><body pos="0 .1 -.4" quat=".8 .6 0 0">
    <joint type="slide" axis="1 2 3" armature=".2"/><geom type="sphere" size=".1"/></body></body>
    </worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qacc[:] = (0.3, -0.2), (0.5, 1.0), (2.0, -1.0)
    mujoco.mj_inverse(model, data)
    found = np.array(inverse_dynamics(model)(data.qpos, data.qvel, data.qacc)).ravel()
    assert np.allclose(found, data.qfrc_inverse, rtol=AGREEMENT, atol=1e-9)


def test_recursion_is_short():
    # About 2,100 instructions were expected of a direct recursion; M q̈ + h would take 5,942.
    assert inverse_dynamics(load_robot("thbip_ii").model).n_instructions() < 2100


def test_ball_joints_are_refused():
    text = '<mujoco><worldbody><body><joint type="ball"/><geom size=".1"/></body></worldbody></mujoco>'
    with pytest.raises(BadInput, match="hinge"):
        inverse_dynamics(mujoco.MjModel.from_xml_string(text))
