"""Plan a motion of one's own, written in TOML: over an obstacle 5 cm high, one foot after the other.

python examples/08_own_motion.py
"""

from pathlib import Path
from tempfile import TemporaryDirectory

from gaitsmith import Scenario, run_episode
from gaitsmith.robots import load_robot
from gaitsmith.simulation import Summary
from gaitsmith.synthesis import Planner, answer_file, verify
from gaitsmith.synthesis.files.gait_file import write_gait

MOTION = Path(__file__).parent / "motions" / "obstacle.toml"


def main() -> Summary:
    robot = load_robot("thbip_ii")
    found = answer_file(Planner(robot, print), MOTION)
    if found.gait is None:
        raise SystemExit(found.main.reason)
    verdict = verify(found.gait, robot, 100)
    print(f"planned in {found.main.iterations} iterations; MuJoCo agrees: {verdict.ok}")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "obstacle.json"
        write_gait(path, found.gait)
        scenario = Scenario(robot="thbip_ii", gait=(str(path),), duration=found.gait.duration + 2.0)
        summary = run_episode(scenario, robot=robot, record=False).summary
    if summary.tracking is not None:
        print(f"fell: {summary.fell}, {summary.tracking.distance:.3f} of {summary.tracking.planned_distance:.3f} m")
    return summary


if __name__ == "__main__":
    main()
