"""Whatever is done to a model, adoption infers a card from it or says in one short line why not."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.adoption.made_up import MadeUp
from tests.robots.test_mutations import mutated_models

from gaitsmith.adoption import adopting
from gaitsmith.adoption.options import AdoptOptions
from gaitsmith.errors import BadInput

LONGEST = 400  # characters of a message
MODELS = [MadeUp(waist=1).text(), MadeUp(sole="trapezoid", toes=True).text(), MadeUp(sole="none", extra_legs=1).text()]


class Inferred(Exception):
    """The folder would be written now."""


@settings(max_examples=120)
@given(st.one_of([mutated_models(text.encode()) for text in MODELS]))
def test_any_model_is_read_asked_about_or_refused(text: bytes) -> None:
    def staged(_: Path) -> None:
        raise Inferred

    with tempfile.TemporaryDirectory() as name, pytest.MonkeyPatch.context() as patch:
        patch.setattr(adopting, "_staged", staged)
        model, out = Path(name) / "model.xml", Path(name) / "out"
        model.write_bytes(text)
        try:
            found = adopting.adopt(AdoptOptions(model=str(model), out=str(out)))
        except Inferred:
            pass
        except BadInput as error:
            words(str(error))
        else:
            words(found.reason)
            assert [set(asked) for asked in found.document["asked"]] == [{"flag", "candidates"}]
        assert [path.name for path in Path(name).iterdir()] == ["model.xml"]


def words(message: str) -> None:
    assert len(message) <= LONGEST
    assert len(message.splitlines()) == 1
    assert ": got " in message
