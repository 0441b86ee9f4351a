"""What the feet of a motion may do: a foot moves only in the air, and bears the robot only where it stands."""

from __future__ import annotations

from itertools import pairwise

from gaitsmith.errors import BadInput
from gaitsmith.synthesis.motions.motion import Motion, Phase

_SAME = 1e-6  # m, rad: footholds that count as one
_TWIST = 1.0  # rad: largest heading of one sole against the other
_Place = tuple[float, float]


def check_contacts(phases: tuple[Phase, ...], cyclic: bool, keys: tuple[str, str]) -> None:
    """Refuse phases in a row that no walking machine can go through.

    Args:
        phases: in order of time.
        cyclic: whether the first phase follows the last one, or its mirror image does.
        keys: what the file calls the place of the support foot, and that of the other one.

    Raises:
        BadInput: naming the entry, as in ``phases[2].support``.
    """
    for index, phase in enumerate(phases):
        if phase.double != (phase.other is not None):
            valid = "no place in the air" if not phase.double else "two numbers, where the other sole stands"
            raise BadInput(f"phases[{index}].{keys[1]}", phase.other, valid)
        if not abs(phase.bend) <= _TWIST:
            valid = f"at most {_TWIST:g} rad from the support sole's heading, {phase.heading:g}"
            raise BadInput(f"phases[{index}].other_heading", phase.other_heading, valid)
    for index, (before, after) in enumerate(pairwise(phases), start=1):
        _check_pair(before, after, f"phases[{index}]", keys)
    _check_edges(phases, cyclic)
    if phases[0].flies or phases[-1].flies:
        valid = "a phase with both feet flat at the start and at the end"
        raise BadInput(
            "phases[0].contact" if phases[0].flies else f"phases[{len(phases) - 1}].contact", "flight", valid
        )
    if cyclic:
        _check_cycle(phases[0], phases[-1], keys)


def _check_edges(phases: tuple[Phase, ...], cyclic: bool) -> None:
    """A support foot gets on its toe only while the other is in the air; then that one bears, or it lies down."""
    for index, phase in enumerate(phases):
        field = f"phases[{index}].support_contact"
        if not phase.tips:
            continue
        if phase.contact != "air" or any(item.heading or item.other_heading for item in phases):
            valid = "flat, or toe while the other foot is in the air and nothing is turned"
            raise BadInput(field, "toe", valid)
        if index in (0, len(phases) - 1):
            raise BadInput(field, "toe", "flat in the first phase and in the last")
        after = phases[index + 1]
        if after.double and not (after.contact == "toe" and after.support == phase.other_foot):
            valid = "a phase after it in which the foot that has landed bears flat, and this one is on its toe"
            raise BadInput(f"phases[{index + 1}].contact", after.contact, valid)


def check_slope(motion: Motion) -> None:
    """Refuse what is not known of inclined ground.

    Raises:
        BadInput: a slope with flights or with soles that are turned.
    """
    turned = any(phase.heading or phase.other_heading for phase in motion.phases)
    if motion.slope and (turned or motion.flies):
        raise BadInput("slope", motion.slope, "0 for a motion with turned soles or flights")


def _check_pair(before: Phase, after: Phase, field: str, keys: tuple[str, str]) -> None:
    if before.flies != after.flies:
        ground = after if before.flies else before
        if ground.contact != "flat":
            raise BadInput(f"{field}.contact", after.contact, "both feet flat before and after a flight")
        if before.support != after.support:
            raise BadInput(f"{field}.support", after.support, f"{before.support} as in the phase before")
        if before.flies:
            return  # they may come down elsewhere
    stood = {before.support: (before.height, before.heading)}
    if before.double:
        stood[before.other_foot] = (before.other_height, before.other_heading)
    here = [("", after.support, (after.height, after.heading))]
    if after.double:
        here.append(("other_", after.other_foot, (after.other_height, after.other_heading)))
    for prefix, foot, values in here:
        for key, unit, known, value in zip(
            ("height", "heading"), ("m", "rad"), stood.get(foot, values), values, strict=True
        ):
            if abs(known - value) > _SAME:
                raise BadInput(f"{field}.{prefix}{key}", value, f"{known:g} {unit}, as that foot stands before")
    landed = before.tips and after.double  # the foot in the air has become the support
    if before.support != after.support and not (landed or (before.double and after.double)):
        remedy = "the support changes between two phases with both feet on the ground"
        raise BadInput(f"{field}.support", after.support, f"{before.support} as in the phase before", remedy)
    if landed and not _equal(before.foothold, after.other or before.foothold):
        raise BadInput(f"{field}.{keys[1]}", after.other, f"{before.foothold}, where that foot stands before")
    held, free = before.place(after.support), before.place(after.other_foot)
    if held is not None and not _equal(held, after.foothold):
        raise BadInput(f"{field}.{keys[0]}", after.foothold, f"{held}, where that foot stands before")
    if free is not None and after.other is not None and not _equal(free, after.other):
        raise BadInput(f"{field}.{keys[1]}", after.other, f"{free}, where that foot stands before")


def _check_cycle(first: Phase, last: Phase, keys: tuple[str, str]) -> None:
    """The first phase, or its mirror image if the support differs, must be able to follow the last one."""
    side = 1.0 if last.support == first.support else -1.0
    if first.other is not None and last.other is not None:
        if abs(first.bend - last.bend) > _SAME:
            valid = f"{last.heading + last.side * first.bend:g} rad, as at the start"
            raise BadInput("cyclic: last phase's other_heading", last.other_heading, valid)
        first, last = first.straight, last.straight
        assert first.other is not None
        assert last.other is not None
        gaps = [b - a for a, b in zip(first.foothold, first.other, strict=True)]
        wanted = (last.foothold[0] + gaps[0], last.foothold[1] + side * gaps[1])
        if not _equal(wanted, last.other):
            valid = f"{wanted}, as at the start" + ("" if side > 0.0 else ", mirrored")
            raise BadInput(f"cyclic: last phase's {keys[1]}", last.other, valid)


def _equal(one: _Place, two: _Place) -> bool:
    return max(abs(a - b) for a, b in zip(one, two, strict=True)) <= _SAME
