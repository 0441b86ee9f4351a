"""One part of the control tick at a time, on the state that a tick has just left, so that each can be timed alone."""

from __future__ import annotations

from time import perf_counter_ns

import numpy as np
import numpy.typing as npt

from gaitsmith.compiled import bind, kernel
from gaitsmith.control.layout import TickGroups
from gaitsmith.dynamics.algorithms import update_dynamics
from gaitsmith.simulation import Simulation
from gaitsmith.whole_body.frames import observe_frames
from gaitsmith.whole_body.solve import solve_whole_body


@kernel
def _dynamics(table: int) -> None:
    """Rigid-body dynamics, frames and Jacobians once more; changes nothing."""
    g = bind(TickGroups, table)
    tree = g.tree
    tree_state = g.tree_state
    legs = g.legs
    frames = g.frames
    control = g.control
    update_dynamics(tree, tree_state, control.q, control.v)
    observe_frames(tree, tree_state, legs, control.v, frames)


@kernel
def _whole_body(table: int) -> None:
    """The whole-body QP once more, from its own active set; moves the torque that the next tick starts from."""
    g = bind(TickGroups, table)
    tree_state = g.tree_state
    legs = g.legs
    frames = g.frames
    motion = g.motion
    task_gains = g.task_gains
    targets = g.targets
    whole_body = g.whole_body
    program = g.program
    solve_whole_body(program, tree_state, legs, targets, frames, task_gains, motion, whole_body)


def time_parts(simulation: Simulation) -> dict[str, float]:
    """Median wall time of the tick's parts over a run, µs; the run is used up.

    Template, inverse kinematics, joint torque and telemetry are what the whole tick takes beyond the other two.

    Args:
        simulation: fresh; its own counts of the QP are of no use afterwards.
    """
    table = simulation.controller._address  # the tick's only argument: a part is called as the tick is
    _dynamics(table)
    _whole_body(table)
    samples: list[tuple[int, int]] = []
    while simulation.step():
        began = perf_counter_ns()
        _dynamics(table)
        between = perf_counter_ns()
        _whole_body(table)
        samples.append((between - began, perf_counter_ns() - between))
    times: npt.NDArray[np.float64] = np.array(samples or [(0, 0)]) / 1000.0
    dynamics, whole_body = np.median(times, axis=0)
    whole = simulation.summary().tick_us.median
    return {
        "dynamics and Jacobians": float(dynamics),
        "whole-body QP": float(whole_body),
        "template, inverse kinematics, torque, telemetry": float(max(whole - dynamics - whole_body, 0.0)),
    }
