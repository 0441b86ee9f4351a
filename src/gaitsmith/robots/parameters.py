"""Inputs of the gait template and their limits: frozen, validated, in SI units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Annotated, Any, Optional

from pydantic import Field, create_model

from gaitsmith.documents import About, Frozen
from gaitsmith.errors import BadInput

Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Finite = float  # models refuse NaN and infinities
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]


class Parameters(Frozen):
    """Base of the groups of a card and of settings."""


def partial(model: type[Parameters]) -> Any:
    """The same model with every entry optional, so that a card may be silent."""
    fields: dict[str, Any] = {}
    for name, field in model.model_fields.items():
        kind: Any = field.annotation
        if isinstance(kind, type) and issubclass(kind, Parameters):
            kind = partial(kind)
        elif field.metadata:
            kind = Annotated[kind, *field.metadata]
        fields[name] = (Optional[kind], None)  # noqa: UP045 - built at run time
    return create_model(f"Card{model.__name__}", __base__=Parameters, __doc__=model.__doc__, **fields)


@dataclass(frozen=True)
class GaitInput(About):
    """What one input of the gait template is; everything that names it is derived from this.

    Attributes:
        parts: names of its numbers in limits and telemetry, if it has several; else its own name is taken.
        keys: their names in a summary.
        stops: whether it is zero at rest.
        fixed: what it means that a robot's limits leave a single value.
    """

    parts: tuple[str, ...] = ()
    keys: tuple[str, ...] = ()
    stops: bool = False
    fixed: str = ""


class GaitParameters(Parameters):
    """The gait template's inputs (Han 2023, section 2, and a turning rate); all may change while walking.

    This is their only declaration: limits, commands, flags, summaries and telemetry columns follow from it.
    """

    speed: Annotated[
        tuple[Finite, Finite],
        GaitInput(
            "Commanded CoM velocity in the heading frame, forward and to the left",
            "m/s",
            "VX [VY]",
            parts=("speed_x", "speed_y"),
            keys=("vx", "vy"),
            stops=True,
        ),
    ] = (0.0, 0.0)
    period: Annotated[Positive, GaitInput("Duration T of one step", "s", "S")]
    alpha: Annotated[Fraction, GaitInput("Lifting stage's share of the period", "", "A")] = 0.5
    height: Annotated[Positive, GaitInput("Height H of the hip midpoint above the stance sole", "m", "M")]
    lift: Annotated[Positive, GaitInput("Height h of the swing sole at the end of the lifting stage", "m", "M")]
    width: Annotated[Positive, GaitInput("Half the lateral distance W between the soles", "m", "M")]
    yaw_rate: Annotated[
        Finite,
        GaitInput(
            "Rate at which the heading turns, to the left", "rad/s", "W", stops=True, fixed="the legs cannot turn"
        ),
    ] = 0.0


GAIT_INPUTS: dict[str, GaitInput] = {
    name: next(entry for entry in field.metadata if isinstance(entry, GaitInput))
    for name, field in GaitParameters.model_fields.items()
}


def gait_numbers(gait: Mapping[str, Any], keys: bool = False) -> Iterator[tuple[str, str, Any]]:
    """Every number of some gait inputs: its name in limits (or in a summary), its place in the input, its value."""
    for name, value in gait.items():
        about = GAIT_INPUTS[name]
        for k, part in enumerate(about.keys if keys and about.keys else about.parts or (name,)):
            yield (part, f"{name}[{k}]", value[k]) if about.parts else (part, name, value)


def _range(name: str) -> Any:
    """Annotation and default of the limits of one number of the gait; an input that may be absent is fixed then."""
    about = GAIT_INPUTS[name]
    default = (0.0, 0.0) if about.fixed else ...
    return tuple[Finite, Finite], default


if TYPE_CHECKING:

    class GaitLimits(Parameters):
        """Valid closed ranges of the numbers of the gait, (lowest, highest)."""

        def __getattr__(self, name: str) -> tuple[float, float]: ...

else:
    GaitLimits = create_model(
        "GaitLimits",
        __base__=Parameters,
        __module__=__name__,
        __doc__="Valid closed ranges of the numbers of the gait, (lowest, highest).",
        **{part: _range(name) for name, about in GAIT_INPUTS.items() for part in about.parts or (name,)},
    )


def at_rest(gait: Mapping[str, Any]) -> dict[str, Any]:
    """The inputs with those at zero that stop at rest."""
    return {
        name: GaitParameters.model_fields[name].default if GAIT_INPUTS[name].stops else value
        for name, value in gait.items()
    }


def check_gait(gait: Mapping[str, Any], limits: GaitLimits, prefix: str = "") -> None:
    """Check gait inputs against a robot's limits.

    Args:
        gait: any of the inputs, by name.
        limits: of the robot.
        prefix: put before the name of what is wrong.

    Raises:
        BadInput: an unknown input, something else than numbers, or a number outside the limits.
    """
    for name, value in gait.items():
        if name not in GAIT_INPUTS:
            raise BadInput(f"{prefix}{name}", value, f"one of {', '.join(GAIT_INPUTS)}")
        about = GAIT_INPUTS[name]
        listed = isinstance(value, (tuple, list)) or getattr(value, "ndim", 0) > 0
        if listed != bool(about.parts) or (listed and len(value) != len(about.parts)):
            count = f"{len(about.parts)} numbers" if about.parts else "one number"
            raise BadInput(f"{prefix}{name}", value, f"{count}: {about.meaning}, {about.unit}")
    for part, place, value in gait_numbers(gait):
        low, high = getattr(limits, part)
        about = GAIT_INPUTS[place.partition("[")[0]]
        if isinstance(value, bool) or not isinstance(value, Real) or not low <= value <= high:
            alone = low == high
            valid = f"{low:g} only" if alone else f"{low:g} to {high:g} {about.unit}".strip()
            raise BadInput(f"{prefix}{place}", value, valid, about.fixed if alone else "")
