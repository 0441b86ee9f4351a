"""What a model file says, as a text that needs no other file and that MuJoCo reads."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import PurePosixPath

from gaitsmith.errors import BadInput
from gaitsmith.robots.safety import CardFolder

EQUAL_LIMITS = "equal lower and upper limits"


@dataclass(frozen=True)
class MeshFile:
    """A mesh as a model names it; read only if a shape that collides needs it.

    Attributes:
        folder: where it is read from.
        name: as the file says.
        bases: folders, relative to the card's, from which the name may count.
        entry: what errors begin with.
    """

    folder: CardFolder
    name: str
    bases: tuple[str, ...]
    entry: str

    def read(self) -> tuple[str, bytes]:
        """The file's ending in small letters, and its content.

        Raises:
            BadInput: outside, missing, or too large.
        """
        found = self.folder.find(self.name, self.bases, self.entry)
        try:
            return PurePosixPath(self.name).suffix.lower(), self.folder.read(found, self.entry)
        except BadInput as error:
            raise BadInput(self.entry, self.name, error.valid, error.remedy) from None


@dataclass(frozen=True)
class Coupling:
    """Joints that do not move independently, and why."""

    joints: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class Drive:
    """Speed and torque that a URDF allows a joint; None where it says nothing."""

    velocity: float | None
    torque: float | None


@dataclass(frozen=True)
class ModelText:
    """A model that needs no file beside its meshes.

    Attributes:
        text: MJCF or URDF.
        meshes: by the names that the text uses.
        entry: what errors begin with, the model's file name.
        urdf_mass: sum of the URDF's masses, kg; None for MJCF.
        left_out: kinds of element that the file has and the text has not.
        couplings: of its joints.
        drives: of a URDF's joints, by name.
        keyframe: the first keyframe's positions; empty without one.
    """

    text: str
    meshes: dict[str, MeshFile]
    entry: str
    urdf_mass: float | None
    left_out: tuple[str, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    drives: dict[str, Drive] = field(default_factory=dict)
    keyframe: tuple[float, ...] = ()


def read_model(folder: CardFolder, name: str) -> ModelText:
    """The model file of that name, relative to the folder.

    Raises:
        BadInput: it cannot be read, is neither MJCF nor URDF, or holds something that cannot be represented.
    """
    from gaitsmith.robots.mjcf import mjcf_text
    from gaitsmith.robots.safety import parse_xml
    from gaitsmith.robots.urdf import urdf_text

    path = PurePosixPath(name)
    root = parse_xml(folder.read(name, f"{folder.label}: model" if folder.label else "model"), path.name)
    readers = {"mujoco": mjcf_text, "robot": urdf_text}
    if root.tag not in readers:
        raise BadInput(
            f"{path.name}: root element", root.tag, "mujoco (MJCF) or robot (URDF)", "convert it to one of them"
        )
    if macro := next((element.tag for element in root.iter() if "xacro" in element.tag), None):
        remedy = "expand it first: xacro FILE > robot.urdf"
        raise BadInput(f"{path.name}: element", macro.rpartition("}")[2], "a URDF without xacro's macros", remedy)
    return readers[root.tag](root, folder, path)
