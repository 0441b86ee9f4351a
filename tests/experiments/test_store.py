"""What is finished survives a crash, and is found again only if nothing that matters has changed."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.experiments.made_up import made_up_summary
from tests.simulation.standing import robot

from gaitsmith.errors import BadInput
from gaitsmith.experiments import episodes
from gaitsmith.experiments.store import FILE, Store
from gaitsmith.simulation.scenario import make_scenario

SCENARIO = make_scenario({"duration": 3.0})


def _two_finished(folder):
    store = Store(folder)
    store.add("first", SCENARIO, made_up_summary(steps=1))
    store.add("second", SCENARIO, made_up_summary(steps=2))
    return (folder / FILE).read_bytes()


def test_finished_episodes_are_found_again(tmp_path):
    _two_finished(tmp_path / "new" / "folder")
    again = Store(tmp_path / "new" / "folder")
    assert again.get("first") == made_up_summary(steps=1)
    assert again.get("second") == made_up_summary(steps=2)
    assert again.get("third") is None
    assert (len(again), again.damaged) == (2, 0)


def test_a_crash_anywhere_in_the_last_line_costs_that_line_only(tmp_path):
    content = _two_finished(tmp_path)
    last = content.index(b"\n") + 1
    for end in range(last, len(content), 97):
        (tmp_path / FILE).write_bytes(content[:end])
        store = Store(tmp_path)
        assert store.get("first") == made_up_summary(steps=1)
        assert store.get("second") is None
        store.add("third", SCENARIO, made_up_summary(steps=3))
        again = Store(tmp_path)
        assert (len(again), again.get("third")) == (2, made_up_summary(steps=3))
        assert again.damaged == (1 if end > last else 0)


def test_a_line_that_lost_only_its_end_still_counts(tmp_path):
    (tmp_path / FILE).write_bytes(_two_finished(tmp_path).rstrip(b"\n"))
    store = Store(tmp_path)
    store.add("third", SCENARIO, made_up_summary())
    assert (len(Store(tmp_path)), Store(tmp_path).damaged) == (3, 0)


@settings(max_examples=60)
@given(st.binary(max_size=200))
def test_rubbish_is_passed_over(tmp_path_factory, rubbish):
    folder = tmp_path_factory.mktemp("rubbish")
    content = _two_finished(folder)
    (folder / FILE).write_bytes(rubbish + b"\n" + content)
    assert Store(folder).get("second") == made_up_summary(steps=2)


@pytest.mark.parametrize(
    "line", ["[]", "3", "{}", '{"key": "a"}', '{"key": "a", "summary": {"fell": true}}', "[" * 9999]
)
def test_a_line_of_another_kind_is_counted_as_damaged(tmp_path, line):
    (tmp_path / FILE).write_text(line + "\n")
    store = Store(tmp_path)
    assert (len(store), store.damaged) == (0, 1)


def test_a_partial_write_spoils_no_later_one(tmp_path, monkeypatch):
    store = Store(tmp_path)
    with monkeypatch.context() as patch:
        written = []
        from gaitsmith.experiments import store as module

        real = module.os.write
        patch.setattr(module.os, "write", lambda handle, line: written.append(1) or real(handle, line[:50]))
        with pytest.raises(BadInput, match="disk is full"):
            store.add("first", SCENARIO, made_up_summary())
    store.add("second", SCENARIO, made_up_summary())
    assert Store(tmp_path).get("second") is not None
    assert Store(tmp_path).get("first") is None


def test_a_file_in_the_folder_s_place_is_refused(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(BadInput, match="--out"):
        Store(tmp_path / "taken")


def test_a_folder_in_the_file_s_place_is_refused(tmp_path):
    (tmp_path / FILE).mkdir()
    with pytest.raises(BadInput):
        Store(tmp_path)


def test_a_key_depends_on_everything_but_the_robot_s_path():
    loop = episodes.loop_identity(robot())
    fields = {"duration": 3.0, "speed": [0.1, 0.0]}
    key = episodes.episode_key(loop, make_scenario(fields))
    assert key == episodes.episode_key(loop, make_scenario({**fields, "robot": "elsewhere/card.toml"}))
    changed = [{"duration": 3.5}, {"speed": [0.1, 0.1]}, {"seed": 1}, {"preset": "paper"}, {"terrain": "slope:1"}]
    changed += [{"changes": [{"time": 2.0, "lift": 0.05}]}, {"pushes": [{"time": 2.0, "impulse": [1.0, 0.0, 0.0]}]}]
    keys = {episodes.episode_key(loop, make_scenario({**fields, **change})) for change in changed}
    assert len(keys | {key}) == len(changed) + 1
    assert episodes.episode_key("other code", make_scenario(fields)) != key


def test_the_loop_s_identity_changes_with_the_robot_and_the_code(monkeypatch):
    class Other:
        content_hash = "another card"

    before = episodes.loop_identity(robot())
    assert episodes.loop_identity(Other()) != before
    monkeypatch.setattr(episodes, "source_key", lambda module: "another source")
    assert episodes.loop_identity(robot()) != before


def test_lines_are_json_with_the_scenario_for_people(tmp_path):
    lines = _two_finished(tmp_path).splitlines()
    record = json.loads(lines[0])
    assert record["scenario"]["duration"] == 3.0
    assert set(record) == {"key", "scenario", "summary"}
