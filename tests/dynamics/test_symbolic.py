"""The symbolic recursion against MuJoCo's inverse dynamics, on every tree the tests have."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from gaitsmith.dynamics.symbolic import inverse_dynamics
from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot

MODELS = Path(__file__).resolve().parent.parent / "models"
AGREEMENT = 1e-9  # relative, as the synthesis promises; both sum the same terms in another order
TREES = ("bhr_b2", "thbip_ii", "planar", "six_joint_legs", "with_arms")


def _model(name):
    if name in ("bhr_b2", "thbip_ii"):
        return load_robot(name).model
    return mujoco.MjModel.from_xml_path(str(MODELS / f"{name}.xml"))


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
