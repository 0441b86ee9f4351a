"""Every numbered example runs, does what its first line says, and says something."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SHORT: dict[str, dict[str, Any]] = {
    "01_walk": {"duration": 3.0},
    "02_change_gait": {"duration": 8.0},
    "03_push": {"impulses": (10.0, 150.0)},
    "04_own_loop": {"duration": 2.0},
    "05_own_robot": {"duration": 3.0},
    "06_own_gains": {"duration": 2.5},
    "07_plan": {"steps": 4},
    "08_own_motion": {},
    "09_train_policy": {"generations": 1, "population": 2, "episodes": 1, "held_out": 1},
    "10_tune_with_optuna": {"trials": 2, "runs": 1, "held_out": 1},
}


def load(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"example_{name}", EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_every_example_is_listed() -> None:
    assert sorted(path.stem for path in EXAMPLES.glob("*.py")) == sorted(SHORT)


@pytest.mark.parametrize("name", sorted(SHORT))
def test_an_example_runs(
    name: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = load(name).main(**SHORT[name])
    assert len(capsys.readouterr().out.splitlines()) >= 2
    if name in ("01_walk", "02_change_gait", "05_own_robot"):
        assert not result.summary.fell
    if name == "03_push":
        assert [episode.summary.fell for episode in result] == [False, True]
