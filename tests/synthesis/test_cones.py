"""The wrench of the foot that loads or unloads lies in its cones at all times, the ends included."""

import numpy as np

from gaitsmith.splines.polynomial import bernstein
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.program.cones import is_cone
from gaitsmith.synthesis.program.transcription import WRENCH_DEGREE, Transcription


def test_coefficients_in_a_cone_keep_the_curve_in_it(planner, static):
    trans = Transcription(
        planner.biped, cyclic(planner.biped, StepParameters(0.15, 1.0)), Settings().sized(planner.biped)
    )
    x = static.main.x
    for index, phase in enumerate(trans.motion.phases):
        if not phase.double:
            continue
        u = planner.biped.weight * x[trans.wrench_columns(index)]
        cones = [bound for bound in trans.bounds[index] if is_cone(trans, bound)]
        assert len(cones) > 8
        for s in (1e-6, 1e-3, 0.03, 0.3, 0.5, 0.8, 0.97, 0.999, 1.0 - 1e-6):
            wrench = u @ bernstein(WRENCH_DEGREE, s)
            load = wrench[2] / planner.biped.weight
            for bound in cones:
                value = sum(factor * wrench[k - trans.layout.wrench] for k, factor in bound.inp.items())
                assert bound.low - 1e-6 * load <= value <= bound.high + 1e-6 * load, (phase.name, bound.name, s)


def test_the_direction_at_lift_off_keeps_the_yaw_moment(planner, static):
    trans = Transcription(
        planner.biped, cyclic(planner.biped, StepParameters(0.15, 1.0)), Settings().sized(planner.biped)
    )
    points = trans.points()
    ends = np.flatnonzero(points.control >= 0)
    assert len(ends) == 2  # heel strike and toe-off
    z = (trans.input_map(points) @ static.main.x).reshape(points.count, -1)[ends]
    for row, phase in zip(z, points.phase[ends], strict=True):
        force, moment = row[trans.layout.wrench :][:3], row[trans.layout.wrench :][3:]
        limits = [b.limit for b in trans.bounds[int(phase)] if b.name.endswith("yaw moment") and b.load == 1]
        assert abs(moment @ force) <= max(limits) * force[2] ** 2
