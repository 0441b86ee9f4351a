"""A model's links: bodies with everything rigidly attached below them, the joints between, and what touches the ground.

Everything is measured at the model's zero pose. A link is named by the index of its topmost body.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from gaitsmith.adoption.refusals import Asked, Unfit
from gaitsmith.adoption.shapes import colliding, lowest

_LOW = 0.08  # of the robot's height: what is nearer to the ground may be part of a foot
_NEARLY = 0.25  # of the robot's height: what is nearer may be a foot that another pose puts down
_MOST = 12  # links that are tried as feet


class Links:
    """Links and what they carry, at the zero pose."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, entry: str) -> None:
        self.model, self.data, self.entry = model, data, entry
        self.links = sorted({int(link) for link in model.body_weldid} - {0})
        self.parent = {link: int(model.body_weldid[model.body_parentid[link]]) for link in self.links}
        self.joints = {
            link: tuple(j for j in range(model.njnt) if model.jnt_bodyid[j] == link and model.jnt_type[j] in (2, 3))
            for link in self.links
        }
        self.bodies = {link: np.flatnonzero(model.body_weldid == link) for link in self.links}
        self.shapes = {link: colliding(model, data, self.bodies[link]) for link in self.links}

    def ancestors(self, link: int) -> list[int]:
        """From the root to the link itself."""
        found = [link]
        while self.parent[found[-1]] in self.parent:
            found.append(self.parent[found[-1]])
        return found[::-1]

    def path(self, torso: int, foot: int) -> tuple[int, ...]:
        """Joints between two links."""
        lineage = self.ancestors(foot)
        return tuple(j for link in lineage[lineage.index(self.link_of(torso)) + 1 :] for j in self.joints[link])

    def link_of(self, body: int) -> int:
        """The link that a body belongs to."""
        return int(self.model.body_weldid[body])

    def legs(self, wanted: Sequence[str], torso_name: str) -> tuple[int, list[int]]:
        """The torso's body, and each leg's lowest link."""
        feet = [self.link_of(self._body("--feet", name)) for name in wanted] if wanted else self._low()
        lineages = [self.ancestors(foot) for foot in feet]
        common = 0
        while all(len(line) > common and line[common] == lineages[0][common] for line in lineages):
            common += 1
        branches: dict[int, list[list[int]]] = {}
        for line in lineages:
            branches.setdefault(line[min(common, len(line) - 1)], []).append(line)
        split = lineages[0][max(common - 1, 0)]
        if split in feet or len(branches) < 2:
            self._refuse_single(feet, lineages)
        chains = [self._chain(lines, common) for lines in branches.values()]
        short = [chain for chain in chains if len(self.path(split, chain)) < 3]
        if len(chains) != 2 or short:
            names = ", ".join(self.name(chain) for chain in chains[:6])
            raise Unfit(self.entry, f"{len(chains)} limbs on the ground ({names})")
        torso = self._body("--torso", torso_name) if torso_name else split
        if self.link_of(torso) != split:
            bodies = [self.name(int(body)) for body in self.bodies[split]]
            valid = f"a body of the link where the legs meet: {', '.join(bodies[:_MOST])}"
            raise Asked("--torso", bodies, "--torso", torso_name, valid)
        return torso, chains

    def _low(self) -> list[int]:
        """Links that nearly touch the ground; by their origins if no shape does."""
        heights = {link: lowest(shapes)[2] for link, shapes in self.shapes.items() if shapes}
        places = self.data.xpos[self.links, 2]
        top = max(float(places.max()), max(heights.values(), default=-np.inf))
        origins = dict(zip(self.links, places.tolist(), strict=True))
        below = min(heights.values(), default=np.inf)
        if below > min(origins.values()) + 0.02 * (top - min(origins.values())):
            heights = origins  # the feet have no shape
            below = min(origins.values())
        if len(self.links) < 3 or top - below < 1e-6:
            raise Unfit(self.entry, f"{len(self.links)} moving bodies", "")
        return [link for link, height in heights.items() if height < below + _LOW * (top - below)]

    def _chain(self, lines: list[list[int]], common: int) -> int:
        """The last link of one limb: the deepest one, or where a foot divides into toes."""
        deepest = max(lines, key=len)
        for depth in range(common, len(deepest)):
            through = [line for line in lines if line[: depth + 1] == deepest[: min(depth + 1, len(line))]]
            if len(through) < len(lines):
                if len(self.path(deepest[common - 1], deepest[depth - 1])) < 3:
                    names = ", ".join(self.name(line[-1]) for line in lines[:4])
                    raise Unfit(self.entry, f"limbs that divide before the foot ({names})")
                return deepest[depth - 1]
        return deepest[-1]

    def _refuse_single(self, feet: list[int], lineages: list[list[int]]) -> None:
        low = min(feet, key=self._height)
        above = len(self.path(lineages[0][0], low)) if low in self.parent else 0
        found = "one leg" if above >= 3 else "no legs"
        raise Unfit(self.entry, f"{found}: {self.name(low)} is lowest, {above} joints below the root", "try --feet")

    def nearly_low(self) -> list[str]:
        """Bodies of the lowest links, one a link, from the lowest up: what may be feet."""
        heights = {link: min(self._height(link), float(self.data.xpos[link, 2])) for link in self.links}
        low, top = min(heights.values()), max(heights.values())
        found = [link for link in self.links if heights[link] < low + _NEARLY * (top - low)]
        return [self.name(link) for link in sorted(found, key=lambda link: heights[link])[:_MOST]]

    def _height(self, link: int) -> float:
        return float(lowest(self.shapes[link], self.data.xpos[link])[2])

    def _body(self, flag: str, name: str) -> int:
        body = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, name)
        if body <= 0:
            names = self.nearly_low() if flag == "--feet" else [self.name(link) for link in self.links[:_MOST]]
            raise Asked(flag, names, flag, name, f"a body: {', '.join(names)}")
        return int(body)

    def name(self, body: int) -> str:
        """Of a body."""
        return str(self.model.body(body).name)
