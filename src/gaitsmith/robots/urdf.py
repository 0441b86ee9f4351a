"""URDF: what MuJoCo's importer would drop is kept by asking it for another, equivalent tree.

The importer merges the root link into the world, which loses its mass, and fuses fixed links, which loses sole frames.
A floating joint between a link named `world` and the root link, and the flag against fusing, keep both.
"""

from __future__ import annotations

import math
from pathlib import PurePosixPath
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from gaitsmith.errors import BadInput
from gaitsmith.robots.safety import CardFolder, mesh_path

JOINT_KINDS = ("revolute", "continuous", "prismatic", "fixed")
SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")
WORLD = "world"
LINK_LIMIT = 300


def urdf_text(root: Element, folder: CardFolder, entry: str) -> tuple[str, dict[str, bytes], float]:
    """A URDF with a floating base that needs no file, its meshes by name, and the sum of its links' masses in kg.

    Kept are links with inertia and collision shapes, and joints; not kept are visual shapes, transmissions and other
    programs' extensions.

    Raises:
        BadInput: no single root link, a joint that cannot be represented (mimic, planar, floating), a bad mass.
    """
    robot = Element("robot", {"name": root.get("name") or "robot"})
    compiler = SubElement(SubElement(robot, "mujoco"), "compiler")
    compiler.attrib.update(fusestatic="false", discardvisual="true", inertiafromgeom="false", strippath="false")
    meshes: dict[str, bytes] = {}
    links = {link.get("name", ""): link for link in root.findall("link")}
    joints = root.findall("joint")
    if not 0 < len(links) <= LINK_LIMIT or len(links) != len(root.findall("link")):
        raise BadInput(f"{entry}: links", len(root.findall("link")), f"1 to {LINK_LIMIT} links, each with its own name")
    base = _base(links, joints, entry)
    SubElement(robot, "link", {"name": WORLD})
    floating = SubElement(robot, "joint", {"name": "root", "type": "floating"})
    SubElement(floating, "parent", {"link": WORLD})
    SubElement(floating, "child", {"link": base})
    mass = 0.0
    for name, link in links.items():
        if name == WORLD:
            continue
        kept = SubElement(robot, "link", {"name": name})
        for inertial in link.findall("inertial"):
            kept.append(inertial)
            mass += _mass(inertial, f"{entry}: link {name}")
        for collision in link.findall("collision"):
            kept.append(_collision(collision, folder, f"{entry}: link {name}", meshes))
    for joint in joints:
        parent = joint.find("parent")
        if parent is None or parent.get("link") != WORLD:
            robot.append(_joint(joint, entry))
    return ElementTree.tostring(robot, encoding="unicode"), meshes, mass


def _base(links: dict[str, Element], joints: list[Element], entry: str) -> str:
    """The one link without a parent, a massless link named world aside."""
    children: dict[str | None, str | None] = {}
    for joint in joints:
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None or {parent.get("link"), child.get("link")} - set(links):
            raise BadInput(f"{entry}: joint {joint.get('name', '')}", joint.get("name"), "a parent and a child link")
        if child.get("link") in children:
            raise BadInput(f"{entry}: link {child.get('link')}", "two parents", "a tree: one parent for each link")
        children[child.get("link")] = parent.get("link")
    roots = [name for name in links if name not in children]
    if roots == [WORLD] and links[WORLD].find("inertial") is None:
        roots = [child or "" for child, parent in children.items() if parent == WORLD]
    if len(roots) != 1 or roots[0] == WORLD:
        raise BadInput(f"{entry}: root link", roots, "exactly one link without a parent, not named world")
    for name in links:
        link: str | None = name
        for _ in links:
            link = children.get(link)
        if link not in (None, roots[0]):
            raise BadInput(f"{entry}: link {name}", "a loop", "a tree: every link hangs from the root link")
    return roots[0]


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


def _collision(collision: Element, folder: CardFolder, entry: str, meshes: dict[str, bytes]) -> Element:
    kept = Element("collision")
    for origin in collision.findall("origin")[:1]:
        kept.append(origin)
    shapes = [shape for geometry in collision.findall("geometry") for shape in geometry]
    if len(shapes) != 1 or shapes[0].tag not in SHAPES:
        raise BadInput(f"{entry}: collision", [s.tag for s in shapes], f"one shape among {', '.join(SHAPES)}")
    shape = shapes[0]
    if shape.tag == "mesh":
        name = shape.get("filename", "").removeprefix("file://")
        if name.startswith("package://"):
            name = str(PurePosixPath(*PurePosixPath(name.removeprefix("package://")).parts[1:]))
        path = mesh_path(name, "", f"{entry}: mesh")
        key = f"mesh{len(meshes)}{PurePosixPath(path).suffix.lower()}"
        meshes[key] = folder.read(path, f"{entry}: mesh")
        shape.set("filename", key)
    SubElement(kept, "geometry").append(shape)
    return kept


def _joint(joint: Element, entry: str) -> Element:
    kind, name = joint.get("type", ""), joint.get("name", "")
    if kind not in JOINT_KINDS:
        raise BadInput(f"{entry}: joint {name}", kind, f"one of {', '.join(JOINT_KINDS)}", "cannot be represented")
    if joint.find("mimic") is not None:
        raise BadInput(f"{entry}: joint {name}", "mimic", "independent joints", "couplings cannot be represented")
    kept = Element("joint", {"name": name, "type": kind})
    for tag in ("origin", "parent", "child", "axis", "limit", "dynamics"):
        for element in joint.findall(tag)[:1]:
            kept.append(element)
    return kept
