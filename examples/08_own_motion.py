"""Plan a motion of one's own, written in TOML: over an obstacle 5 cm high, one foot after the other.

python examples/08_own_motion.py
"""

from pathlib import Path

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, answer_file, verify
from gaitsmith.synthesis.proof.replay import ReplayResult, replay

MOTION = Path(__file__).parent / "motions" / "obstacle.toml"


def main() -> ReplayResult:
    robot = load_robot("thbip_ii")
    found = answer_file(Planner(robot, print), MOTION)
    if found.gait is None:
        raise SystemExit(found.main.reason)
    verdict = verify(found.gait, robot, 100)
    print(f"planned in {found.main.iterations} iterations; MuJoCo agrees: {verdict.ok}")
    result = replay(found.gait, robot)
    print(f"stood: {result.stood}, {result.distance:.3f} of {result.planned_distance:.3f} m")
    return result


if __name__ == "__main__":
    main()
