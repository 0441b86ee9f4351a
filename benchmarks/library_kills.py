"""``kill -9`` while a library is built, on this machine and on a Ray cluster: is the result the same as without?

    python benchmarks/library_kills.py [--gaits N] [--jobs N] [--kills N] [--seed N] [--ray] [--json]

The grid is built undisturbed; then killed at random moments, each time gone on with the same command; with `--ray` also
by a cluster of this machine with two worker nodes, one of which is killed half-way. It is right if all folders hold the
same bytes, and if no finished point was ever written again.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

LONGEST = 1800.0  # s for one build
LATE = 1.0  # s, latest moment of a kill after the point that it waits for


def _spec(gaits: int) -> str:
    """A grid of about so many gaits: few periods and step heights, as many speeds as it takes."""
    periods, heights = [0.6, 0.7], []
    if gaits >= 50:
        periods, heights = [0.6, 0.65, 0.7, 0.75, 0.8], [0.03, 0.035, 0.04, 0.045, 0.05]
    speeds = np.linspace(0.05, 0.4, max(gaits // (len(periods) * max(len(heights), 1)), 1)).round(4).tolist()
    return f'robot = "thbip_ii"\nspeed = {speeds}\nperiod = {periods}\nstep_height = {heights}\n'


def _start(spec: Path, out: Path, *more: str) -> subprocess.Popen[str]:
    words = [sys.executable, "-m", "gaitsmith", "library", "build", str(spec), "--out", str(out), "--json", *more]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def _finish(process: subprocess.Popen[str]) -> dict[str, Any]:
    try:
        out, error = process.communicate(timeout=LONGEST)
    finally:
        process.kill()
    if process.returncode not in (0, 3):
        raise SystemExit(f"library build ended with {process.returncode}: {error.strip()}")
    found: dict[str, Any] = json.loads(out)
    return found


def _contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def _points(folder: Path) -> dict[str, int]:
    """When each record was written, ns."""
    return {path.name: path.stat().st_mtime_ns for path in folder.glob("points/*.json")}


def _wait_for(process: subprocess.Popen[str], out: Path, count: int) -> None:
    """Until so many points are done, or the build has ended."""
    end = time.monotonic() + LONGEST
    while len(_points(out)) < count and process.poll() is None and time.monotonic() < end:
        time.sleep(0.02)


def killed_builds(spec: Path, out: Path, jobs: int, kills: int, gaits: int, rng: np.random.Generator) -> dict[str, Any]:
    """Kill the build at random moments, then let it finish."""
    rewritten, left = 0, []
    before: dict[str, int] = {}
    for _ in range(kills):
        process = _start(spec, out, "--jobs", str(jobs))
        try:
            _wait_for(process, out, len(before) + int(rng.integers(0, max(gaits // kills, 1))))
            time.sleep(float(rng.uniform(0.0, LATE)))
        finally:
            process.kill()
            process.communicate()
        now = _points(out)
        rewritten += sum(now.get(name) != at for name, at in before.items())
        before = now
        left.append(len(now))
    built = _finish(_start(spec, out, "--jobs", str(jobs)))
    now = _points(out)
    rewritten += sum(now.get(name) != at for name, at in before.items())
    return {"points_at_kill": left, "rewritten": rewritten, "resumed": built["resumed"]}


def cluster_build(spec: Path, out: Path, gaits: int) -> dict[str, Any]:
    """Build on two nodes, one of which is killed after half of the points."""
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
    process: subprocess.Popen[str] | None = None
    try:
        nodes = [cluster.add_node(num_cpus=1) for _ in range(2)]
        process = _start(spec, out, "--engine", "ray", "--address", cluster.address)
        _wait_for(process, out, gaits // 2)
        alive = len(_points(out))
        cluster.remove_node(nodes[1], allow_graceful=False)
        built = _finish(process)
        return {"points_at_kill": alive, "seconds": built["seconds"]}
    finally:
        if process is not None:
            process.kill()
        cluster.shutdown()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gaits", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--ray", action="store_true")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        spec, whole = place / "grid.toml", place / "whole"
        spec.write_text(_spec(options.gaits))
        built = _finish(_start(spec, whole, "--jobs", str(options.jobs)))
        gaits = built["gaits"]
        result: dict[str, Any] = {
            "gaits": gaits,
            "certified": built["certified"],
            "failed": built["failed"],
            "seconds": built["seconds"],
            "seconds_a_gait_a_process": built["seconds"] * options.jobs / gaits,
        }
        rng = np.random.default_rng(options.seed)
        builds: dict[str, Callable[[Path], dict[str, Any]]] = {}
        if options.kills:
            builds["killed"] = lambda out: killed_builds(spec, out, options.jobs, options.kills, gaits, rng)
        if options.ray:
            builds["ray"] = lambda out: cluster_build(spec, out, gaits)
        for kind, build in builds.items():
            result[kind] = build(place / kind)
            one, two = _contents(place / kind), _contents(whole)
            result[kind]["same"] = one == two
            result[kind]["differ"] = sorted(name for name in one.keys() | two.keys() if one.get(name) != two.get(name))
    print(json.dumps(result) if options.json else "\n".join(f"{key}: {value}" for key, value in result.items()))
    good = [result[kind]["same"] and not result[kind].get("rewritten") for kind in builds]
    raise SystemExit(0 if all(good) else 1)


if __name__ == "__main__":
    main()
