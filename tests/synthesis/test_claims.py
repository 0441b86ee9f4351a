"""The paper's claims about its two gaits: those that our gaits bear out, and that gaits exchanged do not."""

from gaitsmith.synthesis.proof.claims import paper_claims

LEAN = "lateral motion matters more in static walking"
STAYS = "static walking: the CoG stays inside"
LEAVES = "dynamic walking: the CoG leaves the stable region, the ZMP stays inside"
LONGER = "dynamic walking has a bigger step size"
SHARP = "dynamic walking: the swing foot sharply moves back"
INERTIA = "dynamic walking: inertia and Coriolis forces are overcome"
FLUCTUATES = "the ZMP fluctuates from single to double support"


def test_claims_that_hold_for_our_gaits(static, dynamic, robot):
    found = {item.claim: item for item in paper_claims(static.gait, dynamic.gait, robot)}
    smooth = [f"{kind} walking: torques are continuous and smooth" for kind in ("static", "dynamic")]
    yaw = [f"{kind} walking: the hip yaw torque is not zero" for kind in ("static", "dynamic")]
    for claim in (LEAN, STAYS, LEAVES, LONGER, SHARP, INERTIA, FLUCTUATES, *smooth, *yaw):
        assert found[claim].holds, found[claim].found


def test_gaits_exchanged_bear_out_none_of_what_tells_them_apart(static, dynamic, robot):
    found = {item.claim: item for item in paper_claims(dynamic.gait, static.gait, robot)}
    for claim in (LEAN, STAYS, LEAVES, LONGER, SHARP, INERTIA):
        assert not found[claim].holds, found[claim].found
