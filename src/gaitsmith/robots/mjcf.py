"""MJCF: one self-contained text with the parts that make a robot, and nothing that acts on its own.

Kept: bodies, joints, inertias, shapes, sites, meshes, defaults, actuators, contact filters. Left out, because the plant
brings its own or the control has none: options, sizes, sensors, lights, cameras, looks; keyframes, equality constraints
and tendons, of which :class:`ModelText` keeps what matters. Refused: everything else.
"""

from __future__ import annotations

from pathlib import PurePosixPath
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from gaitsmith.errors import BadInput
from gaitsmith.robots.couplings import couplings
from gaitsmith.robots.model_text import MeshFile, ModelText
from gaitsmith.robots.safety import CardFolder, check_size, parse_xml

INCLUDE_LIMIT = 50
NAMED_IN = "gaitsmith_named_in"
COMPILER_KEPT = (
    *("angle", "eulerseq", "autolimits", "balanceinertia", "boundmass", "boundinertia"),
    *("inertiafromgeom", "inertiagrouprange", "settotalmass"),
)
MESH_KEPT = (
    *("name", "class", "scale", "inertia", "smoothnormal", "maxhullvert", "vertex", "normal", "texcoord"),
    *("face", "refpos", "refquat"),
)
SECTIONS_DROPPED = ("option", "size", "visual", "statistic", "keyframe", "sensor", "custom", "equality", "tendon")
ACTUATORS = (
    *("motor", "general", "position", "velocity", "intvelocity", "damper", "pid", "dcmotor", "orientation"),
    *("cylinder", "muscle", "adhesion"),
)
KEPT = {
    "mujoco": ("compiler", "default", "asset", "worldbody", "actuator", "contact"),
    "default": ("default", "joint", "geom", "site", "mesh", "pair", *ACTUATORS),
    "asset": ("mesh",),
    "worldbody": ("body", "geom", "site", "frame"),
    "body": ("body", "joint", "freejoint", "inertial", "geom", "site", "frame"),
    "frame": ("body", "joint", "freejoint", "inertial", "geom", "site", "frame"),
    "actuator": ACTUATORS,
    "contact": ("exclude", "pair"),
}
DROPPED = {
    "mujoco": SECTIONS_DROPPED,
    "default": ("camera", "light", "material", "equality", "tendon"),
    "asset": ("texture", "material", "hfield", "skin"),
    "worldbody": ("light", "camera"),
    "body": ("light", "camera"),
    "frame": ("light", "camera"),
    "compiler": ("lengthrange",),
}
REASONS = {
    "extension": "plugins are not loaded",
    "plugin": "plugins are not loaded",
    "deformable": "only rigid bodies can be represented",
    "include": "an included file is inserted once, in place",
}


def mjcf_text(root: Element, folder: CardFolder, path: PurePosixPath) -> ModelText:
    """A model that needs no file.

    Args:
        root: the parsed main file.
        folder: where includes and meshes are read from.
        path: of the main file, relative to the folder.

    Raises:
        BadInput: an include cannot be read, or the model holds something that cannot be represented.
    """
    entry, home = path.name, str(path.parent)
    _expand(root, folder, entry, set(), (home, home))
    check_size(root, entry)
    meshes = _collect_meshes(root, folder, entry, home)
    coupled, keyframe = couplings(root), _keyframe(root)
    left_out: set[str] = set()
    _filter(root, entry, left_out)
    text = ElementTree.tostring(root, encoding="unicode")
    return ModelText(text, meshes, entry, None, tuple(sorted(left_out)), coupled, keyframe=keyframe)


def _keyframe(root: Element) -> tuple[float, ...]:
    """Positions of the first keyframe; nothing if there is none that can be read."""
    key = root.find("keyframe/key")
    try:
        return tuple(map(float, key.get("qpos", "").split())) if key is not None else ()
    except ValueError:
        return ()


def _expand(element: Element, folder: CardFolder, entry: str, seen: set[str], bases: tuple[str, str]) -> None:
    """Replace every include by the content of its file; meshes remember the folder of the file that names them."""
    for index in range(len(element) - 1, -1, -1):
        child = element[index]
        if child.tag != "include":
            _expand(child, folder, entry, seen, bases)
            continue
        name = child.get("file", "")
        where = f"{entry}: include {name}"
        found = folder.find(name, (*bases, "."), where)
        if len(seen) >= INCLUDE_LIMIT or found in seen:
            raise BadInput(where, name, f"every file included once, at most {INCLUDE_LIMIT} files")
        seen.add(found)
        included = parse_xml(folder.read(found, where), where)
        if included.tag not in ("mujoco", "mujocoinclude"):
            raise BadInput(where, included.tag, "a root element mujoco or mujocoinclude")
        here = str(PurePosixPath(found).parent)
        for mesh in included.iter("mesh"):
            mesh.set(NAMED_IN, here)
        _expand(included, folder, entry, seen, (here, bases[1]))
        check_size(included, where)
        element[index : index + 1] = list(included)


def _collect_meshes(root: Element, folder: CardFolder, entry: str, home: str) -> dict[str, MeshFile]:
    """Meshes by the name that replaces their path; their folder comes from the last compiler element."""
    directory, strip = "", False
    for compiler in root.iter("compiler"):
        directory = compiler.get("meshdir", compiler.get("assetdir", directory))
        strip = compiler.get("strippath", str(strip)).lower() == "true"
    files: dict[str, MeshFile] = {}
    for mesh in (mesh for asset in root.iter("asset") for mesh in asset.iter("mesh")):
        name, here = mesh.get("file"), mesh.attrib.pop(NAMED_IN, home)
        kept = {key: value for key, value in mesh.attrib.items() if key in MESH_KEPT}
        if refused := sorted(set(mesh.attrib) - set(kept) - {"file", "content_type", "material"}):
            raise BadInput(f"{entry}: mesh", refused[0], f"attributes among {', '.join(MESH_KEPT)}")
        mesh.attrib.clear()
        mesh.attrib.update(kept)
        if name is None:
            continue
        path = PurePosixPath(name)
        bases = tuple(str(PurePosixPath(base) / directory) for base in dict.fromkeys((here, home, ".")))
        key = f"mesh{len(files)}.obj"
        files[key] = MeshFile(folder, path.name if strip else name, bases, f"{entry}: mesh file")
        mesh.set("file", key)
        if "name" not in mesh.attrib:
            mesh.set("name", path.stem)
    return files


def _filter(element: Element, entry: str, left_out: set[str]) -> None:
    """Keep what makes a robot, drop what the plant brings itself, refuse the rest."""
    element.attrib.pop("material", None)
    kept, dropped = KEPT.get(element.tag, ()), DROPPED.get(element.tag, ())
    for child in list(element):
        if child.tag in dropped or (child.tag == "geom" and "hfield" in child.attrib):
            element.remove(child)
            left_out.add(child.tag)
        elif child.tag not in kept:
            reason = REASONS.get(child.tag, "remove it or simplify the model")
            raise BadInput(f"{entry}: {element.tag}", f"<{child.tag}>", f"only {', '.join(kept) or 'nothing'}", reason)
        else:
            _filter(child, entry, left_out)
    if element.tag == "compiler":
        _keep(element, COMPILER_KEPT)
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
