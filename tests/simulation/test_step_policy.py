"""Laws of policies that set gait inputs once a step, and of their files."""

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest

from gaitsmith import Controller, Scenario, load_robot, run_episode
from gaitsmith.errors import BadInput
from gaitsmith.learning import Perceptron, write_policy
from gaitsmith.simulation.step_policy import OnnxPolicy, PolicyCard, StepView, adjustable, told

HIDDEN = 3


def a_policy(name: str = "bhr_b2", ranges: dict[str, tuple[float, float]] | None = None) -> Perceptron:
    robot = load_robot(name)
    adjusted = adjustable(("period", "lift"), robot.card.gait_limits, ranges or {})
    seen = StepView(Controller(robot), adjusted).names
    card = PolicyCard(joints=tuple(robot.joint_names), seen=seen, adjusted=adjusted)
    numbers = np.random.default_rng(1).normal(0.0, 0.4, Perceptron.size(card, HIDDEN))
    return Perceptron.of(card, HIDDEN, numbers)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("policy") / "policy.onnx"
    write_policy(path, a_policy(ranges={"period": (0.3, 0.4), "lift": (0.08, 0.12)}))
    return path


def test_a_file_acts_as_what_was_written(file: Path) -> None:
    policy, read = a_policy(ranges={"period": (0.3, 0.4), "lift": (0.08, 0.12)}), OnnxPolicy(file, load_robot("bhr_b2"))
    assert read.card == policy.card
    for seed in range(20):
        seen = np.random.default_rng(seed).uniform(-2.0, 2.0, len(policy.card.seen))
        assert read.act(seen) == pytest.approx(policy.act(seen), abs=1e-5)


def test_a_walk_takes_its_period_from_the_policy(file: Path) -> None:
    scenario = Scenario(speed=(0.3, 0.0), duration=3.0, policy=str(file))
    episode = run_episode(scenario)
    assert not episode.summary.fell
    assert episode.log is not None
    period = episode.log.column("command.period")
    assert len(np.unique(np.round(period, 6))) >= 4
    later = period[episode.log.time > 2.0]
    assert later.min() >= 0.3
    assert later.max() <= 0.4
    again = run_episode(scenario).summary
    assert again.stages == episode.summary.stages


def test_adjustments_stay_in_their_range() -> None:
    adjusted = a_policy().card.adjusted
    for action in ([-1.0, 1.0], [5.0, -7.0], [0.3, 0.2]):
        values = told(adjusted, np.array(action))
        assert all(entry.low <= values[entry.name] <= entry.high for entry in adjusted)
    with pytest.raises(BadInput):
        told(adjusted, np.array([np.nan, 0.0]))


def test_a_policy_of_another_robot_is_refused(file: Path) -> None:
    with pytest.raises(BadInput, match=r"policy.onnx: joints"):
        OnnxPolicy(file, load_robot("thbip_ii"))


def refused(policy: Perceptron, path: Path, change: dict[str, object]) -> str:
    write_policy(path, dataclasses.replace(policy, card=policy.card.model_copy(update=change)))
    with pytest.raises(BadInput) as caught:
        OnnxPolicy(path, load_robot("bhr_b2"))
    return caught.value.field


def test_a_card_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    policy, path = a_policy(), tmp_path / "p.onnx"
    seen, adjusted = policy.card.seen, policy.card.adjusted
    assert refused(policy, path, {"seen": seen[:-1]}) == "p.onnx"  # its graph takes another count
    assert refused(policy, path, {"seen": (seen[1], seen[0], *seen[2:])}) == "p.onnx: seen"
    assert refused(policy, path, {"seen": (*seen[:-1], "secret")}) == "p.onnx: seen"
    wide = (adjusted[0].model_copy(update={"low": 0.01}), adjusted[1])
    assert refused(policy, path, {"adjusted": wide}) == "p.onnx: adjusted period"
    speed = (adjusted[0].model_copy(update={"name": "speed"}), adjusted[1])
    assert refused(policy, path, {"adjusted": speed}) == "p.onnx: adjusted"


def test_a_policy_that_gives_no_numbers_is_refused_before_a_walk(tmp_path: Path) -> None:
    card = a_policy().card
    nothing = Perceptron.of(card, HIDDEN, np.full(Perceptron.size(card, HIDDEN), np.nan))
    assert refused(nothing, tmp_path / "p.onnx", {}) == "policy"


def test_what_is_no_policy_is_refused(file: Path, tmp_path: Path) -> None:
    robot = load_robot("bhr_b2")
    content = file.read_bytes()
    for name, damaged in [("junk", b"\x00" * 300), ("cut", content[: len(content) // 2]), ("empty", b"")]:
        path = tmp_path / f"{name}.onnx"
        path.write_bytes(damaged)
        with pytest.raises(BadInput):
            OnnxPolicy(path, robot)
    shutil.copy(file, tmp_path / "bare.onnx")
    (tmp_path / "bare.onnx").write_bytes(content.replace(b"gaitsmith.policy", b"somebody.policy."))
    with pytest.raises(BadInput, match=r"metadata gaitsmith\.policy"):
        OnnxPolicy(tmp_path / "bare.onnx", robot)


def test_a_gait_file_has_no_policy() -> None:
    with pytest.raises(BadInput, match="policy"):
        Scenario(gait=("a.json",), policy="b.onnx")
