"""Ten random starts of the static gait: the same optimum from all of them?

OMP_NUM_THREADS=1 python benchmarks/random_starts.py
"""

import time

import numpy as np

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, Settings, StepParameters
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.program.guess import default_start
from gaitsmith.synthesis.program.transcription import Transcription


def main() -> None:
    planner, settings = Planner(load_robot("thbip_ii"), print), Settings()
    motion = cyclic(planner.biped, StepParameters(0.15, 1.0))
    values = []
    for seed in range(10):
        begin = time.perf_counter()
        trans = Transcription(planner.biped, motion, settings)
        start, moved = default_start(trans), planner.biped.joints * trans.spline.size
        start[:moved] += np.random.default_rng(seed).uniform(-0.2, 0.2, moved)
        found = planner.plan(motion, settings, start=start)
        values.append(found.objective)
        print(f"{seed}: {found.status}, J = {found.objective:.4f}, {found.iterations} iterations, "
              f"{time.perf_counter() - begin:.2f} s")  # fmt: skip
    print(f"spread {(max(values) - min(values)) / min(values):.1e} of the objective")


if __name__ == "__main__":
    main()
