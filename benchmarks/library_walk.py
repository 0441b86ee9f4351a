"""A minute's walk by a library: from rest to its fastest gait, random speeds and yaw rates, rest again; pushed.

    python benchmarks/library_walk.py LIBRARY [--seeds N ...] [--impulse N·s] [--json]

A new speed (and yaw rate, of a library that has them) is commanded every 9 s; every push has a random direction. The
error is that of the mean speed along the way in the last 2.8 s before the next command: from step to step a speed
changes by a limited amount only.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

import numpy as np

from gaitsmith.library.folder import Folder
from gaitsmith.simulation import Simulation
from gaitsmith.simulation.scenario import make_scenario

DURATION, STAGE, STEADY = 60.0, 9.0, 2.8  # s
FIRST = 6.0  # s of the first stage: rest, and on the way to the fastest gait
STAGES = 5


def walk(library: str, seed: int, impulse: float) -> dict[str, Any]:
    """One walk: how far it came, and the error of its speed in every stage."""
    spec, _ = Folder(library).spec()
    rng, (low, high) = np.random.default_rng(seed), (spec.speed[0], spec.speed[-1])
    speeds = rng.uniform(low, high, STAGES).round(3)
    speeds[rng.integers(STAGES)] = high
    times = FIRST + STAGE * np.arange(STAGES + 1)
    ways = rng.uniform(0.0, 2.0 * np.pi, STAGES + 1)
    fields: dict[str, Any] = {
        "library": library,
        "robot": spec.robot,
        "speed": [high, 0.0],
        "duration": DURATION,
        "seed": seed,
        "changes": [{"time": float(t), "speed": [float(v), 0.0]} for t, v in zip(times, [*speeds, 0.0], strict=True)],
        "pushes": [
            {"time": float(t), "impulse": [float(impulse * np.cos(way)), float(impulse * np.sin(way)), 0.0]}
            for t, way in zip(times + 0.3 * STAGE, ways, strict=True)
        ],
    }
    rates = np.zeros(STAGES)
    if spec.yaw_rate:
        rates = rng.uniform(spec.yaw_rate[0], spec.yaw_rate[-1], STAGES).round(3)
        for change, rate in zip(fields["changes"], rates, strict=False):
            change["yaw_rate"] = float(rate)
    simulation = Simulation(make_scenario(fields), record=False)
    track = []
    while simulation.step():
        track.append((simulation.time, *simulation.plant.com[:2].tolist()))
    at, x, y = np.array(track).T
    errors = []
    for end, speed, rate in zip(times[1:], speeds, rates, strict=True):
        if end <= at[-1]:
            far = np.hypot(*(np.subtract(*np.interp([end, end - STEADY], at, place)) for place in (x, y)))
            errors.append(float(far / (STEADY * speed * np.sinc(0.5 * rate * STEADY / np.pi)) - 1.0))
    stands = bool(at[-1] > DURATION - 0.01)
    worst = float(np.abs(errors).max(initial=0.0))
    return {"seed": seed, "stands": stands, "time": float(at[-1]), "speeds": speeds.tolist(), "worst_error": worst}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("library")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3])
    parser.add_argument("--impulse", type=float, default=2.0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = []
    for seed in options.seeds:
        rows.append(walk(options.library, seed, options.impulse))
        if not options.json:
            row = rows[-1]
            how = "stands" if row["stands"] else f"falls after {row['time']:.1f} s"
            print(f"seed {seed}: {how}, speed within {100 * row['worst_error']:.1f} %", flush=True)
    if options.json:
        print(json.dumps(rows))


if __name__ == "__main__":
    main()
