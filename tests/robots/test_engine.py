from __future__ import annotations

import os
import warnings
from pathlib import Path

import mujoco
import pytest

from gaitsmith.errors import BadInput
from gaitsmith.robots.engine import HEARD_LIMIT, engine_errors


def test_errors_are_one_line() -> None:
    with pytest.raises(BadInput, match=r"model.xml: .*negative") as caught, engine_errors("model.xml", []):
        mujoco.MjSpec.from_string(
            '<mujoco><worldbody><body><geom size="1" mass="-1"/></body></worldbody></mujoco>'
        ).compile()
    assert "\n" not in str(caught.value)


def test_own_errors_pass() -> None:
    with pytest.raises(BadInput, match="mine"), engine_errors("model.xml", []):
        raise BadInput("mine", 1, "2")


def test_warnings_are_heard_and_logged_nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    heard: list[str] = []
    with engine_errors("model.xml", heard):
        mujoco.MjSpec.from_string('<mujoco><worldbody><geom size="nan"/></worldbody></mujoco>')
        warnings.warn("two\nlines", UserWarning, stacklevel=1)
    assert len(heard) == 2
    assert not any("\n" in line for line in heard)
    with engine_errors("model.xml", heard):
        for _ in range(2 * HEARD_LIMIT):
            warnings.warn("again", UserWarning, stacklevel=1)
    assert len(heard) == HEARD_LIMIT
    assert os.listdir(tmp_path) == []


def test_the_previous_listener_is_kept() -> None:
    def listener(message: str) -> None:
        """Another part of the program that listens."""

    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(listener)
    try:
        with engine_errors("model.xml", []):
            pass
        assert mujoco.get_mju_user_warning() is listener
    finally:
        mujoco.set_mju_user_warning(previous)
