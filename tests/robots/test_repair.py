"""Inertias that no body can have are made possible, the others left alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gaitsmith.robots.model_file import open_model

INERTIAS = {
    "good": (0.02, 0.03, 0.04, 0.0, 0.0, 0.001),
    "flat": (0.01, 0.02, 0.03, 0.0, 0.0, 0.0),
    "unbalanced": (0.01, 0.01, 0.05, 0.0, 0.0, 0.0),
    "indefinite": (0.01, 0.01, 0.01, 0.02, 0.0, 0.0),
    "negative": (-0.01, 0.02, 0.02, 0.0, 0.0, 0.0),
    "none": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
}


def urdf(inertia: tuple[float, ...], mass: float = 2.0, shape: str = "") -> str:
    numbers = " ".join(f'{n}="{v}"' for n, v in zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), inertia, strict=True))
    inertial = f'<inertial><origin xyz="0 0 .1"/><mass value="{mass}"/><inertia {numbers}/></inertial>'
    base = '<inertial><mass value="3"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    return (
        f'<robot name="r"><link name="base">{base}</link><link name="part">{inertial if mass else ""}{shape}</link>'
        '<link name="tip"/><joint name="j" type="revolute"><parent link="base"/><child link="part"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="5" velocity="0"/></joint>'
        '<joint name="f" type="fixed"><parent link="part"/><child link="tip"/></joint></robot>'
    )


@pytest.mark.parametrize("case", INERTIAS)
def test_inertias_become_possible(tmp_path: Path, case: str) -> None:
    (tmp_path / "r.urdf").write_text(urdf(INERTIAS[case]))
    file = open_model(tmp_path / "r.urdf")
    inertia = np.sort(file.model.body("part").inertia)
    assert inertia[0] > 0.0
    assert inertia[0] + inertia[1] >= inertia[2] * (1.0 - 1e-6)
    assert file.model.body("part").mass == 2.0
    assert any("repaired" in note and "part" in note for note in file.notes) == (case not in ("good", "flat"))
    if case == "flat":
        assert inertia == pytest.approx([0.01, 0.02, 0.03])


def test_links_that_move_without_mass_get_a_little(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(urdf(INERTIAS["none"], mass=0.0))
    file = open_model(tmp_path / "r.urdf")
    assert 0.0 < file.model.body("part").mass < 1e-5 * file.model.body_mass.sum()
    assert any("without mass" in note for note in file.notes)
    assert file.limits["j"].torque == 5.0
    assert file.limits["j"].velocity is None
