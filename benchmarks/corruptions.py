"""Gait files with one thing changed and all checksums of the file recomputed: does `verify` accept any?

OMP_NUM_THREADS=1 python benchmarks/corruptions.py GAIT.json ... [--count 1000] [--seed 0]
"""

from __future__ import annotations

import argparse
import copy
import json
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from gaitsmith.errors import BadInput
from gaitsmith.robots import Robot
from gaitsmith.synthesis import verify
from gaitsmith.synthesis.files.gait_file import _checksum, gait_of, load_robot_of, read_gait, require_robot

Document = dict[str, Any]
Random = np.random.Generator
DENSE = 40  # instants a phase
STRANGE = ("furlong", "", "N", "m/s", "°", "lbf·ft")


def _amount(rng: Random, least: float) -> float:
    """A change of either sign, from ``least`` to a thousand times that."""
    return float(rng.choice((-1.0, 1.0)) * least * 10.0 ** rng.uniform(0.0, 3.0))


def _coefficient(document: Document, rng: Random) -> str:
    """Of a joint (rad), a torque (N·m), a wrench (N, N·m) or a root (m, rad): changes that no rounding explains."""
    section = rng.choice(rng.choice(document["phases"])["sections"])
    kinds = [("joints", 1e-4), ("torque", 1e-2), ("wrench", 1e-2), *([("root", 1e-4)] if "root" in section else [])]
    name, least = kinds[rng.integers(len(kinds))]
    row = section[name][rng.integers(len(section[name]))]
    row[rng.integers(len(row))] += _amount(rng, least)
    return f"coefficient of {name}"


def _number(entry: Document, key: str, rng: Random) -> None:
    known = entry.get(key, 0.0)
    entry[key] = known + _amount(rng, 1e-3 * (1.0 + abs(known)))


def _certificate(document: Document, rng: Random) -> str:
    certificate = document["certificate"]
    rows = certificate["worst"]
    k = int(rng.integers(len(rows)))
    row, what = (
        rows[k],
        str(rng.choice(("value", "limit", "violation", "unit", "time", "phase", "name", "gone", "twice"))),
    )
    if what in ("value", "limit", "violation"):
        _number(row, what, rng)
    elif what == "time":
        row["time"] += _amount(rng, 1e-4)
    elif what == "unit":
        row["unit"] = str(rng.choice([unit for unit in STRANGE if unit != row["unit"]]))
    elif what == "phase":
        row["phase"] = str(rng.choice([p["name"] for p in _elsewhere(document, row["time"])] or ["nowhere"]))
    elif what == "name":
        row["constraint"] = str(rng.choice([r["constraint"] for r in rows if r is not row] or ["nothing"]))
    elif what == "gone":
        del rows[k]
    else:
        rows.insert(k, dict(row))
    return f"certificate: {what}"


def _elsewhere(document: Document, time: float) -> list[Document]:
    """Phases that a time is not in."""
    found, start = [], 0.0
    for phase in document["phases"]:
        if not start - 1e-6 <= time <= start + phase["duration"] + 1e-6:
            found.append(phase)
        start += phase["duration"]
    inside = {phase["name"] for phase in document["phases"] if phase not in found}
    return [phase for phase in found if phase["name"] not in inside]


def _whole(document: Document, rng: Random) -> str:
    certificate = document["certificate"]
    key = str(rng.choice(("objective", "wrench_weight", "effort_weights", "dense_points", "claims")))
    if key == "dense_points":
        certificate[key] += int(rng.choice((-7, -1, 1, 50)))
    elif key == "claims":
        certificate[key] = certificate[key][::-1]
    elif key == "effort_weights":
        certificate[key][str(rng.choice(document["joints"]))] = 1.0 + abs(_amount(rng, 1e-3))
    else:
        certificate[key] *= 1.0 + abs(_amount(rng, 1e-3))
    return f"certificate: {key}"


def _bounds(document: Document, rng: Random) -> str:
    key = str(rng.choice(list(document["bounds"])))
    document["bounds"][key] *= float(rng.choice((0.5, 0.9, 0.99, 1.01, 1.1, 2.0)))
    return f"bounds: {key}"


