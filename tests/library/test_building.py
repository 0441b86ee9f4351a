"""A library on disk: what a kill leaves is gone on with, what was edited is refused, and grids say what is wrong."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from tests.library.conftest import SPEC

import gaitsmith
from gaitsmith.errors import BadInput
from gaitsmith.library.building import build, frozen, thawed
from gaitsmith.library.family import Family
from gaitsmith.library.folder import Folder, _signed, _text, digest
from gaitsmith.library.spec import checked_spec, key_of
from gaitsmith.robots import load_robot


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def copied(library, target):
    for name, content in contents(library.path).items():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        (target / name).write_bytes(content)
    return Folder(target)


def test_a_build_that_is_killed_goes_on_to_the_same_content(library, tmp_path):
    out = tmp_path / "killed"
    script = (
        "import json, sys\n"
        "from gaitsmith.library.building import build\n"
        "from gaitsmith.library.folder import Folder\n"
        "from gaitsmith.library.spec import checked_spec\n"
        "if __name__ == '__main__':\n"
        "    build(checked_spec(json.loads(sys.argv[1])), Folder(sys.argv[2]))\n"
    )
    (tmp_path / "script.py").write_text(script)
    source = os.path.dirname(os.path.dirname(gaitsmith.__file__))
    environment = os.environ | {"PYTHONPATH": source}
    command = [sys.executable, str(tmp_path / "script.py"), json.dumps(SPEC), str(out)]
    process = subprocess.Popen(command, env=environment)
    try:
        end = time.monotonic() + 300.0
        while not list(out.glob("points/*.json")) and process.poll() is None and time.monotonic() < end:
            time.sleep(0.02)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait(60.0)
    assert not (out / "index.json").exists()
    with pytest.raises(BadInput, match="goes on where it stopped"):
        Family(Folder(out), load_robot("thbip_ii"))
    built = build(checked_spec(SPEC), Folder(out))
    assert built.resumed >= 1
    assert contents(out) == contents(library.path)


def test_files_that_were_damaged_are_planned_again(library, tmp_path):
    folder = copied(library, tmp_path)
    names = ["gaits/001-000-000.json", "warm/001-000-001.npz", "points/000-000-001.json"]
    for name in names:
        (tmp_path / name).write_bytes(b"{}")
    built = build(checked_spec(SPEC), folder)
    assert built.resumed == len(SPEC["speed"]) * len(SPEC["period"]) - len(names)
    assert contents(tmp_path) == contents(library.path)


def test_what_a_kill_left_half_written_is_cleared_away(library, tmp_path):
    folder = copied(library, tmp_path)
    for part in ("points", "warm", "."):
        (tmp_path / part / ".000-000-000.json.0123456789ab.part").write_bytes(b"{")
    built = build(checked_spec(SPEC), folder)
    assert built.resumed == 4
    assert contents(tmp_path) == contents(library.path)


def test_two_builds_are_not_at_work_in_one_folder(library, tmp_path):
    folder = copied(library, tmp_path)
    with folder.alone(), pytest.raises(BadInput, match="no other build"):
        build(checked_spec(SPEC), Folder(tmp_path))
    assert contents(tmp_path) == contents(library.path)


def test_another_grid_does_not_go_into_the_same_folder(library, tmp_path):
    folder = copied(library, tmp_path)
    with pytest.raises(BadInput, match="--out"):
        build(checked_spec(SPEC | {"speed": [0.2, 0.31]}), folder)
    assert contents(tmp_path) == contents(library.path)


@pytest.mark.parametrize(
    ("name", "change", "word"),
    [
        ("points/000-000-000.json", (b'"certified"', b'"failed"   '), "edited"),
        ("points/000-000-000.json", (b"length", b"lenght"), "edited"),
        ("gaits/000-000-000.json", (b"0.2", b"0.3"), "edited"),
        ("index.json", (b"000-000-000", b"000-000-001"), "edited"),
        ("library.json", (b"0.3", b"0.4"), "edited"),
        ("library.json", (b'"version":2', b'"version":9'), "version"),
        ("library.json", (b"gaitsmith-library", b"somebody-library!"), "library build wrote"),
    ],
)
def test_an_edited_library_is_refused_in_one_line(library, tmp_path, name, change, word):
    folder = copied(library, tmp_path)
    path = tmp_path / name
    content = path.read_bytes()
    assert change[0] in content
    path.write_bytes(content.replace(*change, 1))
    for look in (folder.records, lambda: Family(folder, load_robot("thbip_ii"))):
        with pytest.raises(BadInput, match=word) as error:
            look()
        assert "\n" not in str(error.value)


def signed(path, change):
    """A file of a library edited by somebody who knows how its checksum is made."""
    data = json.loads(path.read_text())
    del data["checksum"]
    change(data)
    path.write_text(_signed(data))


@pytest.mark.parametrize(
    ("name", "change", "word"),
    [
        ("index.json", lambda data: data.update(base="start"), "other points"),
        ("index.json", lambda data: data.update(base="../../x"), "other points"),
        ("index.json", lambda data: data["records"].pop("start"), "other points"),
        ("library.json", lambda data: data["spec"]["speed"].__setitem__(0, 0.21), "another step"),
        ("library.json", lambda data: data["spec"]["period"].__setitem__(0, 0.61), "another step"),
    ],
)
def test_a_library_whose_parts_do_not_agree_is_refused(library, tmp_path, name, change, word):
    folder = copied(library, tmp_path)
    signed(tmp_path / name, change)
    with pytest.raises(BadInput, match=word):
        folder.records()


def test_a_gait_of_another_step_is_refused(library, tmp_path):
    folder = copied(library, tmp_path)
    gait, path = (tmp_path / "gaits/001-000-001.json").read_bytes(), tmp_path / "points/000-000-000.json"
    (tmp_path / "gaits/000-000-000.json").write_bytes(gait)
    path.write_text(_text(json.loads(path.read_text()) | {"gait": digest(gait)}))
    signed(tmp_path / "index.json", lambda data: data["records"].update({path.stem: digest(path.read_bytes())}))
    with pytest.raises(BadInput, match="another step"):
        Family(folder, load_robot("thbip_ii"))


@pytest.mark.parametrize("name", ["library.json", "index.json", "points/001-000-000.json", "gaits/001-000-001.json"])
def test_a_cut_library_is_refused_in_one_line(library, tmp_path, name):
    folder = copied(library, tmp_path)
    content = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(content[: len(content) // 2])
    with pytest.raises(BadInput) as error:
        Family(folder, load_robot("thbip_ii"))
    assert "\n" not in str(error.value)


def test_a_library_is_for_one_robot(library):
    with pytest.raises(BadInput, match="planned for"):
        Family(library, load_robot("bhr_b2"))


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"speed": []}, "speed"),
        ({"speed": [0.3, 0.2]}, r"speed\[1\]"),
        ({"speed": [0.2, 9.0]}, r"speed\[1\]"),
        ({"speed": [float("nan")]}, "speed"),
        ({"yaw_rate": [0.1, 0.1]}, r"yaw_rate\[1\]"),
        ({"slope": [0.0, 40.0]}, r"slope\[1\]"),
        ({"period": [0.0]}, "period"),
        ({"speed": [0.01 + k * 1e-3 for k in range(150)], "period": [0.3 + k * 1e-3 for k in range(150)]}, "speed"),
    ],
)
def test_a_grid_that_cannot_be_is_refused(changes, field):
    with pytest.raises(BadInput, match=field):
        checked_spec(SPEC | changes)


def test_gaits_of_two_versions_are_not_mixed(library, tmp_path, monkeypatch):
    folder = copied(library, tmp_path)
    monkeypatch.setattr("gaitsmith.library.folder.source_key", lambda module: "0" * 64)
    with pytest.raises(BadInput, match="version"):
        build(checked_spec(SPEC), folder)
    assert contents(tmp_path) == contents(library.path)


def test_every_point_starts_from_one_nearer_to_the_middle():
    spec = checked_spec(SPEC | {"speed": [0.1, 0.2, 0.3, 0.4, 0.5], "step_height": [0.03, 0.04, 0.05]})
    for point in spec.points:
        steps = 0
        while (parent := spec.parent(point)) is not None:
            assert sum(abs(a - b) for a, b in zip(point, parent, strict=True)) == 1
            point, steps = parent, steps + 1
        assert key_of(point) == "002-001-000"
        assert steps <= 2 + 1 + 1


def test_what_a_neighbour_starts_from_comes_back_whole(library):
    for key in ("000-000-000", "start"):
        _, content = library.left(key)
        assert frozen(thawed(content)) == content
    with pytest.raises(BadInput, match="warm"):
        thawed(content[: len(content) // 2])
