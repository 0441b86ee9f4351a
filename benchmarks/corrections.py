"""What the deviations from the paper change, one at a time, on the dynamic cyclic gait (0.40 m/s).

OMP_NUM_THREADS=1 python benchmarks/corrections.py
"""

from unittest.mock import patch

import numpy as np

from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Bounds, Motion, Planner, Settings, StepParameters, verify
from gaitsmith.synthesis.motions.biped import Biped
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.program import transcription
from gaitsmith.synthesis.program.bounds import PhaseBound
from gaitsmith.synthesis.program.transcription import Transcription
from gaitsmith.synthesis.solution.plan import PlanResult

NINE = 1e-4  # rad


def raw_closure(planner: Planner, found: PlanResult, settings: Settings) -> tuple[float, float, float]:
    """Closure errors (mm, m/s, m/s²) of the splines as solved, closed at the knots only."""
    motion = cyclic(planner.biped, StepParameters(0.20, 0.5))
    trans = Transcription(planner.biped, motion, settings)
    ends = zip(trans.borders, trans.borders[1:], strict=False)
    times = np.concatenate([np.linspace(start, end, 400) for start, end in ends])
    points = trans.instants(np.repeat(np.arange(len(motion.phases)), 400), times)
    z = (trans.input_map(points) @ found.x).reshape(points.count, trans.layout.inputs).T
    o = planner.functions.evaluate(z, trans.pivots[points.phase].T)
    layout, worst = PointLayout(planner.biped.joints), [0.0, 0.0, 0.0]
    for index, phase in enumerate(motion.phases):
        if phase.other is None:
            continue
        mask = points.phase == index
        goal = np.array(
            [
                phase.other[0] - phase.foothold[0] + trans.pivots[index][0],
                phase.side * (phase.other[1] - phase.foothold[1]),
                0.0,
            ]
        )
        gaps = (
            1e3 * (o[layout.pivot : layout.pivot + 3][:, mask] - goal[:, None]),
            o[layout.pivot_velocity : layout.pivot_velocity + 3][:, mask],
            o[layout.pivot_acceleration : layout.pivot_acceleration + 3][:, mask],
        )
        worst = [max(a, float(np.abs(b).max())) for a, b in zip(worst, gaps, strict=True)]
    return worst[0], worst[1], worst[2]


def literal_nine(planner: Planner, speed: float) -> str:
    """Eq. (9) as printed, both legs' hip and ankle rolls equal in single support, in place of a level swing foot."""
    names = list(planner.biped.robot.joint_names)
    hips = [names.index(f"{side}_hip_roll") for side in ("right", "left")]
    ankles = [names.index(f"{side}_ankle_roll") for side in ("right", "left")]
    pairs = [(hips[0], ankles[0], 1.0), (hips[1], ankles[1], 1.0), (hips[0], hips[1], -1.0)]
    inner = transcription.phase_bounds

    def with_nine(biped: Biped, bounds: Bounds, motion: Motion, index: int) -> list[PhaseBound]:
        found = inner(biped, bounds, motion, index)
        if not motion.phases[index].double:
            found += [PhaseBound("eq. 9", "rad", {}, {a: 1.0, b: sign}, -NINE, NINE, 1.0) for a, b, sign in pairs]
        return found

    step = StepParameters(0.15, 1.0) if speed == 0.15 else StepParameters(0.20, 0.5)
    settings = Settings(bounds=Bounds(foot_tilt=1.5))
    with patch.object(transcription, "phase_bounds", with_nine):
        found = planner.plan(cyclic(planner.biped, step), settings)
    if found.gait is None:
        return f"{found.status}: {found.reason}"
    worst = verify(found.gait, planner.biped.robot).worst
    tilt = {key: abs(worst[f"swing foot {key}"].value) for key in ("roll", "yaw")}
    return f"J {found.objective:.1f}, swing foot roll {tilt['roll']:.3f}, yaw {tilt['yaw']:.3f} rad"


def main() -> None:
    robot = load_robot("thbip_ii")
    planner = Planner(robot, print)
    motion = cyclic(planner.biped, StepParameters(0.20, 0.5))
    variants = {
        "default": Settings(),
        "quartic, as (17)": Settings(order=4),
        "weight of u 1, as (16)": Settings(wrench_weight=1.0),
        "no bound on the torso's tilt and yaw": Settings(bounds=Bounds(torso_pitch=1.5, torso_roll=1.5, torso_yaw=1.5)),
        "no bound on the swing foot's roll and yaw": Settings(bounds=Bounds(foot_tilt=1.5)),
        "no clearance profile": Settings(bounds=Bounds(clearance=0.0)),
        "no points added": Settings(refinements=0),
    }
    print(f"{'variant':<44}{'status':<16}{'J':>8}{'jump N·m':>10}{'mm':>9}{'m/s':>9}{'m/s²':>9}{'fz min':>8}")
    for name, settings in variants.items():
        found = planner.plan(motion, settings)
        if found.gait is None:
            print(f"{name:<44}{found.status:<16}{found.objective:8.1f}  {found.reason}")
            continue
        verdict = verify(found.gait, robot)
        closure = verdict.closure
        force = min(item.value for key, item in verdict.worst.items() if key.endswith("normal force"))
        print(
            f"{name:<44}{found.status:<16}{found.objective:8.1f}{verdict.torque_jump:10.1e}"
            f"{closure['position_mm']:9.1e}{closure['velocity']:9.1e}{closure['acceleration']:9.1e}{force:8.3f}"
        )
        for key in ("torso pitch", "torso roll", "torso yaw", "swing foot roll", "swing foot yaw"):
            if name.startswith("no bound") and key.split()[0] in name:
                print(f"    {key}: up to {abs(verdict.worst[key].value):.3f}")
        if name == "default":
            raw = raw_closure(planner, found, settings)
            print(f"    closed at the knots only: {raw[0]:.3f} mm, {raw[1]:.4f} m/s, {raw[2]:.3f} m/s²")
    for speed in (0.15, 0.40):
        print(f"(9) as printed, {speed:.2f} m/s: {literal_nine(planner, speed)}")


if __name__ == "__main__":
    main()
