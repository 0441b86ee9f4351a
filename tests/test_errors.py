"""Messages are one short line, whatever was given."""

from __future__ import annotations

import pickle

from hypothesis import given
from hypothesis import strategies as st

from gaitsmith.errors import BadInput

LONGEST = 400  # characters
WORDS = st.text() | st.text(min_size=300, max_size=300).map(lambda text: 9 * text)


@given(WORDS, WORDS | st.integers() | st.just(10**5000) | st.lists(st.floats()), WORDS, WORDS)
def test_a_message_is_one_short_line(field: str, value: object, valid: str, remedy: str) -> None:
    error = BadInput(field, value, valid, remedy)
    assert len(str(error)) <= LONGEST
    assert len(str(error).splitlines()) <= 1
    assert (error.field, error.value, error.valid, error.remedy) == (field, value, valid, remedy)


def test_both_ends_of_a_long_field_are_shown() -> None:
    told = str(BadInput("a" * 300 + ": duration", 3, "4"))
    assert told.startswith("aaa")
    assert ": duration: got 3, expected 4" in told


def test_an_error_may_be_named_anew() -> None:
    error = BadInput("duration", 3, "4", "wait")
    assert str(error.within("run.toml")) == "run.toml: duration: got 3, expected 4; wait"
    assert str(error.named("--duration")) == "--duration: got 3, expected 4; wait"
    assert error.within("").field == "duration"


def test_an_error_reaches_another_process_as_it_was():
    error = pickle.loads(pickle.dumps(BadInput("--speed", 3.0, "0 to 1", "slower")))
    assert (error.field, error.value, error.valid, error.remedy) == ("--speed", 3.0, "0 to 1", "slower")
    assert str(pickle.loads(pickle.dumps(BadInput("a", object, "b")))).startswith("a: got")
