"""MuJoCo's way of failing and warning, turned into ours: one line, and no log file in the working folder."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

import mujoco

from gaitsmith.errors import BadInput

HEARD_LIMIT = 20


@contextmanager
def engine_errors(entry: str, heard: list[str]) -> Iterator[None]:
    """Inside, MuJoCo's errors become :class:`BadInput`, and its warnings lines of a list instead of a log file.

    Args:
        entry: what errors begin with.
        heard: receives the warnings, each in one line, at most twenty.

    Raises:
        BadInput: MuJoCo refused the model; its own message is the remedy.
    """

    def hear(message: str) -> None:
        if len(heard) < HEARD_LIMIT:
            heard.append(f"MuJoCo warns: {_line(message)}")

    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(hear)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
    except (ValueError, TypeError, RuntimeError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        message = _line(error).removeprefix("XML ").removeprefix("Error: ")
        raise BadInput(entry, "a model that MuJoCo refuses", "a valid model", message) from None
    finally:
        mujoco.set_mju_user_warning(previous)
    for warning in caught:
        hear(str(warning.message))


def _line(message: object) -> str:
    return " ".join(str(message).split())
