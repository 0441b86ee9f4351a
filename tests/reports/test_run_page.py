"""A finished run is read back from its folder, whole or half-written, and shown: page, figures, film."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from tests.cli.test_walk import run

from gaitsmith.errors import BadInput
from gaitsmith.reports import demo, rendering, video
from gaitsmith.reports.rendering import NoRenderer
from gaitsmith.reports.run import open_run
from gaitsmith.simulation.scenario import Scenario


@pytest.fixture(scope="module")
def fallen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A walk that is pushed over."""
    folder = tmp_path_factory.mktemp("runs") / "fallen"
    words = ["--duration", "3", "--rest-before", "0.2", "--push", "0.8,0,150,0", "--no-figures"]
    assert run("walk", *words, "--out", str(folder))[0] == 1
    return folder


def test_the_page_says_what_was_asked_what_came_and_how_to_do_it_again(fallen: Path, tmp_path: Path) -> None:
    code, out, _ = run("report", str(fallen), "--out", str(tmp_path / "page.html"), "--json")
    text = (tmp_path / "page.html").read_text()
    assert code == 0
    assert json.loads(out)["fell"] is True
    told = ("Fell at", "Most likely begun by", "Faults and fallbacks", "mujoco", "seed 0")
    for words in (*told, "150.0", "duration = 3.0", "gaitsmith walk"):
        assert words in text
    assert text.count("data:image/svg+xml") >= 8


def test_figures_by_name_and_a_name_that_is_none(fallen: Path, tmp_path: Path) -> None:
    code, _, _ = run("plot", str(fallen), "--what", "fall", "--out", str(tmp_path / "new"))
    assert code == 0
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == ["fall.png", "fall.svg"]
    code, _, said = run("plot", str(fallen), "--what", "timing")
    assert code == 2
    assert "--what" in said
    assert "fall" in said


def test_a_run_without_a_summary_is_summed_up_from_its_log(fallen: Path, tmp_path: Path) -> None:
    killed = tmp_path / "killed"
    shutil.copytree(fallen, killed)
    (killed / "summary.json").unlink()
    found = open_run(killed)
    fall = open_run(fallen).summary.fall
    assert fall is not None
    assert found.summary.duration == pytest.approx(fall.time, abs=0.02)  # the tick of the fall itself may be no row
    assert found.summary.pushes == pytest.approx((0.8,), abs=0.01)
    assert any("no summary" in note for note in found.notes)


@pytest.mark.parametrize(("name", "content"), [("summary.json", '{"newer": 1}'), ("summary.json", "{")])
def test_a_summary_of_another_version_is_refused_in_a_line(
    fallen: Path, tmp_path: Path, name: str, content: str
) -> None:
    other = tmp_path / "other"
    shutil.copytree(fallen, other)
    (other / name).write_text(content)
    code, _, said = run("report", str(other))
    assert code == 2
    assert "summary.json" in said
    assert len(said.strip().splitlines()) == 1


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"log\.mcap"):
        open_run(tmp_path)


def test_positions_of_the_log_put_the_soles_where_they_truly_were(fallen: Path) -> None:
    import mujoco

    found = open_run(fallen)
    data = mujoco.MjData(found.robot.model)
    for row in (10, 150):
        data.qpos[:] = video.positions(found.log, found.robot)[row]
        mujoco.mj_kinematics(found.robot.model, data)
        for leg in found.robot.legs:
            true = [found.log.column(f"true.{leg.name}_sole_{axis}")[row] for axis in "xyz"]
            np.testing.assert_allclose(data.site(leg.sole_site).xpos, true, atol=1e-6)


def test_a_film_is_written_or_one_line_says_why_not(fallen: Path, tmp_path: Path) -> None:
    path = tmp_path / "fast.mp4"
    code, _, said = run("video", str(fallen), "--rate", "4", "--out", str(path))
    assert (code == 0 and path.read_bytes()[4:8] == b"ftyp") or (code == 2 and "no renderer" in said)
    assert [entry.name for entry in tmp_path.iterdir()] == ([path.name] if code == 0 else [])


def test_without_renderer_or_library_there_is_one_line(
    fallen: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rendering, "_PLATFORMS", ("absent",))
    code, _, said = run("video", str(fallen), "--out", str(tmp_path / "a.mp4"))
    assert code == 2
    assert "no renderer" in said
    monkeypatch.setattr(video, "import_module", lambda name: __import__("absent"))
    code, _, said = run("video", str(fallen), "--out", str(tmp_path / "a.mp4"))
    assert code == 2
    assert "gaitsmith[video]" in said
    assert not list(tmp_path.iterdir())


def test_the_demo_runs_draws_and_says_what_to_type_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a short profile and without plans, which have their own tests; no renderer, which costs only pictures."""
    monkeypatch.setattr(demo, "load_scenario", lambda _: Scenario(speed=(0.1, 0.0), duration=1.0, rest_before=0.1))
    monkeypatch.setattr(demo, "PLANNED", ())
    monkeypatch.setattr(demo, "_plans", lambda *_: {})

    def refuse(*_: object) -> bytes:
        raise NoRenderer("no renderer")

    monkeypatch.setattr(demo, "strip", refuse)
    heard: list[str] = []
    found = demo.run_demo(tmp_path, lambda what, *_: heard.append(what))
    text = found.page.read_text()
    assert SimpleNamespace(**found.planned) == SimpleNamespace()
    assert "Upright to the end" in text
    assert "No pictures: no renderer" in text
    assert "gaitsmith adopt" in text
    assert heard[0].startswith("walking the speed profile")
