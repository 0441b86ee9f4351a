"""Figures of a made-up walk: they say what the recording says, and need no display."""

import copy
import struct
from pathlib import Path
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.log import Log
from gaitsmith.robots.sole import Sole
from gaitsmith.simulation import Scenario
from gaitsmith.view import (
    FIGURES,
    Recording,
    draw_footprints,
    draw_speed,
    draw_timing,
    draw_torques,
    save,
    suitable,
    write_figures,
)
from gaitsmith.view.fall import _rows, draw_fall
from gaitsmith.view.landings import landings
from gaitsmith.view.recording import _UNUSUAL, FaultMark, _conditions

PERIOD, WIDTH = 0.4, 0.0375
PIXELS_WIDE = 1600
TOLD = np.array([0.02, -0.01])  # m: by how much the made-up feet miss


def made_up_walk(seconds: float = 12.0, rate: float = 500.0, samples: int | None = None) -> Recording:
    """A walk that speeds up and slows down; nothing falls because nothing is simulated."""
    rng = np.random.default_rng(1)
    time = np.arange(0.0, seconds, 1.0 / rate)
    n = len(time)
    stage = np.minimum(np.floor(time / 2.0), 5)
    command = np.column_stack([0.1 * np.minimum(stage, 5 - stage), np.zeros(n)])
    step = np.floor(time / PERIOD)
    phase = time / PERIOD - step
    stance = np.where(time < 1.0, 2.0, step % 2)
    torso = np.column_stack([np.cumsum(command[:, 0]) / rate, 0.01 * np.sin(np.pi * time / PERIOD)])
    soles, feet = np.zeros((n, 6)), np.zeros((n, 6))
    for side in (0, 1):
        lateral = WIDTH if side == 0 else -WIDTH
        swing = stance == 1 - side
        ahead = np.where(swing, phase - 0.5, 0.5 - phase) * PERIOD * command[:, 0]
        lift = np.where(swing, 0.1 * np.sin(np.pi * phase), 0.0)
        feet[:, 3 * side : 3 * side + 3] = np.column_stack([ahead, np.full(n, lateral), lift - 0.7])
        soles[:, 3 * side : 3 * side + 2] = torso + feet[:, 3 * side : 3 * side + 2]
        soles[:, 3 * side + 2] = lift
    swings = np.sin(2 * np.pi * np.outer(time, np.ones(8)) / (2 * PERIOD) + np.tile([0.0, 0.5, 1.0, 1.5], 2))
    joints = tuple(f"{side}_{name}" for side in ("left", "right") for name in ("hip", "femur", "knee", "ankle"))
    speed = command + 0.03 * rng.standard_normal((n, 2)) + 0.05 * np.sin(2 * np.pi * time / PERIOD)[:, None]
    height = 0.7 + 0.004 * np.sin(2 * np.pi * time / PERIOD)
    ends = [f"{side}.{axis}" for side in ("left", "right") for axis in "xyz"]
    blocks: dict[tuple[str, ...], np.ndarray] = {
        ("time", "mode", "stance", "command.height"): np.column_stack([time, time >= 0.0, stance, np.full(n, 0.7)]),
        ("command.speed_x", "command.speed_y"): command,
        ("true.com_velocity_x", "true.com_velocity_y"): speed,
        ("true.torso_roll", "true.torso_pitch"): np.radians(0.3 * rng.standard_normal((n, 2))),
        ("true.torso_yaw",): 0.01 * np.sin(time)[:, None],
        ("true.hip_height_left", "true.hip_height_right"): np.column_stack([height, height]),
        tuple(f"joint_desired.{name}" for name in joints): 0.4 * swings,
        tuple(f"joint_position.{name}" for name in joints): 0.4 * swings + 0.01,
        tuple(f"torque.{name}" for name in joints): 40.0 * swings,
        tuple(f"foot_desired.{end}" for end in ends): feet,
        tuple(f"foot_actual.{end}" for end in ends): feet + 0.003,
        tuple(f"true.{end.replace('.', '_sole_')}" for end in ends): soles,
        ("true.torso_x", "true.torso_y"): torso,
        ("foothold.x", "foothold.y"): np.where((stance == 0)[:, None], feet[:, 3:5], feet[:, :2]) + TOLD,
        ("foothold_bound", "qp_fallbacks", "true.leg_contact", "true.body_contact"): np.zeros((n, 4)),
        ("true.left_force", "true.right_force"): 400.0 * np.column_stack([stance != 1, stance != 0]),
        ("zmp.left.x", "zmp.left.y", "zmp.right.x", "zmp.right.y"): np.tile([0.02, 0.0, 0.02, 0.0], (n, 1)),
    }
    notes = {
        "gait": {"period": PERIOD, "height": 0.7},
        "scenario": {"state": "true", "seed": 7, "pushes": [{"impulse": [0.0, 30.0, 0.0]}]},
    }
    events = ({"time": 9.0, "push": 0, "over": False}, {"time": 9.1, "push": 0, "over": True})
    rows = np.column_stack(list(blocks.values()))[:samples]
    log = Log(tuple(name for names in blocks for name in names), rows, notes=notes, events=events)
    durations = (np.geomspace(10.0, 100.0, 50), rng.integers(1, 1000, 50))
    robot = SimpleNamespace(
        card=SimpleNamespace(name="made up"),
        joint_names=joints,
        torque_limit=np.array([100.0, 150.0, 200.0, 80.0] * 2),
        legs=[
            SimpleNamespace(
                name=side,
                joints=joints[4 * k : 4 * k + 4],
                joint_indices=np.arange(4 * k, 4 * k + 4),
                sole=Sole(kind="line", heel=0.08, toe=0.14),
            )
            for k, side in enumerate(("left", "right"))
        ],
    )
    return Recording(log, robot, durations, seconds)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def walk() -> Recording:
    return made_up_walk()


