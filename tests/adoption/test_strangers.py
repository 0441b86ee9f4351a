"""Public robots that nobody here described: those that can walk are adopted and walk, the others are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from gaitsmith.adoption.adopting import adopt
from gaitsmith.adoption.options import AdoptOptions
from gaitsmith.errors import BadInput

pytestmark = pytest.mark.strangers

ALEXANDER_SOLE = (0.055, 0.156, 0.048, 0.084)  # m; its model has no collision shapes


@pytest.mark.parametrize(
    ("name", "sole"),
    [
        ("g1_29dof_rev_1_0", None),
        ("g1_29dof_with_hand_rev_1_0", None),
        ("talos_full_v2", None),
        ("talos_reduced", None),
        ("romeo_small", None),
        ("romeo_laas_small", None),
        ("alexander_v1.lowerBodyOnly", ALEXANDER_SOLE),
    ],
)
def test_humanoids_are_adopted_and_walk(name: str, sole: tuple[float, ...] | None, tmp_path: Path) -> None:
    adoption = adopt(AdoptOptions(model=name, out=str(tmp_path / "out"), sole=sole, no_sheet=True))
    assert adoption.ok, [test.line() for test in adoption.tests]


@pytest.mark.parametrize("name", ["alexander_v1.lowerBodyOnly", "simple_humanoid", "human"])
def test_soles_of_feet_without_shapes_are_asked_for(name: str, tmp_path: Path) -> None:
    adoption = adopt(AdoptOptions(model=name, out=str(tmp_path / "out")))
    assert adoption.card is None
    assert [entry["flag"] for entry in adoption.document["asked"]] == ["--sole"]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "name",
    [
        "a1",
        "go2",
        "hyq_no_sensors",
        "panda",
        "ur10_robot",
        "tiago",
        "bolt",
        "alex_nub_hands",
        "double_pendulum",
        "iris",
    ],
)
def test_what_is_no_biped_is_refused_in_one_sentence(name: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput) as caught:
        adopt(AdoptOptions(model=name, out=str(tmp_path / "out")))
    assert "two legs" in str(caught.value)
    assert "\n" not in str(caught.value)
