"""A controller behind a socket does what it would do here; one that stops, or talks nonsense, ends in braked joints."""

from __future__ import annotations

import json
import socket
import socketserver
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread

import pytest
from tests.simulation.standing import robot

from gaitsmith.cli import main
from gaitsmith.control import Controller
from gaitsmith.errors import BadInput
from gaitsmith.experiments.episodes import episode_key
from gaitsmith.robots.parameters import GaitParameters
from gaitsmith.simulation import remote
from gaitsmith.simulation.episode import run_episode
from gaitsmith.simulation.replay import why
from gaitsmith.simulation.scenario import make_scenario
from gaitsmith.simulation.serving import Server

PUSH = {"time": 1.3, "phase": 0.25, "impulse": [12.0, 5.0, 0.0]}


@contextmanager
def served(make, name="tested", version="1"):
    """A server in a thread, gone at the end whatever happens; yields ``socket:PORT``."""
    server = Server(make, name, version)
    thread = Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    try:
        yield f"socket:{server.server_address[1]}"
    finally:
        server.shutdown()
        server.server_close()
        thread.join(5.0)


def ours(greeting):
    """The package's own controller, as a stranger would ask it."""
    controller = Controller(robot(), state=greeting["state"], gait=GaitParameters(**greeting["gait"]))

    def answer(message):
        if message["walk"] and controller.state not in ("walking",):
            controller.walk()
        controller.command(**message["command"])
        for name in controller.measurement._fields:
            getattr(controller.measurement, name)[:] = message[name]
        torque, told = controller.tick(), controller.telemetry
        step = (told.step_count, told.stance, told.step_time, told.step_duration)
        return {"torque": torque.tolist(), "step": [float(view[0]) for view in step]}

    return answer


@pytest.fixture(autouse=True)
def _patient(monkeypatch):
    """A busy machine is no silent controller."""
    monkeypatch.setattr(remote, "PATIENCE", 20.0)


def test_our_own_controller_through_the_socket_walks_alike_to_the_last_bit():
    fields = {"speed": 0.3, "duration": 2.5, "pushes": [PUSH], "changes": [{"time": 2.0, "speed": 0.1}]}
    here = run_episode(make_scenario(fields), robot=robot(), record=False).summary
    with served(ours) as address:
        there = run_episode(make_scenario({**fields, "controller": address}), robot=robot(), record=False).summary
    for name in ("fell", "steps", "distance", "drift", "yaw_deg", "torque_peak", "pushes", "step_time", "recovered"):
        assert getattr(there, name) == getattr(here, name), name
    assert there.steps > 3


def _fails(answer):
    """Summary of a walk whose controller gives its 300th answer in another way."""

    def make(greeting):
        good, count = ours(greeting), iter(range(10_000))
        return lambda message: answer(good(message)) if next(count) >= 300 else good(message)

    with served(make) as address:
        scenario = make_scenario({"duration": 4.0, "controller": address})
        return run_episode(scenario, robot=robot(), record=False).summary


def test_one_that_stops_answering_is_named_and_the_joints_are_braked(monkeypatch):
    monkeypatch.setattr(remote, "PATIENCE", 1.0)
    over = Event()
    try:
        summary = _fails(lambda good: over.wait(20.0) or good)
    finally:
        over.set()
    (reaction,) = [entry for entry in summary.faults if entry.component == "controller"]
    assert reaction.type == "did not answer within 1 s"
    assert (reaction.time, reaction.reaction) == (pytest.approx(0.3, abs=2e-3), "joints braked")
    assert summary.fell
    assert summary.fall.cause.what == "the controller did not answer within 1 s"
    assert all(
        abs(peak) <= limit + 1e-9
        for peak, limit in zip(summary.torque_peak.values(), robot().torque_limit, strict=True)
    )


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"torque": [1.0]}, "answered without 8 finite torques"),
        ({"torque": ["1"] * 8}, "answered without 8 finite torques"),
        ({"torque": [1e999] * 8}, "answered without 8 finite torques"),
        ({"torque": [10**400] * 8}, "answered without 8 finite torques"),
        ({"step": [0.0]}, "answered without a step of 4 finite numbers"),
        ({"step": [3, -7, 0.1, 0.4]}, "answered with a step that is none"),
        ({"step": [3.5, 0, 0.1, 0.4]}, "answered with a step that is none"),
    ],
)
def test_nonsense_is_named(change, said):
    summary = _fails(lambda good: {**good, **change})
    assert [entry.type for entry in summary.faults if entry.component == "controller"] == [said]


