"""Model files from strangers: bounded, inside the card's folder, no entities; MuJoCo itself never opens a file."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from gaitsmith.errors import BadInput
from gaitsmith.files import read_bounded

FILE_LIMIT = 20_000_000
TOTAL_LIMIT = 200_000_000
PATHS = ("file", "filename", "meshdir", "assetdir", "texturedir")
ELEMENT_LIMIT = 50_000
DEPTH_LIMIT = 50
FILE_COUNT_LIMIT = 200
MESH_FORMATS = (".obj", ".stl", ".msh")


@dataclass
class CardFolder:
    """Files below one folder, each read once and within bounds; remembers what was read.

    Attributes:
        folder: absolute path, links resolved.
        label: what errors begin with, the card's file name.
        contents: bytes by relative path, in order of reading.
    """

    folder: Path
    label: str
    contents: dict[str, bytes] = field(default_factory=dict)

    def read(self, relative: str, entry: str) -> bytes:
        """Content of a file given by its path relative to the folder.

        Raises:
            BadInput: absolute, `..`, a link that leads outside, not a regular file, too large, too many.
        """
        key, path = self._resolve(relative, entry)
        if key not in self.contents:
            if len(self.contents) >= FILE_COUNT_LIMIT:
                raise BadInput(entry, relative, f"at most {FILE_COUNT_LIMIT} files")
            try:
                content = read_bounded(path, FILE_LIMIT)
            except BadInput as error:
                raise BadInput(entry, relative, error.valid, str(error.value)) from None
            if sum(map(len, self.contents.values())) + len(content) > TOTAL_LIMIT:
                raise BadInput(entry, relative, f"at most {TOTAL_LIMIT} bytes in all files together")
            self.contents[key] = content
        return self.contents[key]

    @property
    def _top(self) -> str:
        return "the card's folder" if self.label else "the folders of the model and of its package, two above at least"

    @property
    def _remedy(self) -> str:
        return "put the card into a folder above it, or let gaitsmith adopt copy the files" if self.label else ""

    def _resolve(self, relative: str, entry: str) -> tuple[str, Path]:
        valid, remedy = f"a relative path that stays below {self._top}", self._remedy
        if not relative or relative.startswith("/") or set(relative) & set('\\:\x00\n"'):
            raise BadInput(entry, relative, valid, remedy)
        lexical = os.path.normpath(relative)
        if lexical.split("/")[0] == "..":
            raise BadInput(entry, relative, valid, remedy)
        try:
            path = (self.folder / lexical).resolve()
        except (OSError, RuntimeError, ValueError) as error:
            raise BadInput(entry, relative, valid, str(error)) from None
        if not path.is_relative_to(self.folder):
            raise BadInput(entry, relative, valid, "a link leads outside")
        return path.relative_to(self.folder).as_posix(), path

    def find(self, name: str, bases: Iterable[str], entry: str) -> str:
        """Path, relative to the folder, of a file that a model names: the first candidate that is there.

        Args:
            name: a path, or `package://...`, whose longest tail below a folder above the naming file is taken.
            bases: folders from which a plain path may count, the naming file's first.
            entry: what errors begin with.

        Raises:
            BadInput: every candidate lies outside; a file that is missing is left to :meth:`read`.
        """
        bases = list(bases)
        scheme, found, rest = name.partition("://")
        if found and scheme in ("package", "model"):
            parts = PurePosixPath(rest).parts[:DEPTH_LIMIT]
            if ".." in parts:
                raise BadInput(entry, name, f"a path that stays below {self._top}", self._remedy)
            above = [str(folder) for folder in (PurePosixPath(bases[0]), *PurePosixPath(bases[0]).parents)]
            tails = ["/".join(parts[k:]) for k in range(len(parts))]
            tries = [f"{folder}/{tail}" for tail in tails for folder in above[:DEPTH_LIMIT]]
            tries = [*tries, f"./{tails[min(1, len(tails) - 1)]}"] if tails else []
        else:
            name = name.removeprefix("file://")
            tries = [name if name.startswith("/") else f"{base}/{name}" if base else name for base in bases]
        inside, refusal = [], BadInput(entry, name, f"a file below {self._top}", self._remedy)
        for candidate in tries:
            try:
                key, path = self._resolve(candidate, entry)
                if path.is_file():
                    return key
                inside.append(key)
            except BadInput as error:
                refusal = BadInput(entry, name, error.valid, error.remedy)
            except OSError:
                continue
        if not inside:
            raise refusal
        return inside[-1] if found else inside[0]

    def digest(self, card: bytes) -> str:
        """SHA-256 of the card and of every file read, as hexadecimal digits."""
        total = hashlib.sha256()
        for name, content in [("", card), *sorted(self.contents.items())]:
            total.update(f"{name}\n{len(content)}\n".encode())
            total.update(content)
        return total.hexdigest()


class _Guard(ElementTree.TreeBuilder):
    """Tree builder that refuses document types (so entities too), deep nesting, and crowds of elements."""

    def __init__(self, entry: str) -> None:
        super().__init__()
        self._entry = entry
        self._depth = 0
        self._count = 0

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise BadInput(self._entry, f"<!DOCTYPE {name}>", "XML without document type and entities")

    def start(self, tag: Any, attributes: Any, /) -> Element:
        self._depth += 1
        self._count += 1
        if self._depth > DEPTH_LIMIT:
            raise BadInput(self._entry, f"{self._depth} levels", f"at most {DEPTH_LIMIT} nested elements")
        if self._count > ELEMENT_LIMIT:
            raise BadInput(self._entry, f"{self._count} elements", f"at most {ELEMENT_LIMIT} elements")
        return super().start(tag, attributes)

    def end(self, tag: Any, /) -> Element:
        self._depth -= 1
        return super().end(tag)

    def pi(self, target: Any, data: Any = None, /) -> Any:
        return None


def parse_xml(content: bytes, entry: str) -> Element:
    """Root element of an XML text whose attributes hold no NaN, no infinity and, beside paths, no percent sign.

    MuJoCo builds some messages from names as if they were formats.

    Raises:
        BadInput: not well formed, a document type, too deep, too many elements, or an attribute that is refused.
    """
    parser = ElementTree.XMLParser(target=_Guard(entry))
    try:
        parser.feed(content)
        root: Element = parser.close()
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise BadInput(entry, str(error), "well-formed XML") from None
    for element in root.iter():
        for key, value in element.attrib.items():
            if not all(map(_finite_or_word, value.split())):
                raise BadInput(f"{entry}: {element.tag} {key}", value, "finite numbers")
            if "%" in value and key not in PATHS:
                raise BadInput(f"{entry}: {element.tag} {key}", value, "text without a percent sign")
    return root


def check_size(root: Element, entry: str) -> None:
    """Refuse a tree that is too deep or too large, as included files can make it."""
    level, count, depth = [root], 0, 0
    while level:
        count, depth = count + len(level), depth + 1
        if count > ELEMENT_LIMIT or depth > DEPTH_LIMIT:
            raise BadInput(entry, f"{count} elements", f"at most {ELEMENT_LIMIT} elements, {DEPTH_LIMIT} deep")
        level = [child for element in level for child in element]


def _finite_or_word(token: str) -> bool:
    try:
        return math.isfinite(float(token))
    except ValueError:
        return True
