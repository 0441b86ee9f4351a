"""After a push the walk is itself again within three seconds, and the legs keep apart all the while."""

import pytest

from gaitsmith.experiments.push_grid import Cell, PushGrid
from gaitsmith.robots import load_robot
from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.scenario import make_scenario

SOON, APART = 3.0, 0.06  # s, m; undisturbed the soles are 7.4 cm apart


@pytest.mark.parametrize(("direction", "phase"), [(0, 0), (1, 0), (1, 2)])
def test_a_push_of_30_newton_seconds_is_soon_over(direction: int, phase: int) -> None:
    """To the side of the stance leg at the start of a step (the other leg has to pass it), and elsewhere."""
    robot = load_robot("bhr_b2")
    base = make_scenario({"robot": "bhr_b2", "height": 0.66, "period": 0.4, "rest_before": 0.5})
    scenario = PushGrid(30.0, base, directions=4, phases=3, offset=11.25).scenario(Cell(direction, phase))
    simulation = Simulation(scenario.model_copy(update={"duration": 7.5}), robot=robot, record=False)
    while simulation.step():
        pass
    summary = simulation.summary()
    assert not summary.fell
    assert summary.leg_contacts == 0
    assert summary.min_foot_separation > APART
    assert summary.recovered[0] is not None
    assert summary.recovered[0] < SOON