def test_one_that_cannot_begin_is_one_line_before_the_run():
    for make, name in ((ours, ""), (lambda _: lambda _: {"torque": []}, "tested")):
        with served(make, name) as address, pytest.raises(BadInput) as caught:
            run_episode(make_scenario({"controller": address}), robot=robot(), record=False)
        assert (caught.value.field, caught.value.value) == ("controller", address)


def test_an_answer_that_drips_is_late():
    over = Event()

    def drip(listening):
        end, _ = listening.accept()
        with end:
            while not over.wait(0.02):
                end.sendall(b" ")

    with socket.create_server((remote.HOST, 0)) as listening:
        listening.settimeout(5.0)
        thread = Thread(target=drip, args=(listening,), daemon=True)
        thread.start()
        try:
            with pytest.raises(remote._Failed, match=r"did not answer within 0\.2 s"):
                remote.Line(listening.getsockname()[1]).ask({}, 0.2)
        finally:
            over.set()
            thread.join(5.0)


def test_torques_stay_within_their_limits():
    summary = _fails(lambda good: {**good, "torque": [1e6] * 8})
    assert max(summary.torque_peak.values()) <= max(robot().torque_limit)


def test_who_answers_is_part_of_the_key_and_where_is_not():
    keys = []
    for version in ("1", "1", "2"):
        with served(ours, version=version) as address:
            keys.append(episode_key("loop", make_scenario({"controller": address})))
    assert keys[0] == keys[1] != keys[2]


def test_where_nobody_listens_is_one_line():
    with socket.socket() as taken:
        taken.bind((remote.HOST, 0))
        address = f"socket:{taken.getsockname()[1]}"
        with pytest.raises(BadInput) as caught:
            run_episode(make_scenario({"controller": address}), robot=robot(), record=False)
    assert (caught.value.field, caught.value.value) == ("controller", address)


def test_a_server_that_is_none_of_ours_is_one_line():
    with served(ours, name="") as address, pytest.raises(BadInput, match="name and version"):
        remote.identity_of(address)


@pytest.mark.parametrize("field", ["gait", "library", "policy"])
def test_it_cannot_be_combined_and_its_falls_are_not_replayed(field):
    value = ["x.json"] if field == "gait" else "x"
    with pytest.raises(BadInput, match=field):
        make_scenario({"controller": "socket:5000", field: value})
    with pytest.raises(BadInput, match="controller"):
        why(make_scenario({"controller": "socket:5000"}), robot=robot())
    with pytest.raises(BadInput, match="controller"):
        make_scenario({"controller": json.dumps({"host": "elsewhere"})})


def test_what_the_crash_page_shows_answers_and_its_fall_is_not_said_to_be_replayed(monkeypatch, tmp_path, capsys):
    page = (Path(__file__).resolve().parents[2] / "docs" / "crash.md").read_text()
    code = page.split("```python\n")[1].split("```")[0].replace("port=5740", "port=0")
    words = ["walk", "--duration", "3", "--no-figures", "--out", str(tmp_path / "run"), "--controller"]

    def walks(server):
        """Instead of serving for ever."""
        thread = Thread(target=socketserver.TCPServer.serve_forever, args=(server, 0.05), daemon=True)
        thread.start()
        try:
            assert main([*words, f"socket:{server.server_address[1]}"]) == 1
        finally:
            server.shutdown()
            server.server_close()
            thread.join(5.0)

    monkeypatch.setattr(Server, "serve_forever", walks)
    exec(compile(code, "crash.md", "exec"), {})
    told = capsys.readouterr().out
    assert "likeliest cause: " in told
    assert "gaitsmith why" not in told
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["faults"] == []
