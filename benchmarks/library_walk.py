"""A minute's walk by a library: from rest to its fastest gait, random speeds and yaw rates, rest again; pushed.

    python benchmarks/library_walk.py LIBRARY [--seeds N ...] [--impulse N·s] [--json]

A new speed (and yaw rate, of a library that has them) is commanded every 11 s; every push has a random direction. The
error is that of the mean speed ahead in the last 2.8 s before the next command: from step to step a speed
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

DURATION, STAGE, STEADY = 60.0, 11.0, 2.8  # s
SWAYS = 1.4  # s over which the torso's yaw is averaged to a heading
FIRST = 6.0  # s of the first stage: rest, and on the way to the fastest gait
STAGES = 4


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
    if spec.yaw_rate:
        for change in fields["changes"][:-1]:
            change["yaw_rate"] = round(rng.uniform(spec.yaw_rate[0], spec.yaw_rate[-1]), 3)
    simulation = Simulation(make_scenario(fields), record=False)
    track = []
    while simulation.step():
        r = simulation.plant.torso_rotation
        track.append((simulation.time, *simulation.plant.com[:2].tolist(), np.arctan2(r[1, 0], r[0, 0])))
    at, x, y, yaw = np.array(track).T
    sways = np.ones(int(SWAYS / (at[1] - at[0])))
    heading = np.convolve(np.unwrap(yaw), sways, "same") / np.convolve(np.ones(len(at)), sways, "same")
    ahead = np.cumsum(np.gradient(x) * np.cos(heading) + np.gradient(y) * np.sin(heading))
    errors = []
    for end, speed in zip(times[1:], speeds, strict=True):
        if end <= at[-1]:
            begin, far = np.interp([end - STEADY, end], at, ahead)
            errors.append(float((far - begin) / (STEADY * speed) - 1.0))
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