def test_every_figure_is_a_png_of_full_width(walk: Recording, tmp_path: Path) -> None:
    paths = write_figures(walk, tmp_path)
    assert [path.name for path in paths] == [f"{name}.png" for name in FIGURES]
    for path in paths:
        head = path.read_bytes()[:24]
        assert head[:8] == b"\x89PNG\r\n\x1a\n"
        assert struct.unpack(">I", head[16:20])[0] == PIXELS_WIDE


def test_names_are_text_never_markup(walk: Recording, tmp_path: Path) -> None:
    """A joint that would be wrong as a formula is drawn as it is written."""
    marked = copy.copy(walk)
    marked.robot = copy.copy(walk.robot)
    marked.robot.joint_names = ("$\\frac$", *walk.robot.joint_names[1:])  # type: ignore[misc]
    made = draw_torques(marked)
    save(made, tmp_path / "torques.png")
    assert any("$\\frac$" in axes.get_title(loc="left") for axes in made.axes)


def test_a_users_own_style_changes_no_figure(walk: Recording) -> None:
    own = draw_speed(walk)
    with mpl.rc_context({"axes.facecolor": "black", "axes.labelsize": 40.0}):
        styled = draw_speed(walk)
    for one, other in zip(own.axes, styled.axes, strict=True):
        assert one.get_facecolor() == other.get_facecolor()
        assert one.yaxis.label.get_size() == other.yaxis.label.get_size()


def test_stages_are_where_the_command_changes(walk: Recording) -> None:
    stages = walk.stages()
    assert [round(stage.speed_x, 3) for stage in stages] == [0.0, 0.1, 0.2, 0.1, 0.0]
    assert [round(stage.begin, 3) for stage in stages] == [0.0, 2.0, 4.0, 8.0, 10.0]


def test_window_is_the_end_of_the_fastest_stage(walk: Recording) -> None:
    times = walk.time[walk.window(1.5)]
    assert times[0] == pytest.approx(6.5)
    assert times[-1] == pytest.approx(8.0, abs=0.01)


def test_curves_are_the_recording(walk: Recording) -> None:
    forward = draw_speed(walk).axes[0]
    curves = {line.get_label(): line for line in forward.get_lines()}
    x, y = (np.asarray(values, dtype=float) for values in curves["commanded"].get_data())
    assert np.array_equal(y, np.interp(x, walk.time, walk.speed_command[:, 0]))


