"""From a stranger's model file to a folder with a card, a picture, and what the robot can do; written whole or not."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gaitsmith.adoption.anatomy import Anatomy, Flags, find_anatomy
from gaitsmith.adoption.card_text import CardDraft, Entry, draft_card
from gaitsmith.adoption.feet import add_soles, sole_candidates
from gaitsmith.adoption.holding import outside, too_weak, unlike_limits
from gaitsmith.adoption.options import AdoptOptions
from gaitsmith.adoption.picture import portrait_of
from gaitsmith.adoption.refusals import Asked
from gaitsmith.adoption.search import Found, search
from gaitsmith.adoption.sheet import measure, reserves
from gaitsmith.adoption.soles import GivenSole, SoleFound, find_sole, matched, measured_sole, rocking
from gaitsmith.adoption.source import find_model, including
from gaitsmith.adoption.trials import Doctor, Test, examine
from gaitsmith.errors import BadInput
from gaitsmith.experiments.result import Progress, silent
from gaitsmith.experiments.store import Store
from gaitsmith.files import write_bytes_atomic, write_text_atomic
from gaitsmith.robots import Robot, load_robot
from gaitsmith.robots.model_file import ModelFile, listed, open_model
from gaitsmith.simulation.run_folder import check_new_folder
from gaitsmith.view.canvas import save
from gaitsmith.view.portrait import draw_portrait

_PLAIN = {"", "mujoco model", "model", "scene", "robot", "main", "mjcf", "urdf"}  # file names that say nothing
_ALIKE = 0.005  # of hip height: difference of left and right soles that is the maker's tolerance
_LESS = 0.02  # of a range: what is walked less than it is written into the card
_CARD, _PICTURE, _RUNS = "card.toml", "robot.png", ".runs"


@dataclass
class Adoption:
    """What came of it.

    Attributes:
        card: its path; None if something has to be asked.
        reason: why something is asked, in one line.
    """

    card: Path | None
    document: dict[str, Any]
    tests: tuple[Test, ...] = ()
    reason: str = ""

    @property
    def ok(self) -> bool:
        """Whether every test was passed."""
        return bool(self.tests) and all(test.ok for test in self.tests)


def adopt(options: AdoptOptions, progress: Progress = silent) -> Adoption:
    """Infer a card, test it, and write its folder.

    Raises:
        BadInput: the model cannot be read, is no biped, or the folder cannot be written.
        KeyboardInterrupt: Ctrl-C; nothing is written.
    """
    progress(0, 0, "reading the model")
    path = find_model(options.model)
    if options.out:
        check_new_folder(options.out)
    found = open_model(path)
    name = _robot_name(options, path, str(found.spec.modelname))
    out = check_new_folder(options.out or name)
    flags = Flags(options.feet, options.torso)
    anatomy: Anatomy | None = None
    try:
        anatomy = find_anatomy(found.model, found.entry, found.coupled, flags)
        soles = _soles(found, anatomy, None if options.sole is None else GivenSole(*options.sole))
    except Asked as error:
        scene = _scene(path, flags) if error.flag == "--sole" else None
        if scene is None:
            return Adoption(None, _document(None, name, found, anatomy, None, [error.document()]), reason=str(error))
        found, anatomy, soles = scene
    files = dict(found.files)
    model_file = next(iter(files))
    if options.sole is not None:
        add_soles(files, found.model, anatomy, soles)
    welded = _welded(found, anatomy)
    draft = draft_card(name, model_file, found.model, anatomy, soles, welded)
    with _staged(out) as folder:
        _write(folder, files, draft)
        robot = load_robot(folder)
        weak = _weak(robot, found, anatomy)
        if weak := {joint: weak[joint] for joint in outside(robot, weak)}:
            draft = draft_card(name, model_file, found.model, anatomy, soles, welded | weak)
            _write(folder, files, draft)
            robot = load_robot(folder)
        store = Store(folder / _RUNS)
        doctor = examine(robot, str(folder), progress=progress)
        tried: Found | None = None
        if doctor.standing.ok and doctor.soles.ok and not doctor.walk.ok and options.search:
            stage = _stage(folder, files, draft)
            tried = search(robot, stage, store, options.search, options.seed, options.jobs, progress)
            if tried is not None and tried.walks:
                _use(draft, tried, options.seed)
                _write(folder, files, draft)
                robot = load_robot(folder)
                doctor = examine(robot, str(folder), progress=progress)
        sheet = _sheet(robot, folder, doctor, store, options, progress)
        _narrow(draft, robot, sheet or {})
        if unlike := unlike_limits(found.model, anatomy):
            draft.remarks.append(f"note: {unlike}")
        rocks = rocking(soles)
        draft.remarks += [f"note: {note}" for note in rocks]
        draft.remarks += _remarks(robot, found, doctor, sheet)
        write_text_atomic(folder / _CARD, draft.text())
        robot = load_robot(folder)
        save(draw_portrait(portrait_of(robot)), folder / _PICTURE)
        document = _document(robot, name, found, anatomy, draft, [])
        document["notes"] += rocks
        document["tests"] = {test.name: test.document() for test in doctor.tests}
        document["search"] = {"rollouts": tried.rollouts if tried else 0, "seconds": tried.seconds if tried else 0.0}
        document["sheet"] = sheet
        for extra in folder.glob(f"{_RUNS}*"):
            shutil.rmtree(extra)
    document["card"] = str(out / _CARD)
    return Adoption(out / _CARD, document, doctor.tests)


def _robot_name(options: AdoptOptions, path: Path, own: str) -> str:
    """The user's, else that of the file, of the model, or of the folder, whichever says something first."""
    if options.name:
        return options.name
    said = [name for name in (path.stem, own, path.resolve().parent.name) if name.lower() not in _PLAIN]
    plain = re.sub(r"[^A-Za-z0-9_.-]+", "_", said[0] if said else "").strip("_.-")
    return plain[:64] or "robot"


