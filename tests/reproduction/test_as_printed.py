"""The preset that takes the paper as printed walks; what it omits, it cannot walk with."""

import pytest

from gaitsmith.reproduction.as_printed import AT_ONCE, OMITTED, ROLL, STANCE, Deviation, follows, how, walk_with
from gaitsmith.simulation.scenario import Scenario


def walk(duration: float, speed: float = 0.4) -> Scenario:
    return Scenario(speed=(speed, 0.0), duration=duration, rest_before=0.0)


def test_as_printed_it_walks_upright_and_about_as_fast_as_told() -> None:
    found = walk_with(Deviation("paper preset"), walk(5.0))
    assert follows(found)
    assert how(found) == "walks"
    assert max(abs(angle) for stage in found.stages for angle in (*stage.roll_deg, *stage.pitch_deg)) < 1.0


@pytest.mark.parametrize("deviation", [STANCE, ROLL, AT_ONCE], ids=lambda deviation: deviation.name)
def test_what_it_does_not_take_falls(deviation: Deviation) -> None:
    assert deviation in OMITTED
    found = walk_with(deviation, walk(6.0))
    assert not follows(found)
    assert how(found).startswith("falls after")
