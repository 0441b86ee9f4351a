"""Which joints of an MJCF do not move independently: equality constraints and tendons."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from xml.etree.ElementTree import Element

from gaitsmith.robots.model_text import Coupling

LOOKS = {"name", "group", "width", "rgba", "material", "user", "margin", "springlength"}


def couplings(root: Element) -> tuple[Coupling, ...]:
    """Couplings of a model, in the file's order; what is inactive or only measures couples nothing."""
    tree = _Tree(root)
    tendons = [tendon for section in root.iter("tendon") if section in set(root) for tendon in section]
    named = {tendon.get("name", ""): tree.of_tendon(tendon) for tendon in tendons}
    driven = {drive.get("tendon") for section in root.findall("actuator") for drive in section}
    defaults = any(default.find("tendon") is not None for default in root.iter("default"))
    found = []
    for section in root.findall("equality"):
        for equality in section:
            if equality.get("active", "true").strip() == "false":
                continue
            joints = [equality.get(key, "") for key in ("joint1", "joint2")]
            for key in ("tendon1", "tendon2"):
                joints += named.get(equality.get(key, ""), ())
            if equality.tag in ("connect", "weld"):
                joints += tree.between(tree.ends(equality))
            found.append(Coupling(_once(joints), f"equality {equality.tag}"))
    for tendon in tendons:
        acts = set(tendon.attrib) - LOOKS - ({"class"} if not defaults else set())
        if acts or defaults or tendon.get("name") in driven:
            found.append(Coupling(_once(tree.of_tendon(tendon)), f"tendon {tendon.get('name', '')}".strip()))
    return tuple(coupling for coupling in found if coupling.joints)


class _Tree:
    """Bodies, and the joints between them."""

    def __init__(self, root: Element) -> None:
        self._above = {child: parent for parent in root.iter() for child in parent}
        self._places = {
            (kind, element.get("name")): self._body(element)
            for kind in ("body", "site", "geom")
            for world in root.findall("worldbody")
            for element in world.iter(kind)
        }
        self._joints: dict[Element | None, list[str]] = {}
        for world in root.findall("worldbody"):
            for joint in world.iter("joint"):
                self._joints.setdefault(self._body(joint), []).append(joint.get("name", ""))

    def _body(self, element: Element | None) -> Element | None:
        """The element itself if it is a body, else the body that it is in; None for the world."""
        while element is not None and element.tag != "body":
            element = self._above.get(element)
        return element

    def ends(self, element: Element) -> list[Element | None]:
        """The two bodies of a constraint; a missing one is the world."""
        return [
            self._places.get(("site", element.get(f"site{k}"))) or self._places.get(("body", element.get(f"body{k}")))
            for k in (1, 2)
        ]

    def between(self, bodies: list[Element | None]) -> list[str]:
        """Joints that move two bodies against each other."""
        chains = []
        for body in bodies:
            chain = []
            while body is not None:
                chain.append(body)
                body = self._body(self._above.get(body))
            chains.append(chain)
        shared = set(chains[0]) & set(chains[1])
        return [name for chain in chains for body in chain if body not in shared for name in self._joints.get(body, ())]

    def of_tendon(self, tendon: Element) -> list[str]:
        """Joints that change a tendon's length."""
        joints = [child.get("joint", "") for child in tendon.iter("joint")]
        places = [
            self._places[child.tag, child.get(child.tag)]
            for child in tendon
            if (child.tag, child.get(child.tag)) in self._places
        ]
        for first, second in pairwise(places):
            joints += self.between([first, second])
        return joints


def _once(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for name in names if name))
