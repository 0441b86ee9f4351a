"""Bounds of a phase state contact mechanics: forces in the friction cone, on the sole, and large enough."""

import numpy as np
import pytest

from gaitsmith.synthesis import StepParameters
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.motions.motion import opposite
from gaitsmith.synthesis.motions.settings import Bounds
from gaitsmith.synthesis.point.layout import PointLayout
from gaitsmith.synthesis.program.bounds import phase_bounds

SINGLE, DOUBLE = 0, 3  # phases of a step: the swing foot rises; both soles are flat
FACETS = 0.9  # of the cone's edge that the pyramid inside it must leave


@pytest.fixture(scope="module")
def motion(planner):
    return cyclic(planner.biped, StepParameters(0.15, 1.0))


def violated(planner, motion, phase, wrench, bounds, foot="support"):
    """Names of the contact bounds that a wrench (6,) on one foot's sole violates; N and N·m, about its origin."""
    biped, layout = planner.biped, PointLayout(planner.biped.joints)
    o, z = np.zeros(layout.outputs), np.zeros(layout.inputs)
    other = int(foot == "other")
    (z[layout.wrench :] if other else o[layout.force : layout.force + 6])[:] = wrench
    o[layout.twist + other] = wrench[3:] @ wrench[:3] / biped.weight
    o[layout.load + other] = wrench[2] ** 2 / biped.weight
    support = motion.phases[phase].support
    side = support if foot == "support" else opposite(support)
    found = set()
    for bound in phase_bounds(biped, bounds, motion, phase):
        value = sum(f * o[k] for k, f in bound.out.items()) + sum(f * z[k] for k, f in bound.inp.items())
        if bound.name.startswith(f"{side} foot") and not bound.low <= value <= bound.high:
            found.add(bound.name.removeprefix(f"{side} foot "))
    return found


def force_at(x, y, force):
    """Wrench about the sole's origin of a force (3,) at a point of the sole."""
    return np.concatenate([force, np.cross([x, y, 0.0], force)])


@pytest.mark.parametrize(("phase", "foot"), [(SINGLE, "support"), (DOUBLE, "support"), (DOUBLE, "other")])
def test_the_friction_pyramid_lies_inside_the_cone_and_nearly_fills_it(planner, motion, phase, foot):
    bounds, weight = Bounds(friction=0.4), planner.biped.weight
    for angle in np.linspace(0.0, 2.0 * np.pi, 49):
        along = np.array([np.cos(angle), np.sin(angle), 0.0])
        for share, allowed in ((1.001, False), (FACETS, True)):
            wrench = force_at(0.0, 0.0, weight * (share * 0.4 * along + [0.0, 0.0, 1.0]))
            assert ("friction" not in violated(planner, motion, phase, wrench, bounds, foot)) is allowed


def test_the_support_foot_bears_its_least_share_of_the_weight(planner, motion):
    bounds, weight = Bounds(normal_force=0.3), planner.biped.weight
    for phase, share, allowed in ((SINGLE, 0.31, True), (SINGLE, 0.29, False), (DOUBLE, 0.01, True)):
        wrench = force_at(0.0, 0.0, np.array([0.0, 0.0, share * weight]))
        names = violated(planner, motion, phase, wrench, bounds)
        assert not names & {"normal force", "normal force alone"} if allowed else "normal force alone" in names
    for foot in ("support", "other"):  # a sole never pulls
        pull = force_at(0.0, 0.0, np.array([0.0, 0.0, -0.01 * weight]))
        assert "normal force" in violated(planner, motion, DOUBLE, pull, bounds, foot)


def test_a_vertical_force_must_act_on_the_sole_less_the_margin(planner, motion):
    bounds, sole = Bounds(zmp_margin=0.01), planner.biped.leg("left").sole
    load = np.array([0.0, 0.0, planner.biped.weight])
    edges = {
        "ZMP forward": (sole.toe, 0.0),
        "ZMP backward": (-sole.heel, 0.0),
        "ZMP inward": (0.0, sole.half_width),
        "ZMP outward": (0.0, -sole.half_width),
    }
    for name, (x, y) in edges.items():
        out = np.array([np.sign(x), np.sign(y)])
        for depth, wanted in ((0.011, set()), (0.009, {name})):
            place = np.array([x, y]) - depth * out
            assert violated(planner, motion, SINGLE, force_at(*place, load), bounds) == wanted


def test_the_yaw_moment_is_bounded_about_the_centre_of_pressure(planner, motion):
    bounds, weight = Bounds(yaw_friction=0.02), planner.biped.weight
    for twist, allowed in ((0.019, True), (0.021, False), (-0.021, False)):
        wrench = force_at(0.05, 0.01, np.array([10.0, 5.0, weight]))
        wrench[5] += twist * weight
        assert ("yaw moment" not in violated(planner, motion, SINGLE, wrench, bounds)) is allowed
