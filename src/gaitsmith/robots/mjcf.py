"""MJCF: one self-contained text with the parts that make a robot, and nothing that acts on its own.

Kept: bodies, joints, inertias, collision and visual shapes, sites, meshes, defaults, actuators, contact filters. Left
out, because the plant brings its own: options, sizes, keyframes, sensors, lights, cameras, textures. Refused, because
the control cannot represent it: everything else.
"""

from __future__ import annotations

from pathlib import PurePosixPath
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from gaitsmith.errors import BadInput
from gaitsmith.robots.safety import CardFolder, check_size, mesh_path, parse_xml

INCLUDE_DEPTH = 10
COMPILER_KEPT = (
    *("angle", "eulerseq", "autolimits", "balanceinertia", "boundmass", "boundinertia"),
    *("inertiafromgeom", "inertiagrouprange", "settotalmass"),
)
MESH_KEPT = (
    *("name", "class", "scale", "inertia", "smoothnormal", "maxhullvert", "vertex", "normal", "texcoord"),
    *("face", "refpos", "refquat"),
)
SECTIONS_DROPPED = ("option", "size", "visual", "statistic", "keyframe", "sensor", "custom")
ACTUATORS = (
    *("motor", "general", "position", "velocity", "intvelocity", "damper", "pid", "dcmotor", "orientation"),
    *("cylinder", "muscle", "adhesion"),
)
KEPT = {
    "mujoco": ("compiler", "default", "asset", "worldbody", "actuator", "contact"),
    "default": ("default", "joint", "geom", "site", "mesh", "material", *ACTUATORS),
    "asset": ("mesh", "material"),
    "worldbody": ("body", "geom", "site", "frame"),
    "body": ("body", "joint", "freejoint", "inertial", "geom", "site", "frame"),
    "frame": ("body", "joint", "freejoint", "inertial", "geom", "site", "frame"),
    "actuator": ACTUATORS,
    "contact": ("exclude", "pair"),
}
DROPPED = {
    "mujoco": SECTIONS_DROPPED,
    "default": ("camera", "light", "pair", "equality", "tendon"),
    "asset": ("texture",),
    "worldbody": ("light", "camera"),
    "body": ("light", "camera"),
    "frame": ("light", "camera"),
    "compiler": ("lengthrange",),
    "material": ("layer",),
}
REASONS = {
    "tendon": "tendons couple joints, which the control cannot represent",
    "equality": "closed loops and couplings are not a tree, which the control cannot represent",
    "extension": "plugins are not loaded",
    "plugin": "plugins are not loaded",
    "deformable": "only rigid bodies can be represented",
    "include": "an included file is inserted once, in place",
}


def mjcf_text(root: Element, folder: CardFolder, entry: str) -> tuple[str, dict[str, bytes], tuple[str, ...]]:
    """A model that needs no file, its meshes by name, and the kinds of element that were left out.

    Args:
        root: the parsed main file.
        folder: where includes and meshes are read from.
        entry: what errors begin with.

    Raises:
        BadInput: an include or mesh cannot be read, or the model holds something the control cannot represent.
    """
    _expand(root, folder, entry, set(), 0)
    check_size(root, entry)
    meshes = _collect_meshes(root, folder, entry)
    left_out: set[str] = set()
    _filter(root, entry, left_out)
    return ElementTree.tostring(root, encoding="unicode"), meshes, tuple(sorted(left_out))


def _expand(element: Element, folder: CardFolder, entry: str, seen: set[str], depth: int) -> None:
    """Replace every include by the content of its file."""
    for index in range(len(element) - 1, -1, -1):
        child = element[index]
        if child.tag != "include":
            _expand(child, folder, entry, seen, depth)
            continue
        name = child.get("file", "")
        where = f"{entry}: include {name}"
        if depth >= INCLUDE_DEPTH or name in seen:
            raise BadInput(where, name, f"every file included once, at most {INCLUDE_DEPTH} deep")
        seen.add(name)
        included = parse_xml(folder.read(name, where), where)
        if included.tag not in ("mujoco", "mujocoinclude"):
            raise BadInput(where, included.tag, "a root element mujoco or mujocoinclude")
        _expand(included, folder, entry, seen, depth + 1)
        check_size(included, where)
        element[index : index + 1] = list(included)


def _collect_meshes(root: Element, folder: CardFolder, entry: str) -> dict[str, bytes]:
    """Meshes by the name that replaces their path; the folder comes from the last compiler element."""
    directory, strip = "", False
    for compiler in root.iter("compiler"):
        directory = compiler.get("meshdir", compiler.get("assetdir", directory))
        strip = compiler.get("strippath", str(strip)).lower() == "true"
    contents: dict[str, bytes] = {}
    for asset in root.iter("asset"):
        for mesh in asset.iter("mesh"):
            name = mesh.get("file")
            kept = {key: value for key, value in mesh.attrib.items() if key in MESH_KEPT}
            if refused := sorted(set(mesh.attrib) - set(kept) - {"file", "content_type"}):
                raise BadInput(f"{entry}: mesh", refused[0], f"attributes among {', '.join(MESH_KEPT)}")
            mesh.attrib.clear()
            mesh.attrib.update(kept)
            if name is None:
                continue
            where = f"{entry}: mesh file"
            path = mesh_path(PurePosixPath(name).name if strip else name, directory, where)
            key = f"mesh{len(contents)}{PurePosixPath(path).suffix.lower()}"
            contents[key] = folder.read(path, where)
            mesh.set("file", key)
            if "name" not in mesh.attrib:
                mesh.set("name", PurePosixPath(path).stem)
    return contents


def _filter(element: Element, entry: str, left_out: set[str]) -> None:
    """Keep what makes a robot, drop what the plant brings itself, refuse the rest."""
    kept, dropped = KEPT.get(element.tag, ()), DROPPED.get(element.tag, ())
    for child in list(element):
        if child.tag in dropped:
            element.remove(child)
            left_out.add(child.tag)
        elif child.tag not in kept:
            reason = REASONS.get(child.tag, "remove it or simplify the model")
            raise BadInput(f"{entry}: {element.tag}", f"<{child.tag}>", f"only {', '.join(kept) or 'nothing'}", reason)
        else:
            _filter(child, entry, left_out)
    if element.tag == "compiler":
        _keep(element, COMPILER_KEPT)
    elif element.tag == "material":
        element.attrib.pop("texture", None)
    elif element.tag == "freejoint":
        element.attrib.pop("align", None)
    elif element.tag in ("inertial", "geom"):
        for name in ("mass", "density"):
            if element.get(name, "0").strip().startswith("-"):
                raise BadInput(f"{entry}: {element.tag} {name}", element.get(name), "a number above 0")
    elif element.tag == "body":
        element.attrib.pop("sleep", None)
        for name in ("mocap", "gravcomp"):
            if element.attrib.pop(name, "0") not in ("0", "false"):
                raise BadInput(f"{entry}: body {element.get('name', '')}", name, "a body that obeys gravity")


def _keep(element: Element, names: tuple[str, ...]) -> None:
    for name in [name for name in element.attrib if name not in names]:
        del element.attrib[name]
