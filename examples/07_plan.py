"""Plan a cyclic gait for THBIP-II, let MuJoCo check its certificate, and walk it.

python examples/07_plan.py
"""

from pathlib import Path
from tempfile import TemporaryDirectory

from gaitsmith import Scenario, run_episode
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Summary
from gaitsmith.synthesis import Planner, Request, StepParameters, answer, verify
from gaitsmith.synthesis.files.gait_file import write_gait


def main(steps: int = 20) -> Summary:
    robot = load_robot("thbip_ii")
    planner = Planner(robot, print)
    found = answer(planner, Request("cyclic", StepParameters(length=0.20, period=0.5)))
    if found.gait is None:
        raise SystemExit(found.main.reason)
    print(f"planned in {found.main.iterations} iterations, objective {found.main.objective:.1f}")
    verdict = verify(found.gait, robot)
    print(f"MuJoCo agrees: {verdict.ok}, residual {verdict.dynamics_residual:.1e} of the weight")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "walk.json"
        write_gait(path, found.gait)
        scenario = Scenario(robot="thbip_ii", gait=(str(path),), cycles=steps, duration=steps * found.gait.duration)
        summary = run_episode(scenario, robot=robot, record=False).summary
    if summary.tracking is not None:
        print(f"fell: {summary.fell}, {summary.tracking.distance:.3f} of {summary.tracking.planned_distance:.3f} m")
    return summary


if __name__ == "__main__":
    main()