def _condition(document: Document, rng: Random) -> str:
    k = int(rng.integers(len(document["conditions"])))
    item = document["conditions"][k]
    if rng.random() < 0.2:
        del document["conditions"][k]
        return "condition gone"
    if rng.random() < 0.2:
        item["border"] = int(
            (item["border"] + 1 + rng.integers(len(document["phases"]))) % (len(document["phases"]) + 1)
        )
        return "condition elsewhere"
    if item["kind"] == "value":
        _number(item, "value", rng)
    elif item["kind"] == "unloaded":
        item["border"] -= 1
    elif item["kind"] == "same" and rng.random() < 0.5:
        item["mirrored"] = not item["mirrored"]
    elif item["kind"] == "same":
        item["other"] = (item["other"] + 1) % (len(document["phases"]) + 1)
    else:
        rows = [item[name] for name in ("position", "velocity", "acceleration") if item[name] is not None]
        row = rows[rng.integers(len(rows))]
        row[rng.integers(len(row))] += _amount(rng, 0.05)
    return f"condition: {item['kind']}"


def _phase(document: Document, rng: Random) -> str:
    phase = document["phases"][rng.integers(len(document["phases"]))]
    keys = (
        "duration",
        "support",
        "contact",
        "foothold",
        "other_foothold",
        "heading",
        "other_heading",
        "limits",
        "name",
    )
    key = str(rng.choice(keys))
    if key == "duration":
        phase[key] *= 1.0 + _amount(rng, 1e-4)
    elif key == "support":
        phase[key] = {"left": "right", "right": "left"}[phase[key]]
    elif key == "contact":
        phase[key] = str(rng.choice([c for c in ("air", "flat", "heel", "toe") if c != phase[key]]))
    elif key in ("foothold", "other_foothold"):
        if phase[key] is None:
            phase[key] = [0.1, 0.1]
        else:
            phase[key][rng.integers(2)] += _amount(rng, 1e-4)
    elif key in ("heading", "other_heading"):
        phase[key] += _amount(rng, 1e-4)
    elif key == "limits":
        phase[key] = [{"quantity": "hip_height", "low": 0.0, "high": 9.0}]
    else:
        phase[key] = "somewhere"
    return f"phase: {key}"


def _head(document: Document, rng: Random) -> str:
    key = str(rng.choice(("cyclic", "order", "robot_hash", "parameters", "joints", "version")))
    if key == "cyclic":
        document[key] = not document[key]
    elif key == "order":
        document[key] = 9 - document[key]
    elif key == "robot_hash":
        document[key] = document[key][::-1]
    elif key == "parameters":
        _number(document[key], str(rng.choice(sorted(document[key].keys() | {"length"}))), rng)
    elif key == "joints":
        document[key] = document[key][1:] + document[key][:1]
    else:
        document[key] = 1
    return key


KINDS: tuple[Callable[[Document, Random], str], ...] = (
    *(_coefficient, _coefficient, _coefficient),
    *(_certificate, _certificate, _whole, _bounds, _condition, _phase, _head),
)


def corrupted(document: Document, rng: Random) -> tuple[str, Document]:
    """What was changed, and the changed document with the checksum of its content."""
    found = copy.deepcopy(document)
    what = KINDS[rng.integers(len(KINDS))](found, rng)
    found["checksum"] = _checksum(found)
    return what, found


def accepted(document: Document, robot: Robot) -> bool:
    """Whether a gait file with this content would be read, belongs to the robot, and is verified."""
    if document["version"] != 2:
        return False
    try:
        gait = gait_of(document)
        require_robot(gait, robot)
    except BadInput:
        return False
    return verify(gait, robot, DENSE).ok


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("gaits", nargs="+")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    rng, tried, through = np.random.default_rng(given.seed), Counter[str](), list[str]()
    documents = []
    for path in given.gaits:
        with open(path, encoding="utf-8") as file:
            documents.append((json.load(file), load_robot_of(read_gait(path)[0])))
        assert accepted(*documents[-1]), path
    for k in range(given.count):
        document, robot = documents[k % len(documents)]
        what, changed = corrupted(document, rng)
        tried[what] += 1
        if accepted(changed, robot):
            through.append(f"{given.gaits[k % len(documents)]}, change {k}: {what}")
    for what, count in sorted(tried.items()):
        print(f"{count:5d}  {what}")
    print(f"{len(through)} of {given.count} accepted", *through, sep="\n")


if __name__ == "__main__":
    main()
