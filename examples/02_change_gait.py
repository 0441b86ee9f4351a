"""Change every parameter of the gait while walking; each change holds from the next switch of the legs.

python examples/02_change_gait.py
"""

import gaitsmith
from gaitsmith.simulation.scenario import Change


def main(duration: float = 16.0) -> gaitsmith.Episode:
    changes = (
        Change(time=0.30 * duration, speed=(0.4, 0.0)),
        Change(time=0.45 * duration, height=0.60),
        Change(time=0.60 * duration, period=0.30, lift=0.06),
        Change(time=0.75 * duration, speed=(0.0, 0.1)),
        Change(time=0.90 * duration, speed=(0.0, 0.0), height=0.70),
    )
    episode = gaitsmith.run_episode(gaitsmith.Scenario(speed=(0.2, 0.0), duration=duration, changes=changes))
    for stage in episode.summary.stages:
        command = stage.command
        asked = f"T {command.period:.2f} s, H {command.height:.2f} m, v {command.vx:+.2f} {command.vy:+.2f} m/s"
        print(f"{asked} -> v {stage.vx_mean:+.3f} {stage.vy_mean:+.3f} m/s, H {stage.height_mean:.3f} m")
    return episode


if __name__ == "__main__":
    main()
