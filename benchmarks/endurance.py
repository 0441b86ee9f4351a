"""Hours of random commands in one run: does it fall, does memory stay flat, is the log whole?

    python benchmarks/endurance.py [--robot NAME] [--hours H] [--seed N] [--share X] [--every S] [--json]

Every few seconds one or two inputs of the gait change to a random place in the inner ``share`` of the card's ranges.
Memory is read from outside, by the process's own account in /proc.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from gaitsmith.robots import load_robot


def commands(robot: str, duration: float, every: float, share: float, seed: int) -> dict[str, Any]:
    """A scenario of random changes."""
    card, rng = load_robot(robot).card, np.random.default_rng(seed)
    usual = card.gait.model_dump()
    usual |= {"speed_x": usual["speed"][0], "speed_y": usual["speed"][1]}
    limits = {name: value for name, value in card.gait_limits.model_dump().items() if value and value[0] < value[1]}

    def draw(name: str) -> float:
        low, high = limits[name]
        middle = min(max(usual.get(name) or 0.0, low), high)
        return round(middle + share * (rng.uniform(low, high) - middle), 4)

    changes = []
    for k in range(1, int(duration / every)):
        inputs = [name for name in limits if name not in ("speed_x", "speed_y")]
        change: dict[str, Any] = {"time": round(k * every, 3), "speed": [draw("speed_x"), draw("speed_y")]}
        if k % 2:
            name = str(rng.choice(inputs))
            change[name] = draw(name)
        changes.append(change)
    return {"robot": robot, "duration": duration, "seed": seed, "changes": changes}


def toml(scenario: dict[str, Any]) -> str:
    """The scenario as a file."""
    lines = [f"{key} = {json.dumps(value)}" for key, value in scenario.items() if key != "changes"]
    changes = (", ".join(f"{key} = {json.dumps(value)}" for key, value in c.items()) for c in scenario["changes"])
    return "\n".join([*lines, "changes = [", *(f"    {{ {change} }}," for change in changes), "]", ""])


def resident_mb(process: int) -> float:
    """Resident memory of a process, MB; 0 once it has ended."""
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="bhr_b2")
    parser.add_argument("--hours", type=float, default=2.0)
    parser.add_argument("--every", type=float, default=5.0)
    parser.add_argument("--share", type=float, default=0.3)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    scenario = commands(options.robot, 3600.0 * options.hours, options.every, options.share, options.seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "random.toml"
        path.write_text(toml(scenario))
        words = ["walk", str(path), "--out", f"{folder}/run", "--no-figures", "--json"]
        began, memory = time.monotonic(), []
        with subprocess.Popen([sys.executable, "-m", "gaitsmith", *words], stdout=subprocess.PIPE, text=True) as run:
            while True:
                try:
                    printed, _ = run.communicate(timeout=1.0)
                    break
                except subprocess.TimeoutExpired:
                    memory.append(resident_mb(run.pid))
        summary = json.loads(printed)
        checked = subprocess.run(
            [sys.executable, "-m", "gaitsmith", "log", "check", f"{folder}/run", "--json"],
            capture_output=True,
            text=True,
        )
        size = sum(file.stat().st_size for file in Path(f"{folder}/run").rglob("*") if file.is_file()) / 1e6
    memory = [used for used in memory if used]  # 0 once the process has ended
    settled = memory[len(memory) // 10 :] or [0.0]  # the first tenth loads and compiles
    result = {
        "fell": summary.get("fell"),
        "fall": summary.get("fall"),
        "error": summary.get("error"),
        "simulated": summary.get("duration"),
        "realtime_factor": summary.get("realtime_factor"),
        "memory_mb": summary.get("memory_mb"),
        "resident_mb": {"after_a_tenth": settled[0], "end": settled[-1], "growth": settled[-1] - settled[0]},
        "log": summary.get("log"),
        "log_check": json.loads(checked.stdout) if checked.returncode == 0 else checked.stderr.strip(),
        "folder_mb": size,
        "seconds": time.monotonic() - began,
    }
    if options.json:
        print(json.dumps(result))
        return
    for name, value in result.items():
        print(f"{name:18} {value}")


if __name__ == "__main__":
    main()
