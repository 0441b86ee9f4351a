"""Where to land on known ground: on treads, not on their edges; on listed footholds; told to the walk in its frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput
from gaitsmith.robots.sole import Sole
from gaitsmith.simulation.episode import Simulation
from gaitsmith.simulation.footholds import HeightMap, MappedGround, read_footholds
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.terrain import Terrain, parse_terrain

SOLE = Sole(kind="line", heel=0.07, toe=0.12)
STAIRS = parse_terrain("stairs:0.1,0.3,1.5,5")


def land(source, wanted, sole=SOLE):
    return source.landing(sole, np.array([wanted - 0.15, 0.1, 0.0]), np.array([wanted, 0.1]), 0.0)


@pytest.mark.parametrize("rise", [0.1, -0.1])
@given(wanted=st.floats(1.0, 3.4))
def test_all_of_a_sole_has_even_ground(rise: float, wanted: float) -> None:
    """Of a tread that is longer than the sole; the sole still reaches where the walk wanted to bear, or nearly so."""
    stairs = parse_terrain(f"stairs:{rise},0.3,1.5,5")
    found = land(MappedGround(stairs), wanted)
    below = stairs.heights(found.place[0] + np.array([-SOLE.heel, 0.0, SOLE.toe]), np.zeros(3))
    np.testing.assert_allclose(below, found.height)
    moved = found.place[0] - wanted
    assert -SOLE.toe - 0.08 < moved < SOLE.heel + 0.08
    assert found.highest >= max(found.height, stairs.heights(np.array([wanted - 0.15]), np.zeros(1))[0])


def test_a_step_once_chosen_is_kept() -> None:
    """A foothold that moves on by a little does not jump to the next tread in the middle of the swing."""
    ground, kept = MappedGround(STAIRS), None
    places = []
    for wanted in np.linspace(1.35, 1.5, 30):
        kept = ground.landing(SOLE, np.array([1.2, 0.1, 0.0]), np.array([wanted, 0.1]), 0.0, kept).place
        places.append(kept[0])
    assert max(places) < 1.5
    assert land(ground, 1.5).place[0] > 1.5


def test_a_foot_that_comes_from_afar_stays_before_the_edge() -> None:
    """What the walk wants is nearer to the next tread, but the swing is not to be longer than two soles."""
    ground, wanted = MappedGround(STAIRS), np.array([1.49, 0.1])
    near, far = (ground.landing(SOLE, np.array([1.49 - way, 0.1, 0.0]), wanted, 0.0).place[0] for way in (0.15, 0.36))
    assert near > 1.5 > far


@given(st.floats(1.2, 3.0), st.floats(-15.0, 15.0))
def test_even_ground_moves_no_foothold(wanted: float, degrees: float) -> None:
    found = land(MappedGround(Terrain("slope", degrees)), wanted)
    assert found.place[0] == wanted
    assert found.height == pytest.approx(Terrain("slope", degrees).height(wanted, 0.1))


@pytest.mark.parametrize("name", ["stairs:-0.08,0.3,1.5,5", "boxes:0.06"])
def test_a_map_says_what_its_terrain_says(name: str) -> None:
    terrain = parse_terrain(name)
    x, y = np.meshgrid(np.arange(0.0, 3.0, 0.01), np.arange(-0.5, 0.5, 0.01), indexing="ij")
    mapped = HeightMap((0.0, -0.5), 0.01, terrain.heights(x.ravel(), y.ravel()).reshape(x.shape))
    for wanted in (1.013, 1.42, 2.2):
        a, b = land(MappedGround(terrain), wanted), land(MappedGround(mapped), wanted)
        assert abs(a.height - b.height) < 1e-9
    assert land(MappedGround(mapped), 5.0) is None


def test_listed_footholds(tmp_path: Path) -> None:
    """The nearest one, to the letter; none if all are far; a wrong line is named."""
    path = tmp_path / "stones.csv"
    path.write_text("# x, y, z\n1.0, 0.1, 0.05\n1.3, 0.1, 0.10  # the second\n")
    found = land(read_footholds(path, 0.7), 1.1)
    assert (*found.place, found.height) == (1.0, 0.1, 0.05)
    assert land(read_footholds(path, 0.7), 2.0) is None
    scenario = make_scenario({"duration": 2.0, "footholds": str(path)})
    assert any("no ground known" in warning for warning in Simulation(scenario, record=False).run().summary.warnings)
    for wrong in ("1.0, 2.0\n", "a, b, c\n", "1, 2, nan\n", "# nothing\n"):
        path.write_text(wrong)
        with pytest.raises(BadInput, match="foothold"):
            read_footholds(path, 0.7)


def test_a_controller_is_told_finite_numbers() -> None:
    scenario = make_scenario({"duration": 1.5, "footholds": "terrain", "terrain": "stairs:0.1,0.3,0.8,2"})
    simulation = Simulation(scenario, record=False)
    with pytest.raises(BadInput, match="ground"):
        simulation.controller.see((np.nan, 0.0), 0.0, 0.0)


def test_known_stairs_are_climbed() -> None:
    """Two steps of 10 cm: the robot stands on the upper level, where without the map it falls or stays behind."""
    scenario = make_scenario(
        {"terrain": "stairs:0.1,0.3,0.8,2", "footholds": "terrain", "speed": [0.3, 0.0], "duration": 8.0}
    )
    simulation = Simulation(scenario, record=False)
    simulation.run()
    assert simulation.fall is None
    assert simulation.plant.truth.sole[2] > 0.15
