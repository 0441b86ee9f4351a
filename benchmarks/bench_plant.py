"""Time of one control tick of the closed loop without its controller: physics, and everything around it.

python benchmarks/bench_plant.py [--json] [--ticks N]
"""

from __future__ import annotations

import argparse
import json
import math
import os
from collections.abc import Callable
from time import perf_counter
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import mujoco
import numpy as np

from gaitsmith.estimation.measurement import make_measurement
from gaitsmith.kinematics.posture import standing_posture
from gaitsmith.robots import load_robot
from gaitsmith.simulation.plant import Plant
from gaitsmith.simulation.sensors import SensorNoise
from gaitsmith.simulation.terrain import parse_terrain

CASES: dict[str, dict[str, Any]] = {
    "flat, true state": {},
    "flat, sensors, friction, delay": {"sensors": SensorNoise(), "joint_friction": 3.0, "torque_delay": 0.002},
    "slope, true state": {"terrain": parse_terrain("slope:8")},
    "boxes, true state": {"terrain": parse_terrain("boxes:0.06", 1)},
}
BATCH = 50  # short enough that another process seldom interrupts one


def _least_us(works: list[Callable[[], None]], ticks: int) -> list[float]:
    """Mean time of one call in the fastest batch, µs; batches take turns, so that all see the same machine."""
    best = [math.inf] * len(works)
    for _ in range(max(2, ticks // BATCH)):
        for k, work in enumerate(works):
            began = perf_counter()
            for _ in range(BATCH):
                work()
            best[k] = min(best[k], (perf_counter() - began) / BATCH * 1e6)
    return best


def _case(options: dict[str, Any], ticks: int) -> dict[str, float]:
    """A whole plant tick from one state, MuJoCo's share of it, and the difference; µs."""
    robot = load_robot("bhr_b2")
    posture = standing_posture(robot, 0.66, 0.0875)
    plant = Plant(robot, **options)
    plant.reset(posture)
    into, torque = make_measurement(len(robot.joint_names)), np.zeros(len(robot.joint_names))
    for _ in range(100):
        plant.step(400 * (posture[7:] - plant.q[7:]) - 10 * plant.v[6:])
    model, data = plant._model, plant._data
    q, v = plant.q.copy(), plant.v.copy()

    def restore() -> None:
        plant.q[:], plant.v[:] = q, v

    def whole() -> None:
        restore()
        plant.measure(into)
        plant.step(torque)

    def engine() -> None:
        restore()
        for _ in range(2):
            mujoco.mj_step2(model, data)
            mujoco.mj_step1(model, data)

    base, tick, physics = _least_us([restore, whole, engine], ticks)
    return {"tick": tick - base, "mujoco": physics - base, "overhead": tick - physics}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")
    parser.add_argument("--ticks", type=int, default=10_000, help="control ticks per case")
    options = parser.parse_args()
    plant = {name: _case(case, options.ticks) for name, case in CASES.items()}
    if options.json:
        print(json.dumps({"plant_us": plant}))
        return
    print(f"{'one control tick of the plant, µs':34} {'tick':>8} {'mujoco':>8} {'overhead':>9}")
    for name, row in plant.items():
        print(f"{name:34} {row['tick']:8.1f} {row['mujoco']:8.1f} {row['overhead']:9.1f}")


if __name__ == "__main__":
    main()
