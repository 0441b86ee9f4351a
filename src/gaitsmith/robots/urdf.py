"""URDF: what MuJoCo's importer would drop is kept by asking it for another, equivalent tree.

The importer merges the root link into the world, which loses its mass, and fuses fixed links, which loses sole frames.
A floating joint between a link named `world` and the root link, and the flag against fusing, keep both.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import PurePosixPath
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from gaitsmith.errors import BadInput
from gaitsmith.robots.model_text import EQUAL_LIMITS, Coupling, Drive, MeshFile, ModelText
from gaitsmith.robots.safety import CardFolder

JOINT_KINDS = ("revolute", "continuous", "prismatic", "fixed")
SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")
WORLD = "world"
LINK_LIMIT = 300


def urdf_text(root: Element, folder: CardFolder, path: PurePosixPath) -> ModelText:
    """A URDF with a floating base that needs no file.

    Kept are links with inertia and collision shapes, and joints; not kept are visual shapes, transmissions, other
    programs' extensions, and links without mass above the base.

    Args:
        root: the parsed file.
        folder: where meshes are read from.
        path: of the file, relative to the folder.

    Raises:
        BadInput: no single root link, a joint that cannot be represented (planar, floating), a bad mass.
    """
    entry = path.name
    robot = Element("robot", {"name": root.get("name") or "robot"})
    compiler = SubElement(SubElement(robot, "mujoco"), "compiler")
    compiler.attrib.update(fusestatic="false", discardvisual="true", inertiafromgeom="false", strippath="false")
    meshes: dict[str, MeshFile] = {}
    links = {link.get("name", ""): link for link in root.findall("link")}
    joints = root.findall("joint")
    names = [link.get("name", "") for link in root.findall("link")]
    if twice := next((name for name in links if names.count(name) > 1), None):
        raise BadInput(f"{entry}: links", twice, "names that all differ", "two links have this one")
    if not 0 < len(names) <= LINK_LIMIT:
        raise BadInput(f"{entry}: links", len(names), f"1 to {LINK_LIMIT} links")
    base, above = _base(links, joints, entry)
    SubElement(robot, "link", {"name": WORLD})
    floating = SubElement(robot, "joint", {"name": "root", "type": "floating"})
    SubElement(floating, "parent", {"link": WORLD})
    SubElement(floating, "child", {"link": base})
    mass = 0.0
    for name, link in links.items():
        if name in above:
            continue
        kept = SubElement(robot, "link", {"name": name})
        for inertial in link.findall("inertial"):
            kept.append(inertial)
            mass += _mass(inertial, f"{entry}: link {name}")
        for collision in link.findall("collision"):
            kept.append(_collision(collision, MeshFile(folder, "", (str(path.parent), "."), entry), name, meshes))
    couplings, drives = [], {}
    for joint in joints:
        parent = joint.find("parent")
        if parent is None or parent.get("link") in above:
            continue
        robot.append(_joint(joint, entry))
        name, mimic, limit = joint.get("name", ""), joint.find("mimic"), joint.find("limit")
        if mimic is not None and joint.get("type") != "fixed":
            couplings.append(Coupling(tuple(filter(None, (name, mimic.get("joint")))), "mimic"))
        if limit is not None:
            ends = [limit.get(end) for end in ("lower", "upper")]
            if joint.get("type") in ("revolute", "prismatic") and None not in ends and len(set(ends)) == 1:
                couplings.append(Coupling((name,), EQUAL_LIMITS))
            drives[name] = Drive(_positive(limit.get("velocity")), _positive(limit.get("effort")))
    text = ElementTree.tostring(robot, encoding="unicode")
    return ModelText(text, meshes, entry, mass, couplings=tuple(couplings), drives=drives)


def _positive(text: str | None) -> float | None:
    """A number above 0; None for any other text, since exporters write 0 where they know nothing."""
    try:
        number = float(text or 0.0)
    except ValueError:
        return None
    return number if 0.0 < number < math.inf else None


def _base(links: dict[str, Element], joints: list[Element], entry: str) -> tuple[str, set[str]]:
    """The floating link, and the empty links above it: each has one fixed or floating joint, or is named world."""
    children: dict[str | None, str | None] = {}
    for joint in joints:
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None or {parent.get("link"), child.get("link")} - set(links):
            raise BadInput(f"{entry}: joint {joint.get('name', '')}", joint.get("name"), "a parent and a child link")
        if child.get("link") in children:
            raise BadInput(f"{entry}: link {child.get('link')}", "two parents", "a tree: one parent for each link")
        children[child.get("link")] = parent.get("link")
    roots = [name for name in links if name not in children]
    if len(roots) != 1:
        raise BadInput(f"{entry}: root link", roots, "exactly one link without a parent")
    for name in links:
        link: str | None = name
        for _ in links:
            link = children.get(link)
        if link not in (None, roots[0]):
            raise BadInput(f"{entry}: link {name}", "a loop", "a tree: every link hangs from the root link")
    base, above = roots[0], set()
    while links[base].find("inertial") is None and (base == WORLD or links[base].find("collision") is None):
        below = [joint for joint in joints if joint.find("parent").get("link") == base]  # type: ignore[union-attr]
        if len(below) != 1 or (base != WORLD and below[0].get("type") not in ("fixed", "floating")):
            break
        above.add(base)
        base = below[0].find("child").get("link", "")  # type: ignore[union-attr]
    if base == WORLD:
        raise BadInput(f"{entry}: root link", WORLD, "a link of another name, or an empty one with one joint")
    return base, above


def _mass(inertial: Element, entry: str) -> float:
    element = inertial.find("mass")
    text = element.get("value", "") if element is not None else ""
    try:
        mass = float(text)
    except ValueError:
        mass = math.nan
    if not 0.0 <= mass < math.inf:
        raise BadInput(f"{entry}: mass", text, "a number of kilograms, 0 or more")
    return mass


def _collision(collision: Element, place: MeshFile, link: str, meshes: dict[str, MeshFile]) -> Element:
    kept, entry = Element("collision"), f"{place.entry}: link {link}"
    for origin in collision.findall("origin")[:1]:
        kept.append(origin)
    shapes = [shape for geometry in collision.findall("geometry") for shape in geometry]
    if len(shapes) != 1 or shapes[0].tag not in SHAPES:
        raise BadInput(f"{entry}: collision", [s.tag for s in shapes], f"one shape among {', '.join(SHAPES)}")
    shape = shapes[0]
    if shape.tag == "mesh":
        key = f"mesh{len(meshes)}.obj"
        meshes[key] = replace(place, name=shape.get("filename", ""), entry=f"{entry}: mesh")
        shape.set("filename", key)
    SubElement(kept, "geometry").append(shape)
    return kept


def _joint(joint: Element, entry: str) -> Element:
    kind, name = joint.get("type", ""), joint.get("name", "")
    if kind not in JOINT_KINDS:
        raise BadInput(f"{entry}: joint {name}", kind, f"one of {', '.join(JOINT_KINDS)}", "cannot be represented")
    kept = Element("joint", {"name": name, "type": kind})
    for tag in ("origin", "parent", "child", "axis", "limit", "dynamics"):
        for element in joint.findall(tag)[:1]:
            kept.append(element)
    return kept