@contextlib.contextmanager
def _staged(out: Path) -> Iterator[Path]:
    """A folder beside the wanted one, renamed to it at the end, removed if anything fails before."""
    folder = out.resolve().parent / f".{out.name[:60]}.{secrets.token_hex(4)}"
    try:
        folder.mkdir(parents=True)
        yield folder
        os.rename(folder, out)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise BadInput("--out", str(out), "a folder that can be written", reason) from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _write(folder: Path, files: dict[str, bytes], draft: CardDraft) -> None:
    """Model, meshes and card."""
    for relative, content in files.items():
        target = folder / relative
        if not target.exists():
            target.parent.mkdir(parents=True, exist_ok=True)
            write_bytes_atomic(target, content)
    write_text_atomic(folder / _CARD, draft.text())


def _stage(
    folder: Path, files: dict[str, bytes], draft: CardDraft
) -> Callable[[dict[str, dict[str, dict[str, Any]]]], tuple[str, Robot]]:
    """Loads the robot with more presets from a folder of their own; see :data:`gaitsmith.adoption.search.Stage`."""
    rounds = iter(range(1_000_000))

    def stage(presets: dict[str, dict[str, dict[str, Any]]]) -> tuple[str, Robot]:
        place = folder / f"{_RUNS}{next(rounds)}"
        tables = dict(draft.tables)
        for name, groups in presets.items():
            for group, values in groups.items():
                tables[f"presets.{name}.{group}"] = [Entry(key, value, "") for key, value in values.items()]
        place.mkdir()
        _write(place, files, CardDraft(draft.header, draft.legs, tables))
        return str(place), load_robot(place)

    return stage


def _scene(path: Path, flags: Flags) -> tuple[ModelFile, Anatomy, list[SoleFound]] | None:
    """The first scene beside a model that includes it and gives its feet shapes that collide."""
    for scene in including(path):
        with contextlib.suppress(BadInput):
            found = open_model(scene)
            anatomy = find_anatomy(found.model, found.entry, found.coupled, flags)
            note = f"read from {scene.name}, which says what collides"
            return replace(found, notes=(note, *found.notes)), anatomy, _soles(found, anatomy, None)
    return None


def _soles(found: ModelFile, anatomy: Anatomy, given: GivenSole | None) -> list[SoleFound]:
    if given is not None:
        return [measured_sole(leg, anatomy, given) for leg in anatomy.legs]
    for leg in anatomy.legs:
        if not leg.shapes:
            what = f"no shape that collides on the {leg.name} foot, {found.model.body(leg.foot).name}"
            sizes, valid = sole_candidates(found.model, anatomy), "feet with shapes, or the size of their soles"
            raise Asked("--sole", sizes, found.entry, what, valid, "give --sole HEEL TOE HALF_WIDTH DEPTH, m")
    return matched([find_sole(leg, anatomy, found.entry) for leg in anatomy.legs], _ALIKE * anatomy.hip_height)


