"""Any document becomes checked data or one short line, in time that grows with its size."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, Field

from gaitsmith.documents import Name, checked, parse_json, parse_toml, read_toml
from gaitsmith.documents.reading import KEY_PARTS, LIMIT
from gaitsmith.errors import BadInput
from gaitsmith.robots.card import RobotCard
from gaitsmith.simulation.scenario import Scenario
from gaitsmith.synthesis.files.motion_file import MotionText

SECONDS = 2.0  # for documents on which a quadratic reader takes 10 s and more
LONGEST = 700  # characters of a message


class Inner(BaseModel, extra="forbid"):
    """A table."""

    share: Annotated[float, Field(gt=0.0, le=1.0, allow_inf_nan=False)] = 0.5
    names: Annotated[tuple[Name, ...], Field(max_length=3)] = ()


class Outer(BaseModel, extra="forbid"):
    """A document."""

    size: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
    inner: Inner = Inner()
    by_name: dict[Name, Inner] = Field(default_factory=dict)


@pytest.mark.parametrize(
    ("data", "told"),
    [
        ({}, "f: size: got nothing, expected a finite number from 0"),
        ({"size": "1"}, "f: size: got '1', expected a finite number from 0"),
        ({"size": True}, "f: size: got True, expected a finite number"),
        ({"size": 10**400}, "f: size: got "),
        ({"size": float("nan")}, "f: size: got nan, expected a finite number"),
        ({"size": 1, "inner": {"share": 0}}, "f: inner.share: got 0, expected a finite number above 0 up to 1"),
        ({"size": 1, "inner": 3}, "f: inner: got 3, expected a table"),
        (
            {"size": 1, "iner": 3},
            "f: iner: got 3, expected no such entry; this table takes only size, inner, by_name; ",
        ),
        ({"size": 1, "inner": {"names": ["a\nb"]}}, "f: inner.names[0]: got 'a\\nb', expected 1 to 200 printable"),
        (
            {"size": 1, "inner": {"names": list("abcd")}},
            "f: inner.names: got ['a', 'b', 'c', 'd'], expected a list of 0 to",
        ),
        ({"size": 1, "by_name": {"=a": {}}}, "f: by_name.=a: got '=a', expected 1 to 200 printable"),
        ({"size": 1, "by_name": {"a": {"share": 2}}}, "f: by_name.a.share: got 2, expected a finite number above 0"),
    ],
)
def test_refusals_name_the_entry_its_value_and_what_is_valid(data: object, told: str) -> None:
    with pytest.raises(BadInput) as caught:
        checked(Outer, data, "f")
    assert str(caught.value).startswith(told)


def test_a_close_name_is_suggested() -> None:
    with pytest.raises(BadInput, match="did you mean inner"):
        checked(Outer, {"iner": 3, "size": 1})


def test_keys_of_many_parts_are_refused_before_they_are_parsed() -> None:
    for key in (".".join("a" * 20_000), " . ".join(['"a"'] * 300), ".".join(["'a'"] * (KEY_PARTS + 1))):
        for text in (f"{key} = 1", f"[{key}]", f"x = {{ {key} = 1 }}", f'y = "\\""\n{key} = 1'):
            with pytest.raises(BadInput, match=f"keys of at most {KEY_PARTS} parts"):
                parse_toml(text.encode(), "f", "a card")


@pytest.mark.parametrize(
    "text",
    [
        ".".join("a" * KEY_PARTS) + " = 1",
        f'x = "{".".join("a" * 100)}"\ny = """\n{".".join("a" * 100)}\n"""',
        "# " + ".".join("a" * 100) + "\n",
        "x = [" + "1.5, " * 100 + "]",
        "".join(f"a.b{k}.c = 1\n" for k in range(100)),
    ],
)
def test_dots_elsewhere_than_in_a_key_are_as_many_as_wanted(text: str) -> None:
    parse_toml(text.encode(), "f", "a card")


@pytest.mark.parametrize(
    "content",
    [
        b"a." * (LIMIT // 2 - 4) + b"a = 1",
        b"a = " + b'"\\' * (LIMIT // 2 - 4),
        b'a = """' + b"\\" * (LIMIT - 8),
        b"a = " + b"[" * (LIMIT - 5),
        b'"' * LIMIT,
        b"'" * LIMIT,
        b"a = " + b"9" * (LIMIT - 5),
    ],
)
def test_the_worst_documents_are_refused_fast(content: bytes) -> None:
    began = time.process_time()
    with pytest.raises(BadInput):
        parse_toml(content, "f", "a card")
    assert time.process_time() - began < SECONDS


def test_twins_are_found_in_linear_time() -> None:
    keys = ",".join(f'"{k}":0' for k in range(200_000))
    began = time.process_time()
    assert len(parse_json(f"{{{keys}}}".encode())) == 200_000
    with pytest.raises(ValueError, match="'199999' twice"):
        parse_json(f'{{{keys},"199999":0}}'.encode())
    assert time.process_time() - began < SECONDS
    with pytest.raises(ValueError, match="Infinity"):
        parse_json(b"[-Infinity]")


@pytest.mark.parametrize(
    "text", ["", " a", "a ", "a\nb", "a\tb", "a\u00a0b", "a\u200bb", "\x1b[31m", "=1", "-a", "+a", "@a", "a" * 201]
)
def test_names_are_plain_text(text: str) -> None:
    with pytest.raises(BadInput, match="printable"):
        checked(Inner, {"names": [text]})
    for name in ("left knee", "knie_rechts_ü", "$x$", "a=b,c"):
        assert checked(Inner, {"names": [name]}).names == (name,)


def test_a_file_is_bounded_and_named(tmp_path: Path) -> None:
    path = tmp_path / "big.toml"
    path.write_bytes(b"#" * (LIMIT + 1))
    with pytest.raises(BadInput, match=r"big\.toml.*at most 1000000 bytes"):
        read_toml(path, "a card")


def test_a_byte_order_mark_and_line_ends_of_windows_change_nothing() -> None:
    for text in ('share = 0.5\r\nname = "a"\r\n', 'share = 0.5\nname = "a"\n'):
        assert parse_toml(b"\xef\xbb\xbf" + text.encode(), "x.toml", "a card") == {"share": 0.5, "name": "a"}
    assert parse_json(b'\xef\xbb\xbf{"share": 0.5}') == {"share": 0.5}


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ({"sped": 1}, "sped: got 1, expected no such entry; .* did you mean speed"),
        ({"duration": -1}, "duration: got -1, expected a finite number above 0"),
        ({"speed": (1, 2, 3)}, r"speed: got \(1, 2, 3\), expected one or two finite numbers"),
        ({"pushes": ({"time": 1.0},)}, r"pushes\[0\]\.impulse: got nothing"),
    ],
)
def test_what_python_gives_is_refused_as_a_file_is(values: dict[str, Any], told: str) -> None:
    with pytest.raises(BadInput, match=told):
        Scenario(**values)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.just(10**4000) | st.just("x" * 5000),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8) | st.just("k" * 5000), inner),
    max_leaves=8,
)


@given(st.sampled_from([RobotCard, Scenario, MotionText]), st.data())
def test_whatever_is_in_a_document_is_refused_in_one_short_line(model: type[BaseModel], data: st.DataObject) -> None:
    fields = data.draw(st.dictionaries(st.sampled_from(list(model.model_fields)) | st.text(), VALUES, max_size=5))
    try:
        checked(model, fields, "some.toml")
    except BadInput as error:
        assert len(str(error).splitlines()) == 1
        assert len(str(error)) <= LONGEST
