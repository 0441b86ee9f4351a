"""Gait and step state start as documented: the parameters as arrays, a robot at rest on both feet."""

import numpy as np

from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.template.step import STAND, Gait, make_gait, make_step_state

PARAMETERS = GaitParameters(speed=(0.3, -0.1), period=0.4, alpha=0.45, height=0.66, lift=0.08, width=0.04)


def test_gait_holds_the_parameters_by_name() -> None:
    gait = make_gait(PARAMETERS)
    assert isinstance(gait, Gait)
    for name, value in PARAMETERS.model_dump().items():
        np.testing.assert_array_equal(getattr(gait, name), np.atleast_1d(value), err_msg=name)


def test_gaits_share_nothing() -> None:
    one, other = make_gait(PARAMETERS), make_gait(PARAMETERS)
    for a, b in zip(one, other, strict=True):
        assert not np.shares_memory(a, b)


def test_a_robot_starts_at_rest() -> None:
    step = make_step_state()
    assert step.mode[0] == STAND
    for name, array in step._asdict().items():
        assert np.all(array == (1.0 if name == "duration_ratio" else 0.0)), name
    assert step.count.dtype == np.int64
