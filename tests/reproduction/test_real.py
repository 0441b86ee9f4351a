"""What is said of a real ZMP, on made-up runs of which it is known."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from gaitsmith.reproduction.real import Real
from gaitsmith.reproduction.synthesis import _fluctuation, _inside
from gaitsmith.synthesis.motions.motion import Phase

STEP = 0.005
SINGLE = Phase("swing", 0.7, "right", "air", (0.0, -0.07))
DOUBLE = Phase("flat", 0.3, "right", "flat", (0.0, -0.07), (0.1, 0.07))


def made_up(outside: float, shake: float) -> Real:
    """Three seconds of single and double support: outside for a time before each change, shaking after it, m."""
    time = np.arange(0.0, 3.0, STEP)
    phases = [SINGLE if t % 1.0 < 0.7 else DOUBLE for t in time]
    depth = np.where((time % 1.0 > 0.7 - outside) & (time % 1.0 < 0.7), -0.05, 0.02)
    lateral = 0.05 * np.sin(2.0 * np.pi * time)
    near = np.abs(time % 1.0 - 0.7) < 0.05
    zmp = np.column_stack([0.1 * time, lateral + shake * near * np.sin(2.0 * np.pi * 20.0 * time)])
    plan = cast(Any, SimpleNamespace(phases=phases))
    return Real(cast(Any, None), time, zmp, zmp, plan, depth, depth)


@pytest.mark.parametrize(("outside", "share"), [(0.0, 1.0), (0.02, 1.0), (0.3, 0.71)])
def test_only_instants_away_from_a_change_of_contacts_count(outside: float, share: float) -> None:
    assert _inside(made_up(outside, 0.0)) == pytest.approx(share, abs=0.04)


def test_a_zmp_that_shakes_at_the_transition_fluctuates_there_and_a_smooth_one_does_not() -> None:
    assert _fluctuation(made_up(0.0, 0.02)) > 2.0
    assert _fluctuation(made_up(0.0, 0.0)) < 1.0
