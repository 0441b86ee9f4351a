"""Walk, and read what came out: stages, drift, torques.

python examples/01_walk.py
"""

import gaitsmith


def main(duration: float = 10.0) -> gaitsmith.Episode:
    episode = gaitsmith.run_episode(gaitsmith.Scenario(speed=(0.3, 0.0), duration=duration))
    summary = episode.summary
    for stage in summary.stages:
        what = "standing" if stage.rest else f"commanded {stage.command.vx:.2f} m/s"
        print(
            f"{stage.t0:5.1f} to {stage.t1:5.1f} s, {what}: {stage.vx_mean:.3f} m/s, height {stage.height_mean:.3f} m"
        )
    for joint, peak in summary.torque_peak.items():
        print(f"{joint:16s} peak {peak:6.1f} N·m")
    assert episode.log is not None
    print(f"{len(episode.log.rows)} rows, torso at x = {episode.log.column('true.torso_x')[-1]:.2f} m")
    return episode


if __name__ == "__main__":
    main()
