"""The map of a library: every gait in its cell, and no range of colours that is not there."""

import math

import pytest

from gaitsmith.library.folder import Record
from gaitsmith.library.spec import checked_spec, key_of
from gaitsmith.view.library_map import draw_library


def drawn(axes, left_out=(), failed=()):
    """The map of a grid whose gaits cost 10, 11, 12, ... a metre."""
    spec = checked_spec({"robot": "thbip_ii", **axes})
    records = {}
    for number, point in enumerate(spec.points):
        certified = Record(status="certified", objective=10.0 + number, parameters={"length": 1.0})
        records[key_of(point)] = Record(status="failed", reason="why") if point in failed else certified
    for point in left_out:
        del records[key_of(point)]
    return spec, draw_library(spec, records)


def cells(figure):
    """Panels without the colour bar, and what is written in all of them."""
    panels = [axis for axis in figure.axes if axis.get_visible() and axis.get_label() != "<colorbar>"]
    return panels, sorted(text.get_text() for axis in panels for text in axis.texts)


@pytest.mark.parametrize("axes", [{"speed": [0.2]}, {"speed": [0.1, 0.2], "period": [0.6]}])
def test_one_gait_has_its_number_and_no_range_of_colours(axes):
    _, figure = drawn(axes, left_out=[(1, 0)] if len(axes["speed"]) > 1 else ())
    panels, numbers = cells(figure)
    assert len(figure.axes) == len(panels) == 1
    assert numbers == ["10"]


def test_a_library_without_a_gait_has_no_colours():
    _, figure = drawn({"speed": [0.1, 0.2]}, failed=[(0,), (1,)])
    assert len(figure.axes) == 1
    assert cells(figure)[1] == []


def test_the_colours_reach_from_the_least_cost_to_the_largest():
    _, figure = drawn({"speed": [0.1, 0.2, 0.3]})
    (bar,) = [axis for axis in figure.axes if axis.get_label() == "<colorbar>"]
    assert bar.get_ylim() == pytest.approx((10.0, 12.0))


@pytest.mark.parametrize(
    ("axes", "panels", "up"),
    [
        ({"step_height": [0.03, 0.04], "period": [0.6, 0.7]}, 2, "period, s"),
        ({"step_height": [0.03, 0.04, 0.05], "period": [0.6, 0.7]}, 2, "step height, m"),
        ({"yaw_rate": [-0.1, 0.0, 0.1], "slope": [0.0, 3.0]}, 2, "yaw rate, rad/s"),
        ({"period": [0.5, 0.6, 0.7], "yaw_rate": [0.0, 0.1], "slope": [0.0, 3.0]}, 4, "period, s"),
    ],
)
def test_every_axis_is_drawn_and_every_gait_is_in_its_cell(axes, panels, up):
    spec, figure = drawn({"speed": [0.1, 0.2], **axes})
    shown, numbers = cells(figure)
    assert numbers == sorted(str(10 + number) for number in range(len(spec.points)))
    assert len(shown) == panels
    assert {axis.get_ylabel() for axis in shown} <= {up, ""}
    assert up in {axis.get_ylabel() for axis in shown}
    place = spec.points[-1]
    last = shown[-1]
    at = {text.get_text(): text.get_position() for text in last.texts}
    x, y = at[str(9 + math.prod(len(axis) for axis in spec.axes))]
    assert (x, y) == (place[0], len(getattr(spec, up.split(",")[0].replace(" ", "_"))) - 1)
