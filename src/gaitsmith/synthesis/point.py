"""CasADi functions of one point of a gait: values, Jacobian and Hessian, compiled when a C compiler is present."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from gaitsmith.compiled.cache import cache_root, private_folder
from gaitsmith.dynamics import symbolic
from gaitsmith.synthesis.biped import Biped
from gaitsmith.synthesis.caller import Caller
from gaitsmith.synthesis.layout import Layout

_OPTIONS = ("-O1", "-fPIC", "-shared", "-fno-math-errno")
_KEPT = 64  # mapped functions that are remembered
_NAMES = ("value", "jacobian", "hessian")

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class PointFunctions:
    """The three functions of a point and how they came about.

    Attributes:
        layout: meaning of inputs z and outputs o.
        value: (z, pivot) -> o.
        jacobian: (z, pivot) -> (o, do/dz).
        hessian: (z, pivot, multipliers, weight) -> d²(multipliersᵀ o)/dz² + 2 weight JᵀJ with J = dτ/dz.
        compiled: whether they are machine code.
        compile_s: time spent compiling in this call, s.
    """

    layout: Layout
    value: Any
    jacobian: Any
    hessian: Any
    compiled: bool
    compile_s: float
    _mapped: dict[tuple[str, int], Caller] = field(default_factory=dict)

    def evaluate(self, points: Array, pivots: Array) -> Array:
        """Outputs (outputs, K) for many points: inputs (inputs, K) and pivots (3, K)."""
        count = points.shape[1]
        if count == 0:
            return np.zeros((self.layout.outputs, 0))
        (found,) = self._caller("value", count)(points.T.ravel(), pivots.T.ravel())
        return found.reshape(count, self.layout.outputs).T.copy()

    def differentiate(self, points: Array, pivots: Array) -> tuple[Array, Array]:
        """Outputs (outputs, K) and Jacobians (K, outputs, inputs) for many points."""
        count = points.shape[1]
        values, slopes = self._caller("jacobian", count)(points.T.ravel(), pivots.T.ravel())
        rows, columns = self.jacobian.sparsity_out(1).get_triplet()
        dense = np.zeros((count, self.layout.outputs, self.layout.inputs))
        dense[:, rows, columns] = slopes.reshape(count, -1)
        return values.reshape(count, self.layout.outputs).T.copy(), dense

    def _caller(self, name: str, count: int) -> Caller:
        """The function mapped over a number of points, kept for the next time."""
        key = (name, count)
        if key not in self._mapped:
            if len(self._mapped) > _KEPT:
                self._mapped.clear()
            self._mapped[key] = Caller(getattr(self, name).map(count))
        return self._mapped[key]


def _expressions(biped: Biped) -> list[Any]:
    """The three functions as CasADi expressions in the virtual machine."""
    model, layout = biped.model, Layout(biped.joints)
    n = layout.joints
    z, pivot = ca.SX.sym("z", layout.inputs), ca.SX.sym("pivot", 3)
    q, v, a = ca.SX.zeros(model.nq), ca.SX.zeros(model.nv), ca.SX.zeros(model.nv)
    for joint in range(n):
        q[biped.qpos[joint]], v[biped.dof[joint]], a[biped.dof[joint]] = z[joint], z[n + joint], z[2 * n + joint]
    u = z[layout.wrench :]
    support, other = biped.leg("right"), biped.leg("left")
    turn = support.sole_rotation.T
    start = symbolic.at_rest(model, turn, -turn @ support.sole_position)
    point = ca.DM(other.sole_position) + ca.mtimes(ca.DM(other.sole_rotation), pivot)
    wrench = symbolic.ExternalWrench(other.sole_body, point, u[:3], u[3:])
    found = symbolic.newton_euler(model, support.sole_body, start, q, v, a, (wrench,))
    torque = ca.vertcat(*(found.generalized[dof] for dof in biped.dof))
    force = ca.mtimes(ca.DM(turn), found.root_force)
    moment = ca.mtimes(ca.DM(turn), found.root_moment) + ca.cross(start.position, force)
    foot, torso = found.motion[other.sole_body], found.motion[biped.robot.torso_body]
    sole = ca.mtimes(foot.rotation, ca.DM(other.sole_rotation))
    spin = ca.cross(foot.omega, point)
    local = foot.acceleration + ca.cross(foot.alpha, point) + ca.cross(foot.omega, spin)
    hip = torso.position + ca.mtimes(torso.rotation, ca.DM(biped.robot.hip_midpoint))
    outputs = ca.vertcat(
        torque,
        force,
        moment,
        foot.position + ca.mtimes(foot.rotation, point),
        sole[1, 0],
        -sole[2, 0],
        sole[2, 1],
        ca.mtimes(foot.rotation, foot.velocity + spin),
        ca.mtimes(foot.rotation, foot.omega),
        ca.mtimes(foot.rotation, local) + ca.DM(model.opt.gravity),
        ca.mtimes(foot.rotation, foot.alpha),
        hip[2],
        torso.rotation[1, 0],
        -torso.rotation[2, 0],
        torso.rotation[2, 1],
        foot.position,
        ca.mtimes(foot.rotation, foot.velocity),
        sole[0, 0],
        ca.dot(moment, force) / biped.weight,
        ca.dot(u[3:], u[:3]) / biped.weight,
        force[2] ** 2 / biped.weight,
        u[2] ** 2 / biped.weight,
    )
    multipliers, weight = ca.SX.sym("l", layout.outputs), ca.SX.sym("w")
    jacobian = ca.jacobian(outputs, z)
    torque_jacobian = ca.jacobian(torque, z)
    hessian = ca.hessian(ca.dot(multipliers, outputs), z)[0]
    hessian = hessian + 2 * weight * ca.mtimes(torque_jacobian.T, torque_jacobian)
    return [
        ca.Function("value", [z, pivot], [outputs]),
        ca.Function("jacobian", [z, pivot], [outputs, jacobian]),
        ca.Function("hessian", [z, pivot, multipliers, weight], [hessian]),
    ]


def _key(biped: Biped, compiler: str) -> str:
    """Hash of everything that decides the machine code."""
    digest = hashlib.sha256(biped.dynamics_hash.encode())
    for part in (version("casadi"), compiler, " ".join(_OPTIONS), os.uname().machine):
        digest.update(part.encode())
    for source in (Path(__file__), Path(symbolic.__file__)):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:20]


def find_compiler() -> str | None:
    """Path of a C compiler; ``GAITSMITH_CC`` names another one, and ``none`` asks for none."""
    chosen = os.environ.get("GAITSMITH_CC")
    if chosen == "none":
        return None
    return shutil.which(chosen) if chosen else shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


def _compile(functions: list[Any], compiler: str, target: Path) -> None:
    """Generate C for the functions and compile it into ``target``, whole or not at all."""
    with tempfile.TemporaryDirectory(dir=target.parent) as scratch:
        generator = ca.CodeGenerator("point.c")
        for function in functions:
            generator.add(function)
        generator.generate(scratch + os.sep)
        built = Path(scratch) / "point.so"
        command = [compiler, *_OPTIONS, str(Path(scratch) / "point.c"), "-o", str(built), "-lm"]
        subprocess.run(command, check=True, capture_output=True)
        ctypes.CDLL(str(built))
        built.replace(target)


def _packed(layout: Layout, functions: list[Any], compiled: bool, spent: float) -> PointFunctions:
    value, jacobian, hessian = functions
    return PointFunctions(layout, value, jacobian, hessian, compiled, spent)


def point_functions(biped: Biped, notify: Callable[[str], None] | None = None) -> PointFunctions:
    """The functions of a point for one robot, from the cache, the compiler, or CasADi's virtual machine.

    Args:
        biped: the robot as the planner sees it.
        notify: told once when something slow happens (compiling, or no compiler).

    Raises:
        CacheRefused: the cache folder is not the owner's alone.
    """
    layout = Layout(biped.joints)
    tell = notify or (lambda _: None)
    compiler = find_compiler()
    if compiler is not None:
        folder = private_folder(private_folder(cache_root()) / f"point-{_key(biped, compiler)}")
        library = folder / "point.so"
        spent = 0.0
        if not library.is_file():
            tell("compiling the robot's dynamics, once (about a minute)")
            begin = time.perf_counter()
            try:
                _compile(_expressions(biped), compiler, library)
            except (OSError, subprocess.CalledProcessError) as error:
                tell(f"the C compiler failed ({error}); going on without it, about four times slower")
                return _packed(layout, _expressions(biped), False, 0.0)
            spent = time.perf_counter() - begin
        loaded = [ca.external(name, str(library)) for name in _NAMES]
        return _packed(layout, loaded, True, spent)
    tell("no C compiler found: going on without one, about four times slower, with the same answers")
    return _packed(layout, _expressions(biped), False, 0.0)
