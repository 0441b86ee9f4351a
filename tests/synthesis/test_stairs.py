"""Walks on stairs: footholds in the middle of treads, swings past the edges, one cycle the mirror image of the next."""

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.gaits.gait import follow
from gaitsmith.synthesis.motions.contacts import check_contacts
from gaitsmith.synthesis.motions.parameters import StepParameters
from gaitsmith.synthesis.motions.stairs import check_stairs, stairs_cycle, stairs_start, stairs_stop
from gaitsmith.synthesis.proof.verify import verify

STEP = StepParameters(0.2, 1.2, height=0.03, rise=0.05)


def _motions(biped, step):
    rest = np.zeros(biped.joints)
    state = rest, rest, rest
    return stairs_cycle(biped, step), stairs_start(biped, step, rest, state), stairs_stop(biped, step, rest, state)


@pytest.mark.parametrize("rise", [0.05, -0.05])
def test_feet_stand_on_treads_and_move_only_in_the_air(planner, rise):
    for motion in _motions(planner.biped, StepParameters(0.2, 1.2, height=0.03, rise=rise)):
        check_contacts(motion.phases, motion.cyclic, ("foothold", "other_foothold"))
        for phase in motion.phases:
            assert phase.height == pytest.approx(rise * phase.foothold[0] / 0.2)
            if phase.other is not None:
                assert phase.other_height == pytest.approx(rise * phase.other[0] / 0.2)


@pytest.mark.parametrize("rise", [0.05, -0.05])
def test_no_phase_lets_the_sole_pass_an_edge_below_the_tread(planner, rise):
    biped, step = planner.biped, StepParameters(0.2, 1.2, height=0.03, rise=rise)
    sole = biped.sole("left")
    for phase in stairs_cycle(biped, step).phases:
        limits = {limit.quantity: limit for limit in phase.limits}
        for edge, above in ((-0.2, -rise), (0.0, 0.0)):  # of the tread behind and of the support's
            ahead = edge + 0.5 * (0.2 + sole.toe - sole.heel)
            level = max(above, above + rise)
            if not phase.double and phase.other_height < level - 1e-9:  # the sole may be below: it keeps to its side
                kept = limits["toe_x"].high < ahead if rise > 0.0 else limits["heel_x"].low > ahead
                assert kept, phase.name


def test_treads_shorter_than_a_sole_are_refused(planner):
    with pytest.raises(BadInput, match="--tread"):
        check_stairs(planner.biped, StepParameters(0.15, 1.2, rise=0.05))


def test_a_step_up_is_planned_confirmed_and_followed_by_its_image(planner, robot):
    found = planner.plan(stairs_cycle(planner.biped, STEP))
    assert found.gait is not None, found.reason
    verdict = verify(found.gait, robot)
    assert verdict.ok, verdict.problems
    whole = planner.biped.whole
    after = follow(found.gait, found.gait, True, whole.partner, whole.sign)
    assert after.motion.phases[0].height == pytest.approx(0.05)
    assert [limit.high for limit in after.motion.phases[0].limits] == pytest.approx(
        [limit.high + 0.2 for limit in found.gait.motion.phases[0].limits]
    )
