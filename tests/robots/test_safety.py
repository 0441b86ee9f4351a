from __future__ import annotations

import os
from pathlib import Path

import pytest
from tests.robots.samples import BHR, bhr_text, build, build_model, card_data

from gaitsmith.errors import BadInput
from gaitsmith.robots.model_text import read_model
from gaitsmith.robots.safety import DEPTH_LIMIT, ELEMENT_LIMIT, FILE_LIMIT, CardFolder, parse_xml

DOCTYPES = [
    '<!DOCTYPE mujoco [<!ENTITY a "b">]><mujoco model="&a;"/>',
    '<!DOCTYPE mujoco SYSTEM "file:///etc/passwd"><mujoco/>',
    '<!DOCTYPE mujoco [<!ENTITY a SYSTEM "file:///etc/passwd">]><mujoco>&a;</mujoco>',
    "<!DOCTYPE mujoco><mujoco/>",
]


@pytest.mark.parametrize("text", DOCTYPES)
def test_document_types_are_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(BadInput, match="DOCTYPE"):
        build_model(text, tmp_path)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<",
        "<mujoco>",
        "<mujoco>&undefined;</mujoco>",
        '<?xml version="1.0" encoding="nonsense"?><mujoco/>',
        "<a><b></a></b>",
        "\0",
        "<mujoco/><mujoco/>",
    ],
)
def test_broken_xml_is_one_line(text: str) -> None:
    with pytest.raises(BadInput, match=r"^model\.xml") as caught:
        parse_xml(text.encode(), "model.xml")
    assert "\n" not in str(caught.value)


def test_depth_and_crowds_are_bounded() -> None:
    deep = "<a>" * (DEPTH_LIMIT + 1) + "</a>" * (DEPTH_LIMIT + 1)
    crowd = "<a>" + "<b/>" * ELEMENT_LIMIT + "</a>"
    for text in (deep, crowd):
        with pytest.raises(BadInput, match="at most"):
            parse_xml(text.encode(), "model.xml")


@pytest.mark.parametrize("number", ["nan", "-inf", "NaN", "+Infinity", "1e999", "1 nan 2"])
def test_numbers_are_finite(number: str) -> None:
    with pytest.raises(BadInput, match="finite numbers"):
        parse_xml(f'<mujoco><geom size="{number}"/></mujoco>'.encode(), "model.xml")


@pytest.mark.parametrize("value", ["%s", "%n%n", "a%p"])
def test_no_text_that_the_engine_may_take_for_a_format(value: str) -> None:
    for text in (f'<a><joint class="{value}"/></a>', f'<a name="{value}"/>'):
        with pytest.raises(BadInput, match="percent"):
            parse_xml(text.encode(), "model.xml")
    assert parse_xml(f'<a file="{value}"/>'.encode(), "model.xml").get("file") == value


def test_paths_stay_below_the_card(tmp_path: Path) -> None:
    (tmp_path / "secret.xml").write_text("<mujoco/>")
    inner = tmp_path / "robot"
    (inner / "meshes").mkdir(parents=True)
    (inner / "good.xml").write_text("<mujoco/>")
    (inner / "out.xml").symlink_to(tmp_path / "secret.xml")
    (inner / "folder").symlink_to(tmp_path)
    (inner / "loop.xml").symlink_to(inner / "loop.xml")
    (inner / "within.xml").symlink_to(inner / "good.xml")
    os.mkfifo(inner / "pipe.xml")
    folder = CardFolder(inner.resolve(), "card.toml")
    assert folder.read("good.xml", "x") == folder.read("./within.xml", "x") == b"<mujoco/>"
    assert folder.read("meshes/../good.xml", "x") == b"<mujoco/>"
    assert list(folder.contents) == ["good.xml"]
    bad = [
        "../secret.xml",
        str(tmp_path / "secret.xml"),
        "out.xml",
        "folder/secret.xml",
        "meshes/../../secret.xml",
        "meshes",
    ]
    bad += ["loop.xml", "pipe.xml", "", ".", "none.xml", "nul\0", "C:\\x.xml", "a\nb", "x" * 5000]
    for name in bad:
        with pytest.raises(BadInput, match=r"^here: got ") as caught:
            folder.read(name, "here")
        assert "\n" not in str(caught.value)


def test_size_is_bounded(tmp_path: Path) -> None:
    with (tmp_path / "model.xml").open("wb") as file:
        file.truncate(FILE_LIMIT + 1)
    with pytest.raises(BadInput, match="20000000 bytes"):
        build(card_data() | {"model": "model.xml"}, tmp_path)


def test_includes_are_read_inside_only(tmp_path: Path) -> None:
    text = bhr_text()
    start, end = text.index("  <actuator>"), text.index("</mujoco>")
    (tmp_path / "motors.xml").write_text(f"<mujocoinclude>{text[start:end]}</mujocoinclude>")
    robot = build_model(text[:start] + '<include file="motors.xml"/></mujoco>', tmp_path)
    assert robot.model.nu == 8
    hashed = robot.content_hash
    (tmp_path / "motors.xml").write_text(f"<mujocoinclude>{text[start:end]}<!-- --></mujocoinclude>")
    assert build_model(text[:start] + '<include file="motors.xml"/></mujoco>', tmp_path).content_hash != hashed
    for name in ("/etc/passwd", "../motors.xml", "none.xml", "", "model.xml"):
        with pytest.raises(BadInput):
            build_model(text[:start] + f'<include file="{name}"/></mujoco>', tmp_path)


def test_includes_do_not_multiply(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text('<mujoco><include file="b.xml"/><include file="b.xml"/></mujoco>')
    (tmp_path / "b.xml").write_text("<mujoco/>")
    with pytest.raises(BadInput, match="included once"):
        build_model('<mujoco><include file="a.xml"/></mujoco>', tmp_path)
    for i in range(60):
        (tmp_path / f"i{i}.xml").write_text(f'<mujoco><include file="i{i + 1}.xml"/></mujoco>')
    with pytest.raises(BadInput, match="at most"):
        build_model('<mujoco><include file="i0.xml"/></mujoco>', tmp_path)


def test_shipped_files_are_all_hashed() -> None:
    folder = CardFolder(BHR, "card.toml")
    empty = folder.digest(b"card")
    folder.read("bhr_b2.xml", "x")
    assert len({empty, folder.digest(b"card"), folder.digest(b"other")}) == 3


def test_a_file_above_the_card_is_refused_with_what_to_do(tmp_path: Path) -> None:
    (tmp_path / "mesh.stl").write_bytes(b"solid")
    (tmp_path / "robot").mkdir()
    folder = CardFolder(tmp_path / "robot", "card.toml")
    for name in ("../mesh.stl", "package://any/../mesh.stl"):
        with pytest.raises(BadInput, match="below the card's folder; put the card into a folder above it, or let"):
            folder.find(name, ("",), "model.urdf: mesh")


def test_other_formats_are_told_what_to_become(tmp_path: Path) -> None:
    folder = CardFolder(tmp_path, "")
    (tmp_path / "a.sdf").write_text('<sdf version="1.6"/>')
    (tmp_path / "a.xacro").write_text('<robot name="a" xmlns:xacro="http://ros.org/xacro"><xacro:include/></robot>')
    with pytest.raises(BadInput, match="convert it"):
        read_model(folder, "a.sdf")
    with pytest.raises(BadInput, match="expand it first: xacro FILE"):
        read_model(folder, "a.xacro")
