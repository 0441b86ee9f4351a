"""Ten random starts of the static gait: the same optimum from all of them?

OMP_NUM_THREADS=1 python benchmarks/random_starts.py
"""

import time

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, Settings, StepParameters
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.program.guess import random_start
from gaitsmith.synthesis.program.transcription import Transcription


def main() -> None:
    planner, settings = Planner(load_robot("thbip_ii"), print), Settings()
    motion = cyclic(planner.biped, StepParameters(0.15, 1.0))
    values = []
    for seed in range(10):
        begin = time.perf_counter()
        start = random_start(Transcription(planner.biped, motion, settings), seed, 0.2)
        found = planner.plan(motion, settings, start=start)
        values.append(found.objective)
        print(f"{seed}: {found.status}, J = {found.objective:.4f}, {found.iterations} iterations, "
              f"{time.perf_counter() - begin:.2f} s")  # fmt: skip
    print(f"spread {(max(values) - min(values)) / min(values):.1e} of the objective")


if __name__ == "__main__":
    main()
