"""The Hessian assembled section by section: the same as through the whole input map, in all kinds of phases."""

import numpy as np
import pytest
import scipy.sparse as sp

from gaitsmith.synthesis import KickParameters, Settings, StepParameters
from gaitsmith.synthesis.motions.biped import standing
from gaitsmith.synthesis.motions.catalogue import cyclic, kick
from gaitsmith.synthesis.point.caller import Caller
from gaitsmith.synthesis.program.assembly import Assembly
from gaitsmith.synthesis.program.curvature import Curvature
from gaitsmith.synthesis.program.program import make_program
from gaitsmith.synthesis.program.transcription import Transcription

SAME = 1e-12  # relative: only the order of additions differs


@pytest.fixture(scope="module", params=["cyclic", "kick"])
def program(request, planner):
    biped = planner.biped
    motion = (
        cyclic(biped, StepParameters(0.15, 1.0))
        if request.param == "cyclic"
        else kick(biped, KickParameters(), standing(biped, biped.height - 0.03))
    )
    trans = Transcription(biped, motion, Settings())
    return make_program(trans, planner.functions, trans.points())


def _somewhere(program):
    rng = np.random.default_rng(4)
    return 0.1 * rng.normal(size=program.size), rng.normal(size=program.rows)


def test_exact_curvature_is_the_solvers(program):
    x, multipliers = _somewhere(program)
    call = Caller(Assembly(program).hessian)
    call(x, np.zeros(0), 1.0, multipliers)
    upper = call.matrix(0)
    expected = (upper + sp.triu(upper, 1).T).toarray()
    found = Curvature(program).exact(x, multipliers).toarray()
    assert np.abs(found - expected).max() < SAME * np.abs(expected).max()


def test_convex_curvature_is_never_negative(program):
    x, _ = _somewhere(program)
    H = Curvature(program).convex(x).toarray()
    assert np.abs(H - H.T).max() < SAME * np.abs(H).max()
    values = np.linalg.eigvalsh(H)
    assert values.min() > -SAME * values.max()
