"""Random requests that nobody tuned for: planned, verified, proved.

    OMP_NUM_THREADS=1 python benchmarks/requests.py --out requests.jsonl [--seed N] [--first K] [--count N] [--json]

The 66 requests of a seed are 38 cyclic gaits, 6 starts, 5 stops, 4 walks and 13 kicks, in a random order. Every
answer is a line of ``--out``; what is there already is not planned again, so that a run may be cut at any moment.
What is said to have no solution is asked again, with ten times the iterations.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from gaitsmith.errors import BadInput
from gaitsmith.robots import load_robot
from gaitsmith.synthesis import Planner, answer
from gaitsmith.synthesis.motions.parameters import KickParameters, StepParameters
from gaitsmith.synthesis.motions.settings import Bounds, Settings
from gaitsmith.synthesis.proof.rigorous import proof_of
from gaitsmith.synthesis.requests.asked import KICK_FRICTION, Request
from gaitsmith.synthesis.requests.summary import largest_torque_rate, rejections

KINDS = ["cyclic"] * 38 + ["start"] * 6 + ["stop"] * 5 + ["walk"] * 4 + ["kick"] * 13
LONGEST = 0.33  # m: steps beyond are not asked for
MORE = 10  # times the budget, for what was said to have no solution


def requests(seed: int) -> list[Request]:
    """The 66 requests of a seed."""
    rng = np.random.default_rng(seed)
    return [_request(rng, str(kind)) for kind in rng.permutation(KINDS)]


def _request(rng: np.random.Generator, kind: str) -> Request:
    if kind == "kick":
        x, y = rng.uniform(-0.01, 0.05), rng.uniform(0.045, 0.085)
        kick = KickParameters((x, y), rng.uniform(0.5, 3.0), x + rng.uniform(0.07, 0.15), rng.uniform(0.03, 0.09))
        return Request("kick", kick=kick, settings=Settings(bounds=Bounds(friction=KICK_FRICTION)))
    easy = kind != "cyclic"
    while True:
        period = float(np.exp(rng.uniform(np.log(0.6 if easy else 0.45), np.log(1.4 if easy else 2.5))))
        length = rng.uniform(0.03, 0.25 if easy else LONGEST)
        if 0.02 <= length / period <= (0.3 if easy else 0.5):
            break
    height, double = rng.uniform(0.02, 0.06 if easy else 0.08), rng.uniform(0.2, 0.5 if easy else 0.6)
    return Request(kind, StepParameters(length, period, height, double), cycles=2)  # type: ignore[arg-type]


def asked(planner: Planner, request: Request) -> dict[str, Any]:
    """What became of a request."""
    begin = time.process_time()
    try:
        found = answer(planner, request)
    except BadInput as error:
        return {"status": "refused", "reason": str(error), "seconds": time.process_time() - begin}
    results = found.results.values()
    said: dict[str, Any] = {
        "status": found.main.status,
        "reason": found.main.reason,
        "seconds": time.process_time() - begin,
        "iterations": sum(item.iterations for item in results),
        "fallbacks": sum(item.fallbacks for item in results),
        "objective": found.main.objective,
        "default_rates": [item.default_rate for item in results],  # of torque, where they were relaxed
    }
    if found.gait is not None:
        robot = planner.biped.robot
        said["rate"] = largest_torque_rate(found.gait)
        said["rejected"] = rejections(found.gait, robot)
        said["unproved"] = proof_of(found.gait, robot)[1]
    return said


def examined(planner: Planner, number: int, request: Request) -> dict[str, Any]:
    """A request with its answer, and with that of ten times the budget where there was said to be none."""
    plain = asdict(request.kick if request.kind == "kick" else request.step)
    found: dict[str, Any] = {"number": number, "kind": request.kind, "request": plain} | asked(planner, request)
    if found["status"] == "not solved":
        longer = request.settings.model_copy(update={"max_iterations": MORE * request.settings.max_iterations})
        found["longer"] = asked(planner, replace(request, settings=longer))
    return found


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Counts by kind of request, and over all of them."""

    def counted(part: list[dict[str, Any]]) -> dict[str, Any]:
        solved = [row for row in part if row["status"] == "solved"]
        wrong = [row for row in part if row.get("longer", {}).get("status") == "solved"]
        impossible = [row for row in part if row["status"] in ("not solved", "refused") and row not in wrong]
        feasible = len(part) - len(impossible)
        return {
            "asked": len(part),
            "feasible": feasible,
            "solved": len(solved),
            "share": len(solved) / feasible if feasible else None,
            "verified": sum(not row["rejected"] for row in solved),
            "proved": sum(not row["rejected"] and not row["unproved"] for row in solved),
            "false_impossible": len(wrong),
            "undecided": sum(row["status"] in ("not decided", "not certified") for row in part),
            "fallbacks": sum(row.get("fallbacks", 0) for row in part),
            "median_cpu_s": float(np.median([row["seconds"] for row in part])) if part else None,
        }

    kinds = {kind: counted([row for row in rows if row["kind"] == kind]) for kind in dict.fromkeys(KINDS)}
    return {"all": counted(rows)} | kinds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=len(KINDS))
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    lines = arguments.out.read_text().splitlines() if arguments.out.exists() else []
    rows = [json.loads(line) for line in lines]
    have = {row["number"] for row in rows}
    planner = Planner(load_robot("thbip_ii"))
    every = list(enumerate(requests(arguments.seed)))[arguments.first : arguments.first + arguments.count]
    for number, request in every:
        if number in have:
            continue
        rows.append(examined(planner, number, request))
        with arguments.out.open("a") as file:
            file.write(json.dumps(rows[-1]) + "\n")
        if not arguments.json:
            row = rows[-1]
            trouble = [row["reason"], *row.get("rejected", []), *row.get("unproved", [])]
            if "longer" in row:
                trouble.append(f"longer: {row['longer']['status']} {row['longer']['reason']}")
            print(f"{number:3} {row['kind']:6} {row['status']:13} {row['seconds']:5.1f} s {row.get('iterations', 0):4} "
                  f"{'; '.join(text for text in trouble if text)}", flush=True)  # fmt: skip
    found = summary(rows)
    if arguments.json:
        print(json.dumps({"seed": arguments.seed, "summary": found, "requests": rows}))
        return
    names = list(found["all"])
    print(" " * 7 + " ".join(names))
    for kind, row in found.items():
        if row["asked"]:
            print(f"{kind:7}" + " ".join(f"{row[name] or 0:{len(name)}.4g}" for name in names))


if __name__ == "__main__":
    main()
