"""Feet without shapes: what their soles could be, and boxes for the soles that the user gives."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitsmith.adoption.anatomy import Anatomy
from gaitsmith.adoption.card_text import rpy
from gaitsmith.adoption.soles import SoleFound
from gaitsmith.errors import BadInput

Array = NDArray[np.float64]
_THICK = 0.01  # m at most
_PERSON = (0.06, 0.19, 0.05, 0.09)  # of hip height: heel, toe, half width and depth of a person's sole
_LARGEST = 0.35  # of hip height
_NARROW = 0.005  # m, half the width of a line's box


def sole_candidates(model: mujoco.MjModel, anatomy: Anatomy) -> list[str]:
    """Sizes that a sole could have, as `--sole` takes them.

    The first is of the box with the left foot's mass and inertia, unless that is no foot's; the last is a person's, for
    legs of this length.
    """
    data, leg = anatomy.data, anatomy.legs[0]
    bodies = [body for body in leg.links if model.body_mass[body] > 0.0]
    persons = tuple(share * anatomy.hip_height for share in _PERSON)
    if not bodies:
        return [_sizes(persons)]
    body = max(bodies, key=lambda b: model.body_mass[b])
    moments = model.body_inertia[body] / model.body_mass[body]
    spread = np.sqrt(np.maximum(3.0 * (moments.sum() / 2.0 - moments), 0.0))
    turn = anatomy.axes.T @ data.ximat[body].reshape(3, 3)
    half = np.sqrt(turn**2 @ spread**2)
    middle = anatomy.axes.T @ (data.xipos[body] - leg.ankle)
    sizes = (half[0] - middle[0], half[0] + middle[0], half[1], half[2] - middle[2])
    likely = min(sizes) > 0.0 and max(sizes) < _LARGEST * anatomy.hip_height
    return [_sizes(sizes), _sizes(persons)] if likely else [_sizes(persons)]


def _sizes(values: Iterable[float]) -> str:
    return " ".join(f"{value:.3f}" for value in values)


def add_soles(files: dict[str, bytes], model: mujoco.MjModel, anatomy: Anatomy, soles: list[SoleFound]) -> None:
    """Put a box under each foot, so that it can stand, into the model's text.

    Args:
        files: by name; changed.

    Raises:
        BadInput: no file has the foot's body.
    """
    for sole in soles:
        name = model.body(sole.body).name
        for file, content in files.items():
            if file.endswith((".xml", ".urdf")) and (changed := _with_box(content, name, *_box(anatomy.data, sole))):
                files[file] = changed
                break
        else:
            raise BadInput("--sole", name, "feet whose bodies have names in the model file")


def _box(data: mujoco.MjData, sole: SoleFound) -> tuple[Array, Array, Array]:
    """Half sizes, place and rotation in the body's frame."""
    width = max(sole.half_width, _NARROW)
    half = np.array([(sole.heel + sole.toe) / 2.0, width, _THICK / 2.0])
    centre = sole.position + sole.axes @ np.array([(sole.toe - sole.heel) / 2.0, 0.0, _THICK / 2.0])
    rotation: Array = data.xmat[sole.body].reshape(3, 3)
    return half, rotation.T @ (centre - data.xpos[sole.body]), rotation.T @ sole.axes


def _with_box(content: bytes, body: str, half: Array, place: Array, rotation: Array) -> bytes | None:
    """The file with a box on a body; None if it has no such body."""
    root = ElementTree.fromstring(content)
    if root.tag == "robot":
        link = next((link for link in root.findall("link") if link.get("name") == body), None)
        if link is None:
            return None
        collision = SubElement(link, "collision", {"name": f"{body}_sole"})
        SubElement(collision, "origin", {"xyz": _words(place), "rpy": _words(rpy(rotation))})
        SubElement(SubElement(collision, "geometry"), "box", {"size": _words(2.0 * half)})
    else:
        found = next((element for element in root.iter("body") if element.get("name") == body), None)
        if found is None:
            return None
        axes = {"xyaxes": _words((*rotation[:, 0], *rotation[:, 1]))}
        numbers = {"size": _words(half), "pos": _words(place), "mass": "0", "contype": "1", "conaffinity": "1"}
        found.append(Element("geom", {"name": f"{body}_sole", "type": "box", **numbers, **axes}))
    written: bytes = ElementTree.tostring(root, encoding="utf-8")
    return written


def _words(values: Iterable[float]) -> str:
    return " ".join(f"{value:.9g}" for value in values)