def _welded(found: ModelFile, anatomy: Anatomy) -> dict[str, str]:
    """Joints that the card welds, and why."""
    toes = [found.model.joint(j).name for leg in anatomy.legs for j in leg.toes]
    return dict.fromkeys(toes, "toes: the sole is rigid")


def _weak(robot: Robot, found: ModelFile, anatomy: Anatomy) -> dict[str, str]:
    """As :func:`too_weak`; what keeps the robot from standing is explained."""
    try:
        return too_weak(robot)
    except BadInput as error:
        unlike = unlike_limits(found.model, anatomy)
        raise BadInput(found.entry, f"{error.field}: {error.value}", error.valid, unlike or error.remedy) from None


def _use(draft: CardDraft, tried: Found, seed: int) -> None:
    """The found gait and gains as entries."""
    source = f"search with seed {seed}, best of {tried.rollouts}"
    draft.tables["gait"] = [Entry(name, value, source) for name, value in tried.gait.items()]
    for group, values in tried.gains.items():
        draft.tables[f"presets.default.{group}"] = [Entry(key, value, source) for key, value in values.items()]


def _sheet(
    robot: Robot, folder: Path, doctor: Doctor, store: Store, options: AdoptOptions, progress: Progress
) -> dict[str, Any] | None:
    if doctor.failed is not None:
        return None
    own = measure(robot, str(folder), store, options.jobs, progress) if not options.no_sheet else {}
    return own | reserves(robot, doctor.summary)


def _narrow(draft: CardDraft, robot: Robot, sheet: dict[str, Any]) -> None:
    """Limits of the gait where less was walked than the robot's size suggests."""
    for part, (low, high) in robot.card.gait_limits:
        walked = sheet.get(part, (low, high))
        if walked[0] - low > _LESS * (high - low) or high - walked[1] > _LESS * (high - low):
            inside = [max(walked[0], low), min(walked[1], high)]
            draft.tables.setdefault("gait_limits", []).append(Entry(part, inside, "walked in simulation"))


def _assumed(robot: Robot, found: ModelFile) -> list[Entry]:
    """What neither the model nor its geometry says."""
    entries = []
    for kind in ("position", "velocity", "torque"):
        silent_joints = [name for name in robot.joint_names if getattr(found.limits[name], kind) is None]
        values = {_short(getattr(robot.card.limits[name], kind)) for name in silent_joints}
        if silent_joints:
            names = "every joint" if len(silent_joints) == len(robot.joint_names) else listed(silent_joints)
            shown = min(values) if len(values) == 1 else sorted(values)
            entries.append(Entry(f"limits.*.{kind}", shown, f"a robot of this size; the model gives none for {names}"))
    for name, value in robot.card.gait.model_dump(mode="json").items():
        if value not in (0.0, [0.0, 0.0]):
            entries.append(Entry(f"gait.{name}", _short(value), "a robot of this size"))
    return entries


def _short(value: Any) -> Any:
    """Numbers with four digits."""
    return tuple(map(_short, value)) if isinstance(value, (list, tuple)) else float(f"{value:.4g}")


def _remarks(robot: Robot, found: ModelFile, doctor: Doctor, sheet: dict[str, Any] | None) -> list[str]:
    """What the card's end says."""
    lines = [f"assumed: {e.entry} = {e.value}: {e.source}" for e in _assumed(robot, found) if "limits" in e.entry]
    lines += [f"note: {note}" for note in robot.notes]
    lines += [f"test: {test.words}" for test in doctor.tests]
    return lines + [f"walked: {key} {value}" for key, value in (sheet or {}).items()]


def _document(
    robot: Robot | None,
    name: str,
    found: ModelFile,
    anatomy: Anatomy | None,
    draft: CardDraft | None,
    asked: list[dict[str, Any]],
) -> dict[str, Any]:
    """The JSON contract, without tests, search and sheet."""
    legs = [
        {"name": leg.name, "joints": [found.model.joint(j).name for j in leg.joints], "roles": list(leg.roles)}
        for leg in (anatomy.legs if anatomy else ())
    ]
    return {
        "card": None,
        "robot": name,
        "legs": legs,
        "inferred": [entry.document() for entry in draft.inferred] if draft else [],
        "assumed": [entry.document() for entry in _assumed(robot, found)] if robot else [],
        "asked": asked,
        "notes": list(robot.notes) if robot else list(found.notes),
        "tests": {},
        "search": {"rollouts": 0, "seconds": 0.0},
        "sheet": None,
    }
