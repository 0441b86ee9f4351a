"""One HTML page that needs nothing else: text, tables and pictures inside it, no script, no address."""

from __future__ import annotations

import base64
import platform
from collections.abc import Iterable, Sequence
from html import escape
from importlib.metadata import PackageNotFoundError, version

from matplotlib.figure import Figure

import gaitsmith
from gaitsmith.view.canvas import as_svg

_LIBRARIES = ("numpy", "mujoco", "numba", "casadi", "matplotlib")
_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1b1f24; background: #fff; margin: 2em auto; max-width: 1080px;
       padding: 0 1em }
h1 { font-size: 1.6em; margin-bottom: .2em } h2 { font-size: 1.25em; margin-top: 2em; border-bottom: 1px solid #d9dde1 }
h3 { font-size: 1.05em; margin-bottom: .3em }
table { border-collapse: collapse; margin: 1em 0; font-size: 13.5px; display: block; overflow-x: auto }
th, td { padding: .25em .7em; border-bottom: 1px solid #e4e7ea; text-align: left; vertical-align: top }
th { background: #f1f3f5; white-space: pre-line } td.n { text-align: right; white-space: nowrap }
pre, code { font: 13px/1.45 ui-monospace, monospace; background: #f6f8fa; border-radius: 4px }
pre { padding: .7em 1em; overflow-x: auto } code { padding: .1em .3em }
img { max-width: 100%; height: auto; margin: .5em 0 } figcaption { color: #57606a; font-size: 13.5px }
figure { margin: 1.2em 0 } .bad { color: #c1121f; font-weight: 600 } .good { color: #116329; font-weight: 600 }
.muted { color: #57606a }
"""
_HEAD = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<title>{title}</title><style>{style}</style></head><body>
"""


class Page:
    """A page that is written from top to bottom; whatever it is given is text, never markup."""

    def __init__(self, title: str, lead: str = "") -> None:
        self._parts = [_HEAD.format(title=escape(title), style=_STYLE), f"<h1>{escape(title)}</h1>\n"]
        if lead:
            self._parts.append(f'<p class="muted">{escape(lead)}</p>\n')

    def heading(self, text: str, level: int = 2, anchor: str = "") -> None:
        """A heading; ``anchor`` is what links name it by."""
        name = f' id="{escape(anchor)}"' if anchor else ""
        self._parts.append(f"<h{level}{name}>{escape(text)}</h{level}>\n")

    def text(self, line: str, style: str = "") -> None:
        """A paragraph; ``style`` is good, bad or muted."""
        self._parts.append(f'<p class="{escape(style)}">{escape(line)}</p>\n' if style else f"<p>{escape(line)}</p>\n")

    def code(self, text: str) -> None:
        """Lines to be typed, or a file."""
        self._parts.append(f"<pre>{escape(text)}</pre>\n")

    def table(self, headings: Sequence[str], rows: Iterable[Sequence[str]], left: Iterable[int] = (0,)) -> None:
        """A table; columns numbered in ``left`` hold words, the others numbers; a verdict is coloured."""
        words = set(left)
        head = "".join(f"<th>{escape(heading)}</th>" for heading in headings)
        self._parts.append(f"<table><thead><tr>{head}</tr></thead><tbody>\n")
        for row in rows:
            cells = []
            for column, cell in enumerate(row):
                shown = _VERDICTS.get(cell.split(" ")[0].rstrip(":;,"), "") if column in words else "n"
                cells.append(f'<td class="{shown}">{escape(cell)}</td>' if shown else f"<td>{escape(cell)}</td>")
            self._parts.append(f"<tr>{''.join(cells)}</tr>\n")
        self._parts.append("</tbody></table>\n")

    def figure(self, made: Figure, caption: str = "") -> None:
        """A figure, as vectors."""
        self.picture(as_svg(made), "image/svg+xml", caption)

    def picture(self, content: bytes, kind: str, caption: str = "") -> None:
        """A picture in one of the formats that browsers know."""
        data = base64.b64encode(content).decode("ascii")
        below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
        self._parts.append(
            f'<figure><img alt="{escape(caption)}" src="data:{escape(kind)};base64,{data}">{below}</figure>\n'
        )

    def versions(self) -> None:
        """What made the page."""
        self.heading("Versions")
        self.text(", ".join(f"{name} {number}" for name, number in versions().items()))

    def render(self) -> str:
        """The whole page."""
        return "".join([*self._parts, "</body></html>\n"])


_VERDICTS = {"agrees": "good", "differs": "bad", "cannot": "muted"}


def versions() -> dict[str, str]:
    """This package, Python, the engines and the machine's kind."""
    found = {"gaitsmith": gaitsmith.__version__, "Python": platform.python_version()}
    for name in _LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "absent"
    return found | {"machine": f"{platform.system()} {platform.machine()}"}
