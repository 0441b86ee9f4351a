"""Points of meshes that MuJoCo does not read."""

from __future__ import annotations

import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.robots.foreign_meshes import points_of

CORNERS = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]])
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def dae(nodes: str, unit: str = '<unit meter="1"/>', up: str = "Z_UP") -> bytes:
    numbers = " ".join(map(str, CORNERS.ravel()))
    return (
        f'<COLLADA xmlns="http://x"><asset>{unit}<up_axis>{up}</up_axis></asset>'
        '<library_geometries><geometry id="g"><mesh>'
        f'<source id="n"><float_array>9 9 9</float_array></source><source id="p"><float_array>{numbers}</float_array>'
        '</source><vertices><input semantic="POSITION" source="#p"/></vertices></mesh></geometry></library_geometries>'
        f"<library_visual_scenes><visual_scene>{nodes}</visual_scene></library_visual_scenes></COLLADA>"
    ).encode()


def same(found: np.ndarray | None, wanted: np.ndarray) -> None:
    assert found is not None
    assert found[np.lexsort(found.T)] == pytest.approx(wanted[np.lexsort(wanted.T)], abs=1e-6)


def test_text_stl() -> None:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS[list(face)])
        + "endloop\nendfacet\n"
        for face in FACES
    )
    same(points_of(f"solid x\n{facets}endsolid".encode(), ".stl", "m"), CORNERS)
    assert points_of(b"\0" * 200, ".stl", "m") is None
    with pytest.raises(BadInput, match="damaged"):
        points_of(b"solid\nfacet\nvertex a b c\n", ".stl", "m")


def test_collada_puts_points_where_its_nodes_say() -> None:
    shape = '<instance_geometry url="#g"/>'
    same(points_of(dae(f"<node>{shape}</node>"), ".dae", "m"), CORNERS)
    same(points_of(dae(f"<node>{shape}</node>", '<unit meter="0.01"/>'), ".dae", "m"), CORNERS * 0.01)
    moved = (
        f"<node><translate>1 2 3</translate><node><rotate>0 0 1 90</rotate><scale>2 2 2</scale>{shape}</node></node>"
    )
    quarter = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    same(points_of(dae(moved), ".dae", "m"), 2.0 * CORNERS @ quarter.T + [1, 2, 3])
    matrix = f"<node><matrix>0 -1 0 5 1 0 0 0 0 0 1 0 0 0 0 1</matrix>{shape}</node>"
    same(points_of(dae(matrix), ".dae", "m"), CORNERS @ quarter.T + [5, 0, 0])


def test_collada_whose_y_is_up_is_turned_until_z_is() -> None:
    node = '<node><instance_geometry url="#g"/></node>'
    x, y, z = CORNERS.T
    same(points_of(dae(node, up="Y_UP"), ".dae", "m"), np.column_stack([x, -z, y]))


@pytest.mark.parametrize(
    "text", [b"<COLLADA/>", b"<", dae("<node><matrix>1</matrix></node>"), dae('<unit meter="x"/>')]
)
def test_damaged_collada_is_refused_or_has_no_nodes(text: bytes) -> None:
    try:
        assert points_of(text, ".dae", "m") is not None
    except BadInput as error:
        assert "\n" not in str(error)
