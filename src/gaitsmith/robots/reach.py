"""Heights at which the legs reach flat soles below the centre of mass, within the joints' limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitsmith.robots.card import JointLimits
from gaitsmith.robots.robot import Leg

Array = NDArray[np.float64]
STEPS = 60  # of the iteration for one height
DAMPING = 1e-4  # of the straight leg's length, of the squared step
CLOSE = 1e-3  # of the straight leg's length, where a sole is where it should be
FARTHEST = 0.3  # rad, of one step
BENT = 0.3  # of the knee's range, where the search begins
STARTS = (0.9, 0.95, 0.98, 0.8, 0.7, 0.6)  # of the straight leg's length, where it may begin
STEP = 0.01  # of the straight leg's length, between heights that are tried
LOWEST = 0.3  # of the straight leg's length


def heights(
    model: mujoco.MjModel, legs: Sequence[Leg], limits: Mapping[str, JointLimits], length: float, width: float
) -> tuple[float, float] | None:
    """Lowest and highest hip midpoint above flat soles; None if they are reached nowhere.

    Args:
        model: the robot.
        legs: both; a sole without width need not be level from side to side, and legs of less than six joints cannot
            point it forward.
        limits: of the joints, by name.
        length: of a straight leg, hip to sole, m.
        width: half the distance of the soles, m.
    """
    data = mujoco.MjData(model)
    jacobian, turning = np.zeros((3, model.nv)), np.zeros((3, model.nv))
    middle = np.mean([leg.hip_anchor for leg in legs], axis=0)
    names = [model.joint(joint).name for joint in range(1, model.njnt)]
    low, high = np.array([limits[name].position for name in names]).T

    def solve(height: float, start: Array) -> Array | None:
        q = start.copy()
        for _ in range(STEPS):
            data.qpos[:] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *q]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            far = 0.0
            for leg in legs:
                site, columns = model.site(leg.sole_site).id, leg.joint_indices
                rows = ([0, 1, 2, 4] if leg.sole.half_width == 0.0 else [0, 1, 2, 4, 3]) + [5] * (len(columns) > 5)
                wanted = [data.subtree_com[1][0], middle[1] + leg.side * width, middle[2] - height]
                axes = data.site_xmat[site].reshape(3, 3)
                turn = length * np.array([axes[1, 2], -axes[0, 2], -axes[1, 0]])
                error = np.concatenate([wanted - data.site_xpos[site], turn])[rows]
                far = max(far, float(np.abs(error).max()))
                mujoco.mj_jacSite(model, data, jacobian, turning, site)
                matrix = np.vstack([jacobian, length * turning])[rows][:, columns + 6]
                square = matrix @ matrix.T + DAMPING * length**2 * np.eye(len(rows))
                step = matrix.T @ np.linalg.solve(square, error)
                step /= max(1.0, np.abs(step).max() / FARTHEST)
                q[columns] = np.clip(q[columns] + step, low[columns], high[columns])
            if far < CLOSE * length:
                return q
        return None

    first = np.clip(0.0, low, high)
    for knee in (leg.knee for leg in legs):
        nearer, farther = sorted((low[knee], high[knee]), key=abs)
        first[knee] = nearer + BENT * (farther - nearer)
    found = next(((share, q) for share in STARTS if (q := solve(share * length, first)) is not None), None)
    if found is None:
        return None
    ends = []
    for direction in (-STEP, STEP):
        share, q = found
        while LOWEST < share + direction < 1.0 and (near := solve((share + direction) * length, q)) is not None:
            share, q = share + direction, near
        ends.append(share * length)
    return ends[0], ends[1]
