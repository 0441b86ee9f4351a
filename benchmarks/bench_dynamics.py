"""Time of the tick's dynamics: this package's kernel beside MuJoCo's and Pinocchio's functions for the same results.

One call finds mass matrix, bias, centre of mass with Jacobian, and Jacobian and velocity-product acceleration of two
points, for a new random state of BHR-B2.

    python benchmarks/bench_dynamics.py [--calls N] [--json]
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
from rich.console import Console
from rich.table import Table

from gaitsmith.compiled import Arena, Cube, IntVector, Matrix, bind, kernel
from gaitsmith.dynamics import Tree, TreeState, make_tree_state, point_bias, point_jacobian, read_tree, update_dynamics
from gaitsmith.robots import load_robot

BATCH = 20  # short enough that another process seldom interrupts one


class Work(NamedTuple):
    """Random states, the points, and what is found about them."""

    q: Matrix
    v: Matrix
    body: IntVector
    point: Matrix
    jacobian: Cube
    bias: Matrix


class Bound(NamedTuple):
    """All that a timed call binds."""

    tree: Tree
    state: TreeState
    work: Work


@kernel
def run(table: int, row: int) -> None:
    g = bind(Bound, table)
    work = g.work
    update_dynamics(g.tree, g.state, work.q[row], work.v[row])
    for k in range(2):
        point_jacobian(g.tree, g.state, work.body[k], work.point[k], work.jacobian[k])
        point_bias(g.tree, g.state, work.body[k], work.point[k], work.bias[k])


@kernel
def run_batch(table: int, first: int) -> None:
    for row in range(first, first + BATCH):
        run(table, row)


def _with_mujoco(model: mujoco.MjModel, work: Work) -> Callable[[int], None]:
    data = mujoco.MjData(model)
    nv = model.nv
    dense, com_jacobian = np.zeros((nv, nv)), np.zeros((3, nv))
    linear, angular = np.zeros((3, nv)), np.zeros((3, nv))

    def call(row: int) -> None:
        data.qpos[:] = work.q[row]
        data.qvel[:] = work.v[row]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_crb(model, data)
        mujoco.mj_fullM(model, data, dense)
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, data.qfrc_bias)
        mujoco.mj_subtreeVel(model, data)
        mujoco.mj_jacSubtreeCom(model, data, com_jacobian, 0)
        for k in range(2):
            mujoco.mj_jac(model, data, linear, angular, work.point[k], work.body[k])
            mujoco.mj_jacDot(model, data, linear, angular, work.point[k], work.body[k])
            _ = linear @ data.qvel, angular @ data.qvel

    return call


def _with_pinocchio(path: str, body_names: list[str], work: Work) -> Callable[[int], None]:
    model = pin.buildModelFromMJCF(path)
    data = model.createData()
    frames = [model.getFrameId(name) for name in body_names]
    zero = np.zeros(model.nv)
    q, v = work.q[:, [0, 1, 2, 4, 5, 6, 3, *range(7, model.nq)]].copy(), work.v
    aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def call(row: int) -> None:
        pin.crba(model, data, q[row])
        pin.nonLinearEffects(model, data, q[row], v[row])
        pin.centerOfMass(model, data, q[row], v[row], zero)
        pin.jacobianCenterOfMass(model, data, q[row], False)
        pin.computeJointJacobians(model, data, q[row])
        pin.forwardKinematics(model, data, q[row], v[row], zero)
        for frame in frames:
            pin.getFrameJacobian(model, data, frame, aligned)
            pin.getFrameClassicalAcceleration(model, data, frame, aligned)

    return call


def _times(call: Callable[[int], None], calls: int) -> dict[str, float]:
    """Median and 99th percentile of single calls, µs."""
    for row in range(50):
        call(row)
    found = np.zeros(calls)
    for row in range(calls):
        start = time.perf_counter_ns()
        call(row)
        found[row] = (time.perf_counter_ns() - start) * 1e-3
    return {"median": float(np.median(found)), "p99": float(np.percentile(found, 99.0))}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=5000, metavar="N", help="timed calls, at least 100")
    parser.add_argument("--json", action="store_true", help="print one JSON document and nothing else")
    options = parser.parse_args()
    if options.calls < 100:
        parser.error(f"--calls: got {options.calls}, expected at least 100")
    robot = load_robot("bhr_b2")
    model, calls = robot.model, options.calls
    rng = np.random.default_rng(0)
    tree = read_tree(model)
    bodies = [leg.sole_body for leg in robot.legs]
    work = Work(
        q=rng.normal(size=(calls, model.nq)),
        v=rng.normal(size=(calls, model.nv)),
        body=np.array(bodies, dtype=np.int64),
        point=rng.normal(size=(2, 3)),
        jacobian=np.zeros((2, 6, model.nv)),
        bias=np.zeros((2, 6)),
    )
    work.q[:, 3:7] /= np.linalg.norm(work.q[:, 3:7], axis=1, keepdims=True)
    arena = Arena(Bound(tree, make_tree_state(tree), work))
    table = arena.address
    run(table, 0)
    names = [model.body(body).name for body in bodies]
    found = {
        "gaitsmith, inside a kernel": {
            name: value / BATCH for name, value in _times(lambda row: run_batch(table, row % 40), calls // 4).items()
        },
        "gaitsmith, from Python": _times(lambda row: run(table, row), calls),
        "mujoco, from Python": _times(_with_mujoco(model, work), calls),
        "pinocchio, from Python": _times(_with_pinocchio(str(robot.model_path), names, work), calls),
    }
    if options.json:
        print(json.dumps({"robot": "bhr_b2", "nv": model.nv, "calls": calls, "microseconds": found}, allow_nan=False))
        return
    shown = Table(
        title=f"Dynamics of BHR-B2 ({model.nv} degrees of freedom), µs",
        caption=f"inside a kernel: means of {BATCH} calls",
    )
    for column in ("", "median", "p99"):
        shown.add_column(column, justify="left" if not column else "right")
    for name, times in found.items():
        shown.add_row(name, f"{times['median']:.2f}", f"{times['p99']:.2f}")
    Console().print(shown)


if __name__ == "__main__":
    main()
