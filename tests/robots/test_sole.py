from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.robots.samples import bhr_text, build, build_model, card_data, changed

from gaitsmith.errors import BadInput
from gaitsmith.robots.sole import Sole

CLOSE = 1e-12
TRAPEZOID = [(-0.05, -0.02), (0.12, -0.035), (0.12, 0.035), (-0.05, 0.02)]
LINE_WITH_A_TOE_BAR = [(-0.09, 0.0), (0.1, -0.04), (0.12, -0.04), (0.12, 0.04), (0.1, 0.04)]


@pytest.mark.parametrize("points", [TRAPEZOID, LINE_WITH_A_TOE_BAR])
def test_edges_bound_exactly_the_hull_of_the_corners(points: list[tuple[float, float]]) -> None:
    sole = Sole(kind="polygon", points=tuple(points))
    assert np.linalg.norm(sole.edges[:, :2], axis=1) == pytest.approx(1.0)
    room = sole.edges[:, 2] - sole.corners @ sole.edges[:, :2].T
    assert room.min() > -CLOSE
    assert (np.abs(room) < CLOSE).sum(axis=1).tolist() == [2] * len(points)
    assert (sole.heel, sole.toe) == (-min(x for x, _ in points), max(x for x, _ in points))
    assert sole.half_width == max(y for _, y in points)


def test_a_rectangle_is_the_polygon_of_its_corners() -> None:
    rectangle = Sole(kind="rectangle", heel=0.05, toe=0.12, half_width=0.03)
    polygon = Sole(kind="polygon", points=tuple(map(tuple, rectangle.corners.tolist())))
    for field in ("edges", "ends", "corners"):
        assert getattr(polygon, field) == pytest.approx(getattr(rectangle, field)), field


def test_ends_are_the_edges_that_the_sole_turns_about() -> None:
    assert Sole(kind="polygon", points=tuple(TRAPEZOID)).ends.tolist() == [[-0.05, -0.02, 0.02], [0.12, -0.035, 0.035]]
    assert Sole(kind="polygon", points=tuple(LINE_WITH_A_TOE_BAR)).ends[0].tolist() == [-0.09, 0.0, 0.0]
    assert Sole(kind="line", heel=0.07, toe=0.12).ends.tolist() == [[-0.07, 0.0, 0.0], [0.12, 0.0, 0.0]]


@pytest.mark.parametrize(
    "points",
    [
        TRAPEZOID[::-1],
        [*TRAPEZOID[:2], (0.0, 0.0), *TRAPEZOID[2:]],
        [(x + 0.1, y) for x, y in TRAPEZOID],
        TRAPEZOID[:2],
        [(0.0, "wide"), *TRAPEZOID[1:]],
        [(np.cos(4 * np.pi * k / 5), np.sin(4 * np.pi * k / 5)) for k in range(5)],
    ],
)
def test_points_that_are_no_sole_are_refused(points: list[tuple[float, float]]) -> None:
    with pytest.raises(BadInput, match=r"legs\[0\].sole: .*points of a") as caught:
        build(changed(card_data(), "legs", 0, "sole", value={"kind": "polygon", "points": points}))
    assert "\n" not in str(caught.value)


def test_a_sole_without_an_ankle_that_rolls_is_a_line_and_says_so() -> None:
    data = card_data()
    for leg in data["legs"]:
        leg["sole"] = {"kind": "polygon", "points": TRAPEZOID}
    robot = build(data)
    assert [(leg.sole.kind, leg.sole.heel, leg.sole.toe) for leg in robot.legs] == [("line", 0.05, 0.12)] * 2
    assert any("as a line" in note for note in robot.notes)
    assert not any("as a line" in note for note in build(card_data()).notes)


def test_an_ankle_that_rolls_keeps_the_soles_shape(tmp_path: Path) -> None:
    text, data = bhr_text(), card_data()
    for leg in data["legs"]:
        leg["sole"] = {"kind": "polygon", "points": TRAPEZOID}
        turned = f'name="{leg["name"]}_ankle" class="ankle"'
        text = text.replace(turned, f'{turned} axis="1 0 0"')
    assert build_model(text, tmp_path, data).legs[0].sole.points == tuple(TRAPEZOID)
