"""A schedule that contradicts its contacts is refused, and the entry is named."""

from dataclasses import replace

import pytest

from gaitsmith.errors import BadInput
from gaitsmith.planned import ContactPhase, Schedule
from gaitsmith.planned.schedule import BY_CLOCK, BY_CONTACT
from gaitsmith.whole_body.reference import FLAT, HEEL, NONE, TOE

SWING = ContactPhase("swing", 0.35, 1, (NONE, FLAT), BY_CONTACT)
STRIKE = ContactPhase("heel", 0.05, 1, (HEEL, FLAT))
BOTH = ContactPhase("flat", 0.05, 1, (FLAT, FLAT))
OFF = ContactPhase("toe", 0.05, 0, (FLAT, TOE))
OTHER_SWING = ContactPhase("other swing", 0.35, 0, (FLAT, NONE), BY_CONTACT)


def refused(*phases, cyclic=False):
    with pytest.raises(BadInput) as caught:
        Schedule(phases, cyclic)
    return caught.value.field


def test_a_step_and_the_templates_two_phases_are_schedules():
    assert len(Schedule((SWING, STRIKE, BOTH, OFF, replace(OTHER_SWING, end=BY_CLOCK))).phases) == 5
    assert Schedule((SWING, OTHER_SWING), cyclic=True).cyclic


@pytest.mark.parametrize(
    ("phases", "cyclic", "field"),
    [
        ((), False, "phases"),
        ((replace(BOTH, duration=0.0),), False, "phases[0].duration"),
        ((replace(BOTH, duration=float("nan")),), False, "phases[0].duration"),
        ((BOTH, replace(BOTH, contact=(FLAT,), support=0)), False, "phases[1].contact"),
        ((replace(BOTH, contact=(FLAT, 7)),), False, "phases[0].contact"),
        ((replace(BOTH, support=2),), False, "phases[0].support"),
        ((replace(SWING, support=0, end=BY_CLOCK),), False, "phases[0].support"),  # a sole in the air bears nothing
        ((replace(STRIKE, support=0),), False, "phases[0].support"),  # neither does one that turns about its edge
        ((replace(BOTH, end=BY_CONTACT), BOTH), False, "phases[0].end"),  # no sole is in the air
        ((SWING, replace(SWING, end=BY_CLOCK)), False, "phases[0].end"),  # none lands
        ((BOTH, SWING), False, "phases[1].end"),  # nothing follows
        ((replace(SWING, end=BY_CLOCK), OTHER_SWING, BOTH), False, "phases[1].support"),  # it was in the air
        ((STRIKE, replace(BOTH, contact=(TOE, FLAT))), False, "phases[1].contact[0]"),
        ((OFF, replace(SWING, end=BY_CLOCK)), True, "phases[0].support"),  # the first phase follows the last
    ],
)
def test_contradictions_are_refused(phases, cyclic, field):
    assert refused(*phases, cyclic=cyclic) == field


def test_a_flight_needs_no_sole_on_the_ground_and_ends_by_contact():
    flight = replace(BOTH, contact=(NONE, NONE))
    Schedule((BOTH, flight, replace(flight, end=BY_CONTACT), BOTH))
    assert refused(BOTH, flight, BOTH, cyclic=False) == "phases[2].support"  # nothing tells when it is over
