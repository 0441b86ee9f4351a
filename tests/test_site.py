"""The docs site builds without a warning; what the tutorial tells to type works."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from gaitsmith.cli import main

ROOT = Path(__file__).resolve().parent.parent
TUTORIAL = ROOT / "docs" / "tutorial.md"


def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, env={"NO_MKDOCS_2_WARNING": "1"})
    assert done.returncode == 0, done.stderr
    examples = (tmp_path / "examples.html").read_text()
    assert all(f'id="{path.stem}"' in examples for path in (ROOT / "examples").glob("[0-9]*.py"))


def test_the_tutorial_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    told = 0
    for language, title, block in re.findall(r'```(\w+)(?: title="([\w.]+)")?\n(.*?)```', TUTORIAL.read_text(), re.S):
        if title:
            Path(title).write_text(block)
        elif language == "sh":
            for line in block.strip().splitlines():
                assert main(line.split()[1:]) == 0, line
                told += 1
        elif language == "python":
            exec(compile(block, "tutorial.md", "exec"), {})
            told += 1
    assert told >= 6
    assert {"first", "pushed", "mine", "sensors"} <= {path.name for path in Path("runs").iterdir()}
    assert list(Path("runs/mine").glob("*.html"))
