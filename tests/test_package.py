"""The package's front: light to import, every public name there, the README's Python runs."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import gaitsmith

ROOT = Path(__file__).resolve().parent.parent


def test_every_public_name_loads() -> None:
    assert all(getattr(gaitsmith, name) is not None for name in dir(gaitsmith))


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'walkies'"):
        _ = gaitsmith.walkies


def test_import_loads_nothing_heavy() -> None:
    code = "import sys, gaitsmith; print(sorted({'numpy', 'mujoco', 'numba', 'pydantic'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT / "src", capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_readme_runs() -> None:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert len(blocks) == 2
    shared: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), shared)
