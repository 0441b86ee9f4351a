"""Random starts of the paper's gaits: the same optimum from all of them?

    OMP_NUM_THREADS=1 python benchmarks/random_starts.py [static dynamic start kick] [--count N] [--json]

The control points of the angles start anywhere within 0.2 rad of where planning starts. A start arrives if its gait is
solved with an objective within 1e-3 of the least one.
"""

from __future__ import annotations

import argparse
import json
from typing import Any

import numpy as np

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, Settings, StepParameters
from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.motions.catalogue import cyclic, kick, start
from gaitsmith.synthesis.motions.motion import Motion
from gaitsmith.synthesis.motions.parameters import KickParameters
from gaitsmith.synthesis.motions.settings import Bounds
from gaitsmith.synthesis.program.guess import default_start
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.requests.asked import KICK_FRICTION

STEPS = {"static": StepParameters(0.15, 1.0), "dynamic": StepParameters(0.20, 0.5)}
AWAY = 0.2  # rad
SAME = 1e-3  # of the objective


def motion_of(planner: Planner, name: str) -> tuple[Motion, Settings]:
    """A motion by name, with the settings of the command line."""
    biped = planner.biped
    if name == "kick":
        return kick(biped, KickParameters(), standing(biped)), Settings(bounds=Bounds(friction=KICK_FRICTION))
    if name in STEPS:
        return cyclic(biped, STEPS[name]), Settings()
    gait = planner.plan(cyclic(biped, STEPS["static"])).gait
    assert gait is not None
    q, v, a = gait.joints(0, np.array([0.0]))
    return start(biped, STEPS["static"], standing(biped), (q[:, 0], v[:, 0], a[:, 0])), Settings()


def starts(planner: Planner, name: str, count: int) -> dict[str, Any]:
    """How many of ``count`` random starts arrive."""
    motion, settings = motion_of(planner, name)
    trans, found = Transcription(planner.biped, motion, settings.sized(planner.biped, motion.transfer)), []
    moved = planner.biped.joints * trans.spline.size
    for seed in range(count):
        begin = default_start(trans)
        begin[:moved] += np.random.default_rng(seed).uniform(-AWAY, AWAY, moved)
        found.append(planner.plan(motion, settings, start=begin))
    values = np.array([item.objective if item.solved else np.inf for item in found])
    arrived = int(np.sum(values <= (1.0 + SAME) * values.min()))
    return {"motion": name, "starts": count, "arrived": arrived, "least": float(values.min()),
            "iterations": float(np.median([item.iterations for item in found])),
            "reasons": sorted({item.reason for item in found if item.reason})}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("motions", nargs="*", default=[*STEPS, "start", "kick"], metavar="MOTION")
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    planner, rows = Planner(load_robot("thbip_ii")), []
    for name in arguments.motions:
        rows.append(starts(planner, name, arguments.count))
        if not arguments.json:
            print("{motion}: {arrived} of {starts} at J = {least:.4f}, {iterations:.0f} iterations".format(**rows[-1]))
            print(*rows[-1]["reasons"], sep="\n", end="\n" * bool(rows[-1]["reasons"]), flush=True)
    if arguments.json:
        print(json.dumps(rows))


if __name__ == "__main__":
    main()
