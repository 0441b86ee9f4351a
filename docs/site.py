"""Hooks of the docs site: a page of all numbered examples, links to files that are not pages, the links of the README.

`make docs` builds the site into `build/site`; warnings are errors.
"""

import ast
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"


def examples_page() -> str:
    """Every numbered example: what it does, and its source."""
    parts = ["# Examples\n", "Each one runs as it is, and runs as a test.\n"]
    for path in sorted(EXAMPLES.glob("[0-9]*.py")):
        source = path.read_text(encoding="utf-8")
        told = (ast.get_docstring(ast.parse(source)) or "").split("\n\n")
        parts.append(f"## {path.stem.replace('_', ' ')} {{ #{path.stem} }}\n\n{told[0]}\n")
        parts.append(f'```python title="examples/{path.name}"\n{source}```\n')
    return "\n".join(parts)


def linked(text: str) -> str:
    """Links to examples lead to their place on the page of examples; links to other files of the checkout are names."""
    text = re.sub(r"\]\(\.\./examples/(\d\d_\w+)\.py\)", r"](examples.md#\1)", text)
    return re.sub(r"\[([^\]]+)\]\(\.\./[^)]+\)", r"\1", text)


def on_files(files: Any, config: Any) -> Any:
    """The page of examples is made, not kept."""
    from mkdocs.structure.files import File

    files.append(File.generated(config, "examples.md", content=examples_page()))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Every page's links, as the site has them."""
    return linked(markdown)
