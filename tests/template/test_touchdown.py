"""A step ends on contact, not before its earliest time, and by the clock at its latest."""

from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.robots.presets import TouchdownParameters
from gaitsmith.template.touchdown import CONTACT, FORCED, NONE, TouchdownRule, detect_touchdown, make_touchdown_rule

PARAMETERS = TouchdownParameters(force=30.0, earliest=0.5, latest=1.6, descent_speed=0.25)
RULE = make_touchdown_rule(PARAMETERS)

periods = st.floats(0.2, 1.0)
forces = st.floats(0.0, 2000.0)


def test_rule_holds_the_parameters() -> None:
    assert TouchdownRule(30.0, 0.5, 1.6, 0.25) == RULE


@given(periods, st.floats(0.0, 0.499), forces)
def test_early_contact_is_ignored(period: float, share: float, force: float) -> None:
    """The sole has just left the ground: its force says nothing yet."""
    assert detect_touchdown(RULE, share * period, period, force) == NONE


@given(periods, st.floats(0.501, 3.0), st.floats(30.1, 2000.0))
def test_contact_ends_the_step(period: float, share: float, force: float) -> None:
    assert detect_touchdown(RULE, share * period, period, force) == CONTACT


@given(periods, st.floats(0.501, 1.599), st.floats(0.0, 30.0))
def test_without_contact_the_step_goes_on(period: float, share: float, force: float) -> None:
    assert detect_touchdown(RULE, share * period, period, force) == NONE


@given(periods, st.floats(1.601, 10.0), st.floats(0.0, 30.0))
def test_the_clock_ends_a_step_that_finds_no_ground(period: float, share: float, force: float) -> None:
    assert detect_touchdown(RULE, share * period, period, force) == FORCED


@given(periods, forces)
def test_the_answer_never_goes_back_to_none(period: float, force: float) -> None:
    """Once a step may end at a force, it may end at any later time."""
    answers = [detect_touchdown(RULE, 0.01 * k * period, period, force) for k in range(250)]
    ended = [answer != NONE for answer in answers]
    assert ended == sorted(ended)
    assert ended[-1]
