"""Tick time and speed of the closed loop of two source trees, taking turns on the same machine.

    python benchmarks/compare_ticks.py NEW/src OLD/src [--gait FILE] [--blocks N] [--json]

Every tree has a process of its own, with one thread. Blocks of ticks alternate between them, so that both see the same
machine. ``--gait`` adds a planned gait, whose double support is timed; an older tree that cannot walk it has no figure.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter_ns
from typing import Any

import numpy as np

BLOCK = 200  # ticks: short, so that both trees see the same load
LOOP_SECONDS = 20.0
CASES: dict[str, dict[str, Any]] = {
    "bhr_b2 standing": {"robot": "bhr_b2", "rest_before": 3000.0},
    "bhr_b2 walking": {"robot": "bhr_b2", "speed": [0.3, 0.0]},
    "thbip_ii standing": {"robot": "thbip_ii", "rest_before": 3000.0},
    "thbip_ii walking": {"robot": "thbip_ii"},
}


def serve() -> None:
    """Worker: a line with a scenario begins a run, every further empty line asks for a block of tick times."""
    from gaitsmith.simulation import Simulation
    from gaitsmith.simulation.scenario import make_scenario

    simulation, times = None, []
    for line in sys.stdin:
        if line.strip():
            fields = {"duration": 3000.0, **json.loads(line)}
            double_only = "gait" in fields
            try:
                simulation = Simulation(make_scenario(fields), record=False)
            except Exception as error:
                print(json.dumps({"error": str(error)}), flush=True)
                continue
            times = []
            _timed(simulation.controller, times, double_only)
        else:
            times.clear()
            upright = True
            while upright and len(times) < BLOCK:
                upright = simulation.step()
        print(json.dumps({"ns": times, "time": simulation.time}), flush=True)


def _timed(controller: Any, times: list[int], double_only: bool) -> None:
    """Time every tick of a controller; in double support only, if both soles are to carry."""
    tick, force = controller.tick, controller.telemetry.sole_force

    def timed() -> Any:
        before = perf_counter_ns()
        torque = tick()
        after = perf_counter_ns()
        if not double_only or min(force) > 5.0:
            times.append(after - before)
        return torque

    controller.tick = timed


class Tree:
    """A source tree and its worker."""

    def __init__(self, source: str) -> None:
        self.environment = {**os.environ, "PYTHONPATH": str(Path(source).resolve()), "OMP_NUM_THREADS": "1"}
        command = [sys.executable, __file__, "--serve"]
        self.worker = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=self.environment
        )

    def ask(self, line: str) -> dict[str, Any]:
        """One answer of the worker."""
        self.worker.stdin.write(line + "\n")
        self.worker.stdin.flush()
        return json.loads(self.worker.stdout.readline() or '{"error": "the worker ended"}')

    def realtime_factor(self) -> float:
        """Of a walk with its log, on its own process."""
        with tempfile.TemporaryDirectory() as folder:
            words = ["walk", "--duration", f"{LOOP_SECONDS:g}", "--out", f"{folder}/run", "--no-figures", "--json"]
            done = subprocess.run(
                [sys.executable, "-m", "gaitsmith", *words], env=self.environment, capture_output=True, text=True
            )
            return float(json.loads(done.stdout)["realtime_factor"])


def compare(trees: list[Tree], scenario: dict[str, Any], blocks: int) -> Iterator[dict[str, float] | None]:
    """Median and 99th percentile of every tree, µs; None where the tree cannot run the scenario."""
    answers = [tree.ask(json.dumps(scenario)) for tree in trees]
    able = ["error" not in answer for answer in answers]
    for answer in answers:
        if "error" in answer:
            print(f"{scenario}: {answer['error']}", file=sys.stderr)
    found: list[list[int]] = [[] for _ in trees]
    for block in range(blocks + 1):
        for k, tree in enumerate(trees):
            if able[k]:
                times = tree.ask("")["ns"]
                found[k] += times if block else []  # the first one warms up
    for times in found:
        yield {"median": np.median(times) / 1e3, "p99": np.percentile(times, 99) / 1e3} if times else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("new")
    parser.add_argument("old")
    parser.add_argument("--gait", help="planned gait, of the robot that it names")
    parser.add_argument("--gait-robot", default="thbip_ii")
    parser.add_argument("--blocks", type=int, default=100)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    trees = [Tree(options.new), Tree(options.old)]
    cases = dict(CASES)
    if options.gait:
        cases["planned, double support"] = {"robot": options.gait_robot, "gait": [options.gait], "cycles": 1000}
    ticks = {name: list(compare(trees, scenario, options.blocks)) for name, scenario in cases.items()}
    factors = np.median([[tree.realtime_factor() for tree in trees] for _ in range(3)], axis=0)
    if options.json:
        print(json.dumps({"tick_us": ticks, "realtime_factor": factors.tolist()}))
        return
    print(f"{'µs':26} {'new: median':>12} {'p99':>7} {'old: median':>12} {'p99':>7} {'ratio':>7}")
    for name, pair in ticks.items():
        words = [f"{p['median']:12.2f} {p['p99']:7.1f}" if p else f"{'–':>12} {'–':>7}" for p in pair]
        ratio = f"{pair[0]['median'] / pair[1]['median']:7.2f}" if all(pair) else f"{'–':>7}"
        print(f"{name:26} {words[0]} {words[1]} {ratio}")
    base = ticks["bhr_b2 walking"][0]
    for name, pair in ticks.items():
        if not name.startswith("bhr_b2") and pair[0] and base:
            print(f"{name}: {pair[0]['median'] / base['median']:.2f} × bhr_b2 walking")
    print(f"times real time, log included: {factors[0]:.1f} against {factors[1]:.1f}, {factors[0] / factors[1]:.2f} ×")


if __name__ == "__main__":
    serve() if "--serve" in sys.argv else main()
