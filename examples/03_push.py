"""Push the walking robot until it falls, and be told why it fell.

The push of 0.1 s begins in the middle of a left stance: phase 0 is the beginning of a left stance, 0.5 of a right one.

python examples/03_push.py
"""

import gaitsmith
from gaitsmith.simulation import Push


def main(impulses: tuple[float, ...] = (10.0, 20.0, 30.0, 60.0)) -> list[gaitsmith.Episode]:
    episodes = []
    for impulse in impulses:
        push = Push(time=3.0, phase=0.25, impulse=(0.0, impulse, 0.0))
        scenario = gaitsmith.Scenario(duration=7.0, height=0.66, pushes=(push,))
        episodes.append(gaitsmith.run_episode(scenario, record=False))
        summary = episodes[-1].summary
        if summary.fall is None:
            print(
                f"{impulse:5.1f} N·s to the left: walks on, soles never closer than {summary.min_foot_separation:.3f} m"
            )
        else:
            print(f"{impulse:5.1f} N·s to the left: fell at {summary.fall.time:.2f} s, {summary.fall.phase}")
            print(f"      {summary.fall.reason}")
    return episodes


if __name__ == "__main__":
    main()
