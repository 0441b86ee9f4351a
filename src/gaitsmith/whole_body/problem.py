"""The whole-body QP and all that it is made of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gaitsmith.compiled import IntVector, Matrix, Vector
from gaitsmith.compiled.lanes import padded, storage
from gaitsmith.qp.quadratic_program import QuadraticProgram, make_quadratic_program
from gaitsmith.whole_body.contact import FORCE_ROWS, ContactBounds, Contacts, make_contacts
from gaitsmith.whole_body.forward_dynamics import Motion, make_motion, variable_count
from gaitsmith.whole_body.frames import Body
from gaitsmith.whole_body.reference import Reference


class JointBounds(NamedTuple):
    """Bounds on the joints besides their torque limits.

    Attributes:
        torque_step: largest change of a torque from one tick to the next, N·m.
        stop_rate: how fast a joint may approach its stop: the rate of a critically damped approach, 1/s.
    """

    torque_step: float
    stop_rate: float


class Solution(NamedTuple):
    """Result of the whole-body QP.

    Attributes:
        torque: (nj,) N·m, the last accepted solution.
        wrench: (n, 6) force and moment on each sole at its origin, world axes, N and N·m; 0 for a sole in the air.
        acceleration: (nv,) that the solution predicts.
        fresh: (1,) 1 until a first solution: the change of torque is not bounded then.
        elapsed: (1,) ticks since the torque before, more than one after late ticks.
        solves: (1,) since the reset.
        fallbacks: (1,) ticks without a solution.
        infeasible: (1,) of these, ticks whose bounds contradict each other.
        stops_dropped: (1,) ticks that could not keep every joint off its stops, and braked them as hard as they could.
        status: (1,) of the last solve.
        iterations: (1,) of the last solve.
        stop_rows: (1,) rows of joint stops in the last solve.
    """

    torque: Vector
    wrench: Matrix
    acceleration: Vector
    fresh: IntVector
    elapsed: IntVector
    solves: IntVector
    fallbacks: IntVector
    infeasible: IntVector
    stops_dropped: IntVector
    status: IntVector
    iterations: IntVector
    stop_rows: IntVector


class WholeBody(NamedTuple):
    """What whole-body control reads and writes in a tick."""

    body: Body
    reference: Reference
    contacts: Contacts
    contact_bounds: ContactBounds
    joint_bounds: JointBounds
    motion: Motion
    program: QuadraticProgram
    solution: Solution


def make_whole_body(
    body: Body, reference: Reference, contact_bounds: ContactBounds, joint_bounds: JointBounds
) -> WholeBody:
    """A problem that has not been solved yet, for a body and the reference that it is to follow."""
    nv, n_joints, n_soles = body.v.shape[0], reference.joint.shape[1], len(reference.contact)
    counts = {name: np.zeros(1, dtype=np.int64) for name in Solution._fields[5:]}
    torque, wrench = np.zeros(n_joints), np.zeros((n_soles, 6))
    n = variable_count(n_joints, n_soles)
    rows = (FORCE_ROWS + max(body.legs.edge.shape[1], 2)) * n_soles + n_joints
    return WholeBody(
        body=body,
        reference=reference,
        contacts=make_contacts(nv, n_soles),
        contact_bounds=contact_bounds,
        joint_bounds=joint_bounds,
        motion=make_motion(nv, n_joints, n_soles),
        program=make_quadratic_program(padded(n + 1), rows)._replace(hessian=storage(padded(n + 1), n + 1)),
        solution=Solution(torque, wrench, np.zeros(nv), *np.ones((2, 1), dtype=np.int64), **counts),
    )
