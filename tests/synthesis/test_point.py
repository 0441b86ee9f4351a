"""A point's functions: derivatives, the mirror image, and the same answers with and without a compiler."""

import numpy as np
import pytest

from gaitsmith.errors import CacheRefused
from gaitsmith.synthesis import Planner, StepParameters
from gaitsmith.synthesis.motions.catalogue import cyclic
from gaitsmith.synthesis.point.functions import point_functions
from gaitsmith.synthesis.point.library import find_compiler

SAME = 1e-9  # relative: compiler and virtual machine round differently
STEP, SLOPE = 1e-6, 1e-5  # finite differences


@pytest.fixture(scope="module")
def interpreted(planner):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GAITSMITH_CC", "none")
        notices = []
        found = point_functions(planner.biped, notices.append)
    assert not found.compiled
    assert len(notices) == 1
    assert "slower" in notices[0]
    return found


def _sample(layout, seed=0):
    rng = np.random.default_rng(seed)
    z = rng.normal(size=(layout.inputs, 4)) * 0.4
    return z, np.tile(np.array([[-0.06], [0.0], [0.0]]), (1, 4))


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_compiled_functions_equal_the_virtual_machines(planner, interpreted):
    z, pivot = _sample(planner.functions.layout)
    assert planner.functions.compiled
    one, two = planner.functions.evaluate(z, pivot), interpreted.evaluate(z, pivot)
    assert np.abs(one - two).max() < SAME * np.abs(two).max()
    lam = np.linspace(-1.0, 1.0, planner.functions.layout.outputs)
    hessians = [np.array(f.sides[0][2](z[:, 0], pivot[:, 0], lam, 0.3)) for f in (planner.functions, interpreted)]
    assert np.abs(hessians[0] - hessians[1]).max() < SAME * np.abs(hessians[1]).max()


def test_jacobian_and_hessian_are_those_of_the_values(planner):
    functions = planner.functions
    layout = functions.layout
    z, pivot = _sample(layout, 3)
    z, pivot = z[:, 0], pivot[:, 0]
    jacobian = np.array(functions.sides[0][1](z, pivot)[1])
    lam = np.random.default_rng(5).normal(size=layout.outputs)
    hessian = np.array(functions.sides[0][2](z, pivot, lam, 0.0))
    for k in range(0, layout.inputs, 5):
        step = np.zeros(layout.inputs)
        step[k] = STEP
        ahead, back = functions.sides[0][1](z + step, pivot), functions.sides[0][1](z - step, pivot)
        slope = np.array(ahead[0] - back[0]).ravel() / (2 * STEP)
        assert np.abs(slope - jacobian[:, k]).max() < SLOPE * max(1.0, np.abs(jacobian).max())
        bend = lam @ np.array(ahead[1] - back[1]) / (2 * STEP)
        assert np.abs(bend - hessian[k]).max() < SLOPE * max(1.0, np.abs(hessian).max())


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_a_cache_that_others_may_write_to_is_refused(planner, tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    folder.mkdir()
    folder.chmod(0o777)
    monkeypatch.setenv("GAITSMITH_CACHE_DIR", str(folder))
    with pytest.raises(CacheRefused, match="write"):
        point_functions(planner.biped)


def test_without_a_compiler_the_plan_is_the_same(robot, dynamic, monkeypatch):
    monkeypatch.setenv("GAITSMITH_CC", "none")
    notices = []
    slow = Planner(robot, notices.append)
    found = slow.plan(cyclic(slow.biped, StepParameters(0.20, 0.5)))
    assert not slow.functions.compiled
    assert len(notices) == 1
    assert found.solved
    assert abs(found.objective - dynamic.main.objective) < 1e-3 * dynamic.main.objective
