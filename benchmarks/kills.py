"""``kill -9`` at random moments of a run: what is left of it, and can it be read?

    python benchmarks/kills.py [--count N] [--seed N] [--robot NAME] [--json]

A moment is right if the log on disk was at most a second old when the run was killed, `gaitsmith log check` reads it,
and its rows have no gap.
"""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

LONGEST = 60.0  # s; a run that has not begun its log by then never does
AGE = 1.0  # s of wall time between the last bytes on disk and the end


def _gaitsmith(*words: str) -> list[str]:
    return [sys.executable, "-m", "gaitsmith", *words]


def kill_once(folder: Path, robot: str, after: float) -> dict[str, Any]:
    """Start a long run, kill it ``after`` seconds from the log's first bytes on, and look at what is there."""
    run = folder / "run"
    words = _gaitsmith("walk", "--robot", robot, "--duration", "3600", "--out", str(run), "--no-figures")
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        began = time.monotonic()
        while not (logs := [path for path in folder.rglob("*.mcap*") if path.stat().st_size]):
            if time.monotonic() - began > LONGEST or process.poll() is not None:
                process.kill()
                return {"after": after, "ok": False, "why": "no log ever appeared"}
            time.sleep(0.01)
        time.sleep(after)
        process.send_signal(signal.SIGKILL)
        killed = time.time()
    age = killed - max(path.stat().st_mtime for path in logs)
    place = logs[0].parent
    done = subprocess.run(_gaitsmith("log", "check", str(place), "--json"), capture_output=True, text=True)
    if done.returncode:
        return {"after": after, "ok": False, "age": age, "why": done.stderr.strip() or done.stdout.strip()}
    checked = json.loads(done.stdout)
    ticks = 4 * (checked["rows"] - 1) + 1  # a row every fourth tick, from the first one on
    whole = checked["rows"] == 0 or abs(ticks - 1000.0 * checked["last_time"]) < 0.5
    return {"after": after, "ok": age <= AGE and whole, "age": age, "left": place.name, **checked}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--robot", default="bhr_b2")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rng, rows = np.random.default_rng(options.seed), []
    for _ in range(options.count):
        with tempfile.TemporaryDirectory() as folder:
            rows.append(kill_once(Path(folder), options.robot, round(float(rng.uniform(0.0, 5.0)), 2)))
            if not options.json:
                print(rows[-1], flush=True)
    good = sum(row["ok"] for row in rows)
    print(json.dumps({"kills": rows, "readable": good}) if options.json else f"{good} of {len(rows)} readable")


if __name__ == "__main__":
    main()
