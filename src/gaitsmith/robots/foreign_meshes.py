"""Meshes that MuJoCo does not read, as points: text STL and COLLADA; a shape that collides is their convex hull."""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from gaitsmith.errors import BadInput
from gaitsmith.robots.safety import DEPTH_LIMIT, parse_xml

Array = NDArray[np.float64]
POINT_LIMIT = 2_000_000
_VERTEX = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)")


def points_of(content: bytes, kind: str, entry: str) -> Array | None:
    """(n, 3) points of a mesh in its file's frame, m; None if it is of a kind that is not read here.

    Raises:
        BadInput: it is damaged, or has too many points.
    """
    try:
        if kind == ".dae":
            points = _collada(_plain(parse_xml(content, entry)))
        elif kind == ".stl" and content[:5] == b"solid" and b"facet" in content[:1000]:
            points = np.array(_VERTEX.findall(content), dtype=np.float64).reshape(-1, 3)
        else:
            return None
    except (ValueError, IndexError, KeyError, RecursionError) as error:
        raise BadInput(entry, f"a damaged {kind} file", "points in three numbers each", str(error)) from None
    if not 4 <= len(points) <= POINT_LIMIT or not np.isfinite(points).all():
        raise BadInput(entry, f"{len(points)} points", f"4 to {POINT_LIMIT} points, of finite numbers")
    return np.unique(points.astype(np.float32), axis=0).astype(np.float64)


def _plain(root: Element) -> Element:
    for element in root.iter():
        element.tag = str(element.tag).rpartition("}")[2]
    return root


def _collada(root: Element) -> Array:
    """Points of every geometry where the scene's nodes put it, z up."""
    unit = root.find("asset/unit")
    scale = float(unit.get("meter", "1")) if unit is not None else 1.0
    geometries = {f"#{item.get('id')}": _positions(item) for item in root.iter("geometry")}
    found: list[Array] = []

    def visit(node: Element, outer: Array, depth: int) -> None:
        pose = outer.copy()
        for child in node:
            if child.tag in ("matrix", "translate", "rotate", "scale"):
                pose = pose @ _transform(child.tag, np.array((child.text or "").split(), dtype=np.float64))
        for child in node:
            if child.tag == "instance_geometry":
                points = geometries.get(child.get("url", ""), np.zeros((0, 3)))
                found.append(points @ pose[:3, :3].T + pose[:3, 3])
            elif child.tag == "node" and depth < DEPTH_LIMIT:
                visit(child, pose, depth + 1)

    for scene in root.iter("visual_scene"):
        visit(scene, np.eye(4), 0)
    points = scale * np.vstack(found or list(geometries.values()) or [np.zeros((0, 3))])
    up = root.findtext("asset/up_axis", "Y_UP").strip()  # the standard's default
    return points[:, [0, 2, 1]] * [1.0, -1.0, 1.0] if up == "Y_UP" else points


def _positions(geometry: Element) -> Array:
    """Positions of a geometry's vertices, not its normals or texture coordinates."""
    source = geometry.find("mesh/vertices/input[@semantic='POSITION']")
    name = "" if source is None else source.get("source", "").removeprefix("#")
    for item in geometry.iter("source"):
        numbers = item.find("float_array")
        if item.get("id") == name and numbers is not None:
            return np.array((numbers.text or "").split(), dtype=np.float64).reshape(-1, 3)
    return np.zeros((0, 3))


def _transform(kind: str, numbers: Array) -> Array:
    """A node's transformation as a (4, 4) matrix."""
    if kind == "matrix":
        return numbers.reshape(4, 4)
    pose = np.eye(4)
    if kind == "translate":
        pose[:3, 3] = numbers
    elif kind == "scale":
        pose[:3, :3] = np.diag(numbers)
    else:
        axis, angle = numbers[:3] / np.linalg.norm(numbers[:3]), np.radians(numbers[3])
        cross = np.cross(np.eye(3), axis)
        pose[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return pose
