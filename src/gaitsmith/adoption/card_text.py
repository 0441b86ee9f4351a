"""The card as text: every entry with a comment that says what it was inferred from, or that it is assumed."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from gaitsmith.adoption.anatomy import Anatomy, LegFound
from gaitsmith.adoption.soles import SoleFound
from gaitsmith.documents import toml

Array = NDArray[np.float64]
_DIGITS = 5
_UPSIDE = 1.0 - 1e-9  # sine of a pitch so near to a right angle that only the sum of roll and yaw is known
_NEAR = 1e-3  # m, and of the axes: a site there is the sole's frame


@dataclass(frozen=True)
class Entry:
    """One entry of the card: its name, its value, and what it comes from."""

    entry: str
    value: Any
    source: str

    def document(self) -> dict[str, Any]:
        """As the JSON contract has it."""
        return {"entry": self.entry, "value": self.value, "from": self.source}


@dataclass
class CardDraft:
    """A card before it is written.

    Attributes:
        tables: further tables by name, such as `gait`.
    """

    header: list[Entry]
    legs: list[list[Entry]]
    tables: dict[str, list[Entry]] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    @property
    def inferred(self) -> list[Entry]:
        """All entries that come from somewhere, in order."""
        named = [Entry(f"{n}.{e.entry}", e.value, e.source) for n, es in self.tables.items() for e in es]
        legs = [Entry(f"legs[{k}].{e.entry}", e.value, e.source) for k, leg in enumerate(self.legs) for e in leg]
        return [entry for entry in (*self.header, *legs, *named) if entry.source]

    def text(self) -> str:
        """TOML."""
        lines = [
            "# Written by `gaitsmith adopt`; comments say what it was inferred from. Lengths in m, angles in rad.",
            "# The model and its meshes beside this card are copies; their licence is their author's.",
            "",
            *_lines(self.header),
        ]
        for leg in self.legs:
            lines += ["", "[[legs]]", *_lines(leg)]
        for name, entries in self.tables.items():
            lines += ["", f"[{name}]", *_lines(entries)]
        if self.remarks:
            lines.append("")
        for remark in self.remarks:
            lines += textwrap.wrap(_plain(remark), 117, initial_indent="# ", subsequent_indent="#   ")
        return "\n".join(lines) + "\n"


def draft_card(
    name: str,
    model_file: str,
    model: mujoco.MjModel,
    anatomy: Anatomy,
    soles: Sequence[SoleFound],
    weld: Mapping[str, str],
) -> CardDraft:
    """The card of what was found.

    Args:
        model_file: the model's path below the card's folder.
        soles: left, right.
        weld: joints to be welded, and why.
    """
    torso = model.body(anatomy.torso).name
    header = [
        Entry("schema_version", 2, ""),
        Entry("name", name, ""),
        Entry("model", model_file, ""),
        Entry("torso", torso, "the body where the two legs meet"),
    ]
    turn = rpy(anatomy.torso_axes)
    if np.abs(turn).max() > 1e-4:
        header.append(Entry("torso_frame", {"rpy": turn}, f"forward from {anatomy.forward_from}; up at the zero pose"))
    if weld:
        header.append(Entry("weld", list(weld), "; ".join(dict.fromkeys(weld.values()))))
    legs = [_leg(model, anatomy.data, leg, sole) for leg, sole in zip(anatomy.legs, soles, strict=True)]
    return CardDraft(header, legs)


def _leg(model: mujoco.MjModel, data: mujoco.MjData, leg: LegFound, sole: SoleFound) -> list[Entry]:
    rotation: Array = data.xmat[sole.body].reshape(3, 3)
    place = rotation.T @ (sole.position - data.xpos[sole.body])
    entries = [
        Entry("name", leg.name, ""),
        Entry("joints", [model.joint(j).name for j in leg.joints], f"{', '.join(leg.roles)}: axes at the zero pose"),
    ]
    for entry, joint, source in (
        ("knee", leg.knee, "the second pitch joint"),
        ("ankle_pitch", leg.ankle_pitch, "the third pitch joint"),
        ("ankle_roll", leg.ankle_roll, "the roll joint below the knee"),
    ):
        entries += [Entry(entry, model.joint(joint).name, source)] if joint >= 0 else []
    site = _site(model, data, leg, sole)
    if site:
        return [
            *entries,
            Entry("sole_site", site, "on the sole, below the ankle"),
            Entry("sole", sole.entry(), sole.source),
        ]
    entries += [
        Entry("sole_body", model.body(sole.body).name, "what the last joint moves"),
        Entry("sole_position", [round(float(v), _DIGITS) + 0.0 for v in place], "on the sole, below the ankle"),
    ]
    turn = rpy(rotation.T @ sole.axes)
    if np.abs(turn).max() > 1e-4:
        entries.append(Entry("sole_rpy", turn, "flat on the ground, x forward"))
    return [*entries, Entry("sole", sole.entry(), sole.source)]


def _site(model: mujoco.MjModel, data: mujoco.MjData, leg: LegFound, sole: SoleFound) -> str:
    """A site of the foot that is where the sole's frame would be put; empty without one."""
    for site in range(model.nsite):
        near = np.linalg.norm(data.site_xpos[site] - sole.position) < _NEAR
        level = np.abs(data.site_xmat[site].reshape(3, 3) - sole.axes).max() < _NEAR
        if int(model.site_bodyid[site]) in leg.links and near and level:
            return str(model.site(site).name)
    return ""


def rpy(rotation: Array) -> list[float]:
    """Roll, pitch and yaw about fixed axes."""
    pitch = -np.arcsin(np.clip(rotation[2, 0], -1.0, 1.0))
    roll, yaw = np.arctan2(rotation[2, 1], rotation[2, 2]), np.arctan2(rotation[1, 0], rotation[0, 0])
    if abs(rotation[2, 0]) > _UPSIDE:  # roll and yaw turn about the same axis
        roll, yaw = np.arctan2(-rotation[1, 2], rotation[1, 1]), 0.0
    return [round(float(angle), 6) + 0.0 for angle in (roll, pitch, yaw)]


def _lines(entries: Sequence[Entry]) -> list[str]:
    return [f"{e.entry} = {toml(e.value)}" + (f"  # {_plain(e.source)}" if e.source else "") for e in entries]


def _plain(text: str) -> str:
    """Text that a comment can hold."""
    return "".join(c if c.isprintable() else "?" for c in " ".join(text.split()))
