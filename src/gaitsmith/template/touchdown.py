"""Touchdown of the swing sole, from sole forces, with early and late contact bounded."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from gaitsmith.compiled import kernel

if TYPE_CHECKING:
    from gaitsmith.robots.presets import TouchdownParameters

NONE = 0
CONTACT = 1
FORCED = 2


class TouchdownRule(NamedTuple):
    """:class:`TouchdownParameters` as a kernel reads them."""

    force: float
    earliest: float
    latest: float
    descent_speed: float


def make_touchdown_rule(parameters: TouchdownParameters) -> TouchdownRule:
    """Kernel form of ``parameters``."""
    return TouchdownRule(parameters.force, parameters.earliest, parameters.latest, parameters.descent_speed)


@kernel
def detect_touchdown(rule: TouchdownRule, time: float, period: float, force: float) -> int:
    """Whether the step ends now: NONE, CONTACT (sole force), or FORCED (too late to wait).

    Args:
        time: since the step began, s.
        period: T, s.
        force: normal force on the swing sole, N.
    """
    if time < rule.earliest * period:
        return NONE
    if force > rule.force:
        return CONTACT
    if time > rule.latest * period:
        return FORCED
    return NONE
