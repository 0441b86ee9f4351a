"""Ten wrong definitions of bounds, five in the planner and five in the verifier: each side tells the other's."""

from dataclasses import replace

import pytest

from gaitsmith.synthesis import verify
from gaitsmith.synthesis.motions.settings import Settings
from gaitsmith.synthesis.program import bounds as planners
from gaitsmith.synthesis.program import transcription
from gaitsmith.synthesis.proof import definitions as verifiers
from gaitsmith.synthesis.proof import measured
from gaitsmith.synthesis.solution.bound_check import Tables, check_bounds
from gaitsmith.synthesis.solution.certificate import certificate

SPARSE = 40  # instants a phase


def certified(planner, gait, x, monkeypatch=None, change=None):
    """The gait with the certificate that the planner makes with its bounds changed."""
    if change is not None:
        true = planners.phase_bounds
        changed = lambda *given: [change(bound) for bound in true(*given)]  # noqa: E731
        monkeypatch.setattr(transcription, "phase_bounds", changed)
    settings = Settings().sized(planner.biped, 0.5)
    trans = transcription.Transcription(planner.biped, gait.motion, settings)
    found = certificate(trans, check_bounds(trans, planner.functions, x, settings.dense, Tables(trans)))
    rates = [row for row in gait.certificate["worst"] if row["constraint"].endswith("torque rate")]
    rows = sorted([*(item.as_dict() for item in found), *rates], key=lambda row: -row["violation"])
    return replace(gait, certificate=gait.certificate | {"worst": rows})


def test_the_planners_certificate_is_accepted(dynamic, planner, robot):
    assert verify(certified(planner, dynamic.gait, dynamic.main.x), robot, SPARSE).ok


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("torque", lambda b: replace(b, low=10.0 * b.low, high=10.0 * b.high) if b.name.endswith(" torque") else b),
        ("friction", lambda b: replace(b, limit=2.0 * b.limit) if b.name.endswith("friction") else b),
        ("ZMP", lambda b: replace(b, out={k: 1.1 * v for k, v in b.out.items()}) if "ZMP" in b.name else b),
        ("torso pitch", lambda b: replace(b, sine=False) if b.name == "torso pitch" else b),
        ("normal force", lambda b: replace(b, low=0.0) if b.name.endswith("force alone") else b),
    ],
)
def test_a_wrong_bound_of_the_planner_is_caught(dynamic, planner, robot, monkeypatch, name, change):
    gait = certified(planner, dynamic.gait, dynamic.main.x, monkeypatch, change)
    problems = verify(gait, robot, SPARSE).problems
    assert any(name in text for text in problems), problems


@pytest.mark.parametrize(
    ("name", "place", "value"),
    [
        ("friction", "_FACES", 4),
        ("squat", "_CROUCH", 2.0),
        ("yaw moment", "_ENDS", 0.4),
        ("foot pitch", "_LEVEL", -0.1),
        ("ZMP", "sole_edges", lambda *given: [(n, x, y, 0.9 * d) for n, x, y, d in verifiers_edges(*given)]),
    ],
)
def test_a_wrong_bound_of_the_verifier_is_caught(dynamic, robot, monkeypatch, name, place, value):
    monkeypatch.setattr(verifiers, place, value)
    problems = verify(dynamic.gait, robot, SPARSE).problems
    assert any(name in text for text in problems), problems


verifiers_edges = verifiers.sole_edges


def test_a_wrong_profile_of_the_swing_is_caught(dynamic, robot, monkeypatch):
    """Where the foot may be lower than it says, the worst clearance is not where the certificate says."""
    monkeypatch.setattr(measured, "rise", lambda s, lifts, lands: 3.0 + 0.0 * s)
    assert any("swing clearance" in text for text in verify(dynamic.gait, robot, SPARSE).problems)
