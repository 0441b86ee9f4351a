"""A plan made up for tests: two steps, repeated, with curves that need no robot."""

import numpy as np

from gaitsmith.planned.table import PER_SOLE, SOLES, TERMS, PlanTable
from gaitsmith.whole_body.reference import FLAT, NONE

JOINTS = 3
STEP, WIDTH, HEIGHT = 0.2, 0.1, 0.4  # m
SINGLE, DOUBLE = 0.3, 0.1  # s


def two_steps(passes=2, seed=None):
    """Left support, both, right support, both: the CoM moves evenly at STEP / (SINGLE + DOUBLE), halfway between."""
    channels = SOLES + 2 * PER_SOLE + JOINTS
    motion = np.zeros((4, TERMS, channels))
    if seed is not None:
        motion[:] = np.random.default_rng(seed).normal(size=motion.shape) * 0.1
    else:
        motion[:, 0, 2] = HEIGHT
    support, contact = np.array([0, 0, 1, 1]), np.array([[FLAT, NONE], [FLAT, FLAT], [NONE, FLAT], [FLAT, FLAT]])
    place = np.zeros((4, 2, 4))
    place[0, 1], place[1, 1] = (-STEP, -WIDTH, 0.0, 0.0), (STEP, -WIDTH, 0.0, 0.0)
    place[2, 0], place[3, 0] = (-STEP, WIDTH, 0.0, 0.0), (STEP, WIDTH, 0.0, 0.0)
    first, second = np.eye(2)[[0, 0, 1, 1]], np.eye(2)[[0, 1, 1, 0]]
    if seed is None:
        speed = STEP / (SINGLE + DOUBLE)
        for section, span, begin in zip(range(4), (SINGLE, DOUBLE) * 2, (0.0, SINGLE) * 2, strict=True):
            side = 1.0 if support[section] == 0 else -1.0
            motion[section, 0, 0] = speed * (begin + 0.5 * span) - 0.5 * STEP + 0.5 * speed * DOUBLE
            motion[section, 1, 0] = 0.5 * speed * span
            motion[section, 0, 1] = -0.5 * side * WIDTH
            for row in range(2):
                motion[section, 0, SOLES + PER_SOLE * row : SOLES + PER_SOLE * row + 3] = place[section, row, :3]
            if contact[section].min() == NONE:
                row = int(np.argmin(contact[section]))
                motion[section, 0, SOLES + PER_SOLE * row] = 0.0
                motion[section, 1, SOLES + PER_SOLE * row] = STEP
    effort = np.zeros((4, TERMS, JOINTS + 2 * PER_SOLE))
    effort[:, 0, JOINTS + 2], effort[:, 0, JOINTS + PER_SOLE + 2] = 100.0 * (contact > 0).T
    spans = np.array([SINGLE, DOUBLE] * 2)
    return PlanTable(
        sequence=np.arange(4),
        loop_first=0,
        loop_end=4,
        passes=passes,
        duration=spans,
        phase=np.arange(4),
        support=support,
        contact=contact,
        by_contact=np.array([1, 0, 1, 0]),
        stretch_start=np.zeros(4),
        stretch_duration=spans.copy(),
        weight_from=first,
        weight_to=second,
        place=place,
        motion=motion,
        effort=effort,
    )
