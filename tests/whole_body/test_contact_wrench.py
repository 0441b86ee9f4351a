"""Planned sole wrenches keep to the friction pyramid, the sole's edges, and the yaw bound (eq. 26 and corrections)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest
from tests.control.walking import ROBOTS, parameters, records, robot
from tests.reference.whole_body import contact_rows

from gaitsmith.whole_body.contact_wrench import CONTACT_ROWS, moment_axis, wrench_size

Array = npt.NDArray[np.float64]

SLACK = 1e-6  # N and N·m: 1e-9 of the largest force

names = pytest.mark.parametrize("name", ROBOTS)


def wrenches(name: str) -> Iterator[tuple[int, Array, Array]]:
    """Leg, force, and moment in the contact frame, of every sole that bears the robot."""
    for record in records(name):
        for leg in range(2):
            if record.groups.targets.in_contact[leg]:
                axes = record.groups.frames.contact_rotation[leg]
                wrench = record.groups.whole_body.wrench[leg]
                yield leg, axes.T @ wrench[:3], axes.T @ wrench[3:]


@names
def test_friction_and_normal_force(name: str) -> None:
    contact = parameters(name).contact
    low, high = contact.normal_force
    for _, force, _ in wrenches(name):
        assert low - SLACK <= force[2] <= high + SLACK
        assert np.max(np.abs(force[:2])) <= contact.friction * force[2] + SLACK


@names
def test_zmp_stays_inside_the_sole(name: str) -> None:
    """The moment's zero lies on the sole, the margin away from its edges; so the sole does not tip."""
    margin = parameters(name).contact.zmp_margin
    closest = np.inf
    for leg, force, moment in wrenches(name):
        sole = robot(name).legs[leg].sole
        x, y = -moment[1] / force[2], moment[0] / force[2]
        slack = SLACK / force[2]
        assert margin - sole.heel - slack <= x <= sole.toe - margin + slack
        closest = min(closest, sole.toe - margin - x, x + sole.heel - margin)
        if sole.half_width > 0.0:
            assert abs(y) <= sole.half_width - margin + slack
        else:
            assert abs(y) <= slack
    assert closest < 0.02


@names
def test_yaw_moment_is_bounded(name: str) -> None:
    bound = parameters(name).contact.yaw_friction
    for _, force, moment in wrenches(name):
        assert abs(moment[2]) <= bound * force[2] + SLACK


@names
def test_reported_zmp_is_that_of_the_wrench(name: str) -> None:
    for record in records(name)[::5]:
        axes, wrench = record.groups.frames.contact_rotation, record.groups.whole_body.wrench
        for leg in range(2):
            reported = record.groups.telemetry.zmp[2 * leg : 2 * leg + 2]
            if not record.groups.targets.in_contact[leg]:
                assert not np.any(reported)
                continue
            force, moment = axes[leg].T @ wrench[leg, :3], axes[leg].T @ wrench[leg, 3:]
            point = np.array([-moment[1], moment[0]]) / force[2]
            np.testing.assert_allclose(reported, point, atol=1e-12)
            # About that point of the sole the wrench has no horizontal moment.
            np.testing.assert_allclose((moment - np.cross([*point, 0.0], force))[:2], 0.0, atol=1e-9)


@names
def test_rows_are_those_of_the_reference(name: str) -> None:
    """Each sole's rows in the program, in any order."""
    contact = parameters(name).contact
    sole = robot(name).legs[0].sole
    expected = contact_rows(
        sole.heel, sole.toe, sole.half_width, contact.friction, contact.zmp_margin, contact.yaw_friction
    )
    n_joints, size = len(robot(name).joint_names), expected.shape[1]
    for record in records(name)[::10]:
        program = record.groups.program
        n, m = program.size
        count = int(np.sum(record.groups.targets.in_contact))
        assert (n, m) == (n_joints + count * size, count * len(expected))
        assert not program.row_lower[:m].any()
        assert np.isinf(program.row_upper[:m]).all()
        for k in range(count):
            block = program.rows[k * len(expected) : (k + 1) * len(expected), :n]
            own = slice(n_joints + k * size, n_joints + (k + 1) * size)
            np.testing.assert_allclose(
                np.unique(block[:, own].round(12), axis=0), np.unique(expected.round(12), axis=0), atol=1e-12
            )
            assert not np.delete(block, np.arange(own.start, own.stop), axis=1).any()


@pytest.mark.parametrize(("half_width", "axes"), [(0.0, [1, 2]), (0.04, [0, 1, 2])])
def test_a_line_has_no_moment_about_itself(half_width: float, axes: list[int]) -> None:
    size = wrench_size(half_width)
    assert size == 3 + len(axes)
    assert [moment_axis(half_width, k) for k in range(size - 3)] == axes
    assert 4 + 2 * len(axes) <= CONTACT_ROWS
