from __future__ import annotations

import mujoco
import numpy as np
import pytest
from tests.dynamics.trees import NAMES, model_of

from gaitsmith.dynamics import read_tree
from gaitsmith.errors import BadInput

BODY = '<body name="b" {}>{}<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'


def _model(body: str, rest: str = "") -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{body}</worldbody>{rest}</mujoco>")


@pytest.mark.parametrize(
    ("model", "valid"),
    [
        (_model(BODY.format("", "")), "at least one joint"),
        (_model(BODY.format("", "<freejoint/>") + '<body mocap="true"/>'), "no mocap body"),
        (
            _model(
                BODY.format("", '<joint name="j"/>'),
                '<tendon><fixed armature="2"><joint joint="j" coef="1"/></fixed></tendon>',
            ),
            "tendons without armature",
        ),
    ],
)
def test_what_the_tree_cannot_represent_is_refused(model, valid):
    with pytest.raises(BadInput, match=valid):
        read_tree(model)


@pytest.mark.parametrize("name", NAMES)
def test_inertia_keeps_its_principal_moments(name):
    model = model_of(name)
    tree = read_tree(model)
    for body in range(1, model.nbody):
        got = np.linalg.eigvalsh(tree.inertia[body])
        np.testing.assert_allclose(got, np.sort(model.body_inertia[body]), atol=1e-14)


def test_the_tree_is_a_copy():
    model = _model(BODY.format("", "<freejoint/>"))
    tree = read_tree(model)
    model.body_mass[1] = 7.0
    model.opt.gravity[2] = 0.0
    assert tree.mass[1] == 1.0
    assert tree.gravity[2] == -9.81
