"""What a field is to people, and what a name may be: put into annotations, read by help texts and messages."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo

LONGEST_NAME = 200
FORMULA = "=+-@"  # a spreadsheet takes what begins like this for a formula
VALID_NAME = f"1 to {LONGEST_NAME} printable characters, the first none of {' '.join(FORMULA)} or a space"


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _InOurWords
else:

    class _InOurWords(type(BaseModel)):
        """What a model refuses when it is built is named as it is when it is read from a file."""

        def __call__(cls, *given: Any, **values: Any) -> Any:
            try:
                return super().__call__(*given, **values)
            except ValidationError as error:
                from gaitsmith.documents.refusal import refusal  # which reads this module

                raise refusal(error, cls) from None


class Frozen(BaseModel, metaclass=_InOurWords):
    """Base of all data that is checked when it is built: frozen, no unknown keys, no NaN."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)


class Worded(Frozen):
    """Base of data that can be written as one word besides a table."""


@dataclass(frozen=True)
class About:
    """What a field is; a field that has it becomes an option of the commands that take its model.

    Attributes:
        meaning: a phrase without a full stop.
        unit: SI; empty without one.
        metavar: what stands for the value in a command's usage; a number in brackets may be left out, and is 0 then.
        absent: what the help calls a default of None; a function is asked only when help is shown.
        flag: the option, if it is not named as the field.
    """

    meaning: str
    unit: str = ""
    metavar: str = ""
    absent: str | float | Callable[[], str] = ""
    flag: str = ""


def about(field: FieldInfo) -> About | None:
    """What a model's field is; None if nobody says."""
    return next((entry for entry in field.metadata if isinstance(entry, About)), None)


def check_name(text: str) -> str:
    """The name of a joint, a body, a phase: plain text that no table, figure or terminal takes for anything else.

    Raises:
        ValueError: saying what is valid.
    """
    plain = 1 <= len(text) <= LONGEST_NAME and text.isprintable() and text == text.strip(" ")
    if not plain or text[0] in FORMULA:
        raise ValueError(VALID_NAME)
    return text


def written_as(pattern: str, valid: str) -> AfterValidator:
    """Text that matches a pattern from end to end, and what people are told of it."""

    def check(text: str) -> str:
        if not re.fullmatch(pattern, text):
            raise ValueError(valid)
        return text

    return AfterValidator(check)


Name = Annotated[str, AfterValidator(check_name)]
