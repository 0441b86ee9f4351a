"""The crash test keeps its contract, gives the same again, refuses controllers it cannot run, and shows a page."""

from __future__ import annotations

import json
import shlex

import pytest

from gaitsmith.cli.dispatch import COMMANDS
from gaitsmith.documents import checked
from gaitsmith.errors import BadInput
from gaitsmith.experiments import CrashOptions, run_crash
from gaitsmith.reports.crash_page import command, write_crash_page

SMALL = {"only": ("pushes", "episodes"), "runs": 1, "directions": 2, "phases": 1, "strength": 0.3}


class _FromTheCommandLine(CrashOptions):
    json_: bool = True


@pytest.fixture(scope="module")
def crashed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("crash")
    return folder, run_crash(_FromTheCommandLine(**SMALL, out=str(folder)))


def test_the_document_keeps_the_contract(crashed):
    folder, result = crashed
    document = json.loads((folder / "crash.json").read_text())
    assert document == json.loads(json.dumps(result.document))
    assert {"cells", "survived", "recovered", "largest"} <= document["pushes"].keys()
    assert document["pushes"]["recovered"] <= document["pushes"]["survived"] <= document["pushes"]["cells"] == 2
    assert {"runs", "survived", "interval", "falls"} == document["episodes"].keys()
    low, high = document["episodes"]["interval"]
    assert 0.0 <= low <= document["episodes"]["survived"] <= high <= 1.0
    assert [document[part] for part in ("faults", "weakest_push", "terrain", "tour")] == [None] * 4


def test_the_same_again_from_the_store_and_a_page_that_says_how(crashed):
    folder, result = crashed
    kept = (folder / "episodes.jsonl").read_text()
    again = run_crash(CrashOptions(**SMALL, out=str(folder)))
    assert again.document == result.document
    assert (folder / "episodes.jsonl").read_text() == kept
    page = write_crash_page(result.document, folder)
    text = page.read_text()
    assert (folder / "crash_pushes.png").stat().st_size > 10_000
    assert "<script" not in text
    assert result.document["identity"] in text
    words = shlex.split(command(result.document))
    assert tuple(words[1:3]) in COMMANDS
    assert {word[2:] for word in words[3::2]} <= CrashOptions.model_fields.keys()
    given = dict(zip(words[3::2], words[4::2], strict=True))
    assert (given["--strength"], given["--runs"], given["--only"]) == ("0.3", "1", "episodes")


@pytest.mark.parametrize(
    ("fields", "flag"),
    [
        ({"controller": "theirs"}, "--controller"),
        ({"controller": "onnx:/nowhere"}, "/nowhere"),
        ({"preset": "x"}, "--preset"),
        ({"engine": "ray"}, "--address"),
    ],
)
def test_what_cannot_be_tested_is_one_line_and_runs_nothing(tmp_path, fields, flag):
    with pytest.raises(BadInput) as caught:
        run_crash(CrashOptions(**fields, out=str(tmp_path / "out")))
    assert caught.value.field == flag
    assert not (tmp_path / "out").exists()


def test_numbers_out_of_range_are_refused():
    with pytest.raises(BadInput, match="strength"):
        checked(CrashOptions, {"strength": 0.0}, "")
