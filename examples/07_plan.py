"""Plan a cyclic gait for THBIP-II, let MuJoCo check its certificate, and replay it.

python examples/07_plan.py
"""

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, Request, StepParameters, answer, verify
from gaitsmith.synthesis.proof.replay import ReplayResult, replay


def main(steps: int = 20) -> ReplayResult:
    robot = load_robot("thbip_ii")
    planner = Planner(robot, print)
    found = answer(planner, Request("cyclic", StepParameters(length=0.20, period=0.5)))
    if found.gait is None:
        raise SystemExit(found.main.reason)
    print(f"planned in {found.main.iterations} iterations, objective {found.main.objective:.1f}")
    verdict = verify(found.gait, robot)
    print(f"MuJoCo agrees: {verdict.ok}, residual {verdict.dynamics_residual:.1e} of the weight")
    result = replay(found.gait, robot, steps=steps)
    print(f"stood: {result.stood}, {result.distance:.3f} of {result.planned_distance:.3f} m")
    return result


if __name__ == "__main__":
    main()