def test_torque_titles_name_the_limit(walk: Recording) -> None:
    titles = [axis.get_title(loc="left") for axis in draw_torques(walk).axes]
    assert "left_knee, right_knee   limit 200 N·m" in titles


def test_a_recording_of_two_samples_is_drawn(tmp_path: Path) -> None:
    assert len(write_figures(made_up_walk(samples=2), tmp_path)) == len(FIGURES) - 1  # no landing


def test_timing_is_drawn_only_if_durations_are_known(walk: Recording, tmp_path: Path) -> None:
    unknown = copy.copy(walk)
    unknown.tick_us, unknown.tick_counts = np.zeros(0), np.zeros(0, dtype=np.int64)
    unknown.fell = None
    assert set(suitable(unknown)) == set(FIGURES) - {"timing", "fall"}


def test_the_vector_file_beside_says_in_text_what_was_run(walk: Recording, tmp_path: Path) -> None:
    save(draw_speed(walk), tmp_path / "speed.png")
    text = (tmp_path / "speed.svg").read_text()
    for words in ("T 0.4 s, H 0.7 m, true state, seed 7", "push 30 N·s", "fell", "m/s"):
        assert words in text
    save(draw_speed(walk), tmp_path / "again.png")
    assert text == (tmp_path / "again.svg").read_text()


def test_landings_are_missed_by_what_the_walk_was_made_up_with(walk: Recording) -> None:
    found = landings(walk)
    assert len(found) == pytest.approx(11.0 / PERIOD, abs=2)
    for item in found:
        np.testing.assert_allclose(item.error, TOLD - 0.003 * np.ones(2), atol=1e-12)
        assert np.linalg.norm(item.told - item.came) == pytest.approx(np.hypot(*item.error), abs=0.02)


def test_a_fall_s_figure_has_what_slipped_and_what_failed(walk: Recording) -> None:
    slipped = copy.copy(walk)
    slipped.sole_position = walk.sole_position.copy()
    late = (walk.time > 11.0) & (walk.sole_force[:, 0] > 0.0)
    slipped.sole_position[late, 0] += 0.5 * np.cumsum(late)[late] * (walk.time[1] - walk.time[0])  # 0.5 m/s
    slipped.faults = (FaultMark(11.2, 11.4, "gyro nan"),)
    rows, before = ({name: flags for name, flags, _ in _rows(of)} for of in (slipped, walk))
    assert rows["left sole slips"][late].all()
    assert before["left sole slips"][late].mean() < 0.1  # made-up feet jump where steps begin
    made = draw_fall(slipped)
    assert {"left sole slips", "gyro nan"} <= {name.get_text() for axis in made.axes for name in axis.get_yticklabels()}
    assert "gyro nan" in [text.get_text() for text in made.axes[0].texts]


def test_what_is_unusual_is_told_and_what_is_usual_is_not() -> None:
    usual = Scenario().model_dump(mode="json")
    assert all(usual[name] == default for name, default, _ in _UNUSUAL)
    told = _conditions({"scenario": usual | {"friction": 0.12, "mass_spread": 0.1}})
    assert "friction 0.12, masses within 10%" in told
    assert "masses" not in _conditions({"scenario": usual})


def test_a_straight_walk_is_written_in_rows_to_scale() -> None:
    walk = made_up_walk()
    walk.height_command = walk.height_command / 3.0  # a small robot, which has gone far
    made = draw_footprints(walk)
    assert len(made.axes) > 1
    assert all(axis.get_aspect() == 1.0 for axis in made.axes)


def test_a_folder_that_is_not_there_is_refused(walk: Recording, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="a folder that can be written"):
        write_figures(walk, tmp_path / "absent")


def test_no_label_of_the_timing_is_markup(walk: Recording) -> None:
    made = draw_timing(walk)
    made.canvas.draw()
    labels = [label.get_text() for axis in made.axes for label in (*axis.get_xticklabels(), *axis.get_yticklabels())]
    assert any(labels)
    assert not any("$" in label or "\\" in label for label in labels)
