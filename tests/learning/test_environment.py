"""Laws of the Gymnasium environment."""

import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from gaitsmith.errors import BadInput
from gaitsmith.learning import ENVIRONMENT, GaitTemplateEnv, register
from gaitsmith.simulation import Scenario, run_episode

SHORT = {"speed": (0.3, 0.0), "duration": 2.5}


@pytest.fixture(scope="module")
def environment() -> GaitTemplateEnv:
    return GaitTemplateEnv("bhr_b2", scenario=SHORT)


def present(environment: GaitTemplateEnv, seen: np.ndarray) -> np.ndarray:
    """The action that keeps the gait."""
    return seen[[environment.seen.index(f"present.{entry.name}") for entry in environment.card.adjusted]]


def walked(environment: GaitTemplateEnv, seed: int, action: Any = None) -> tuple[list[np.ndarray], list[float], bool]:
    seen, _ = environment.reset(seed=seed)
    rows, rewards, fell, over = [seen], [], False, False
    while not (fell or over):
        seen, reward, fell, over, _ = environment.step(present(environment, seen) if action is None else action)
        rows.append(seen)
        rewards.append(reward)
    return rows, rewards, fell


def test_gymnasium_finds_it_and_has_nothing_to_say() -> None:
    register()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = gymnasium.make(ENVIRONMENT, robot="bhr_b2", scenario=SHORT)
        check_env(made.unwrapped)


def test_an_action_that_keeps_the_gait_changes_nothing(environment: GaitTemplateEnv) -> None:
    rows, _, fell = walked(environment, 3)
    summary = run_episode(Scenario(**SHORT), record=False).summary
    walk = environment._simulation.summary()
    assert not fell
    assert len(rows) >= 4
    assert walk.stages[-1].vx_mean == pytest.approx(summary.stages[-1].vx_mean, abs=1e-6)
    assert environment._simulation.controller.gait.period == pytest.approx(0.4, abs=1e-9)


def test_rewards_are_the_time_walked_at_the_commanded_speed(environment: GaitTemplateEnv) -> None:
    _, rewards, fell = walked(environment, 0)
    assert not fell
    assert 0.0 < sum(rewards) <= SHORT["duration"]  # type: ignore[operator]
    assert all(0.0 <= reward <= 0.8 for reward in rewards)


def test_a_fall_ends_the_episode_and_costs_one() -> None:
    pushed = {**SHORT, "duration": 6.0, "pushes": [{"time": 2.0, "impulse": [0.0, 200.0, 0.0]}]}
    environment = GaitTemplateEnv("bhr_b2", scenario=pushed)
    _, rewards, fell = walked(environment, 0)
    assert fell
    assert rewards[-1] < 0.0


def test_the_same_seed_gives_the_same_ground_and_walk() -> None:
    environment = GaitTemplateEnv("bhr_b2", scenario={**SHORT, "terrain": "boxes:0.05"}, vary={"friction": (0.5, 1.0)})
    first, again, other = (walked(environment, seed)[0] for seed in (5, 5, 6))
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert len(first) != len(other) or not np.array_equal(first[-1], other[-1])


def test_an_action_takes_effect_at_the_next_step(environment: GaitTemplateEnv) -> None:
    seen, _ = environment.reset(seed=0)
    action = present(environment, seen).copy()
    action[0] = -0.6  # of the period's range
    controller = environment._simulation.controller
    at = controller.telemetry_columns.index("command.period")
    assert controller.telemetry_buffer[at] == pytest.approx(0.4)
    environment.step(action)
    assert controller.telemetry_buffer[at] == pytest.approx(controller.gait.period)
    low, high = environment.card.adjusted[0].low, environment.card.adjusted[0].high
    assert controller.gait.period == pytest.approx(low + 0.2 * (high - low))


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"adjust": ("speed",)}, "adjust"),
        ({"adjust": ()}, "adjust"),
        ({"ranges": {"period": (0.1, 0.4)}}, "adjust period"),
        ({"vary": {"friction": (1.0, 0.5)}}, "vary[friction]"),
        ({"scenario": {"duration": -1.0}}, "duration"),
    ],
)
def test_what_does_not_fit_is_refused(options: dict[str, Any], field: str) -> None:
    with pytest.raises(BadInput) as caught:
        GaitTemplateEnv("bhr_b2", **options)
    assert caught.value.field == field


def test_an_action_that_is_no_number_is_refused(environment: GaitTemplateEnv) -> None:
    environment.reset(seed=0)
    for action in (np.full(4, np.nan), np.zeros(3)):
        with pytest.raises(BadInput):
            environment.step(action)
