"""Gait and step state start as documented: the parameters as views of one array, a robot at rest on both feet."""

import numpy as np

from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.template.step import STAND, GaitInputs, make_gait_inputs, make_step_state

PARAMETERS = GaitParameters(speed=(0.3, -0.1), period=0.4, alpha=0.45, height=0.66, lift=0.08, width=0.04, yaw_rate=0.2)


def test_inputs_hold_the_parameters_by_name() -> None:
    gait = make_gait_inputs(PARAMETERS)
    assert set(PARAMETERS.model_dump()) | {"values"} == set(GaitInputs._fields)
    for name, value in PARAMETERS.model_dump().items():
        np.testing.assert_array_equal(getattr(gait, name), np.atleast_1d(value), err_msg=name)


def test_inputs_are_views_of_one_array() -> None:
    """So that all are taken over at once; two gaits share nothing."""
    one, other = make_gait_inputs(PARAMETERS), make_gait_inputs(PARAMETERS)
    for name in PARAMETERS.model_dump():
        assert np.shares_memory(getattr(one, name), one.values)
    assert not np.shares_memory(one.values, other.values)
    one.values[:] = np.arange(len(one.values))
    np.testing.assert_array_equal(np.concatenate([*one[:-1]]), one.values)


def test_a_robot_starts_at_rest() -> None:
    step = make_step_state(3, 5)
    assert step.mode[0] == STAND
    assert step.foot_desired.shape == (3, 3, 3)
    assert step.leg_rate.shape == (3, 5)
    for name, array in step._asdict().items():
        assert np.all(array == (1.0 if name in ("duration_ratio", "rate") else 0.0)), name
    assert step.count.dtype == np.int64
