"""The tour is the published one, and a robot that does what it is told reaches its waypoints."""

from __future__ import annotations

import math
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.simulation.standing import floating, robot

from gaitsmith.errors import BadInput
from gaitsmith.simulation.episode import run_episode
from gaitsmith.simulation.scenario import Tour, make_scenario
from gaitsmith.simulation.tour import LENGTH, SEGMENT, ArmWalk, Guide, punches, waypoints

DT = 1e-3
PRINTED = 1e-12  # digits of the C++ program's output
JOINTS = SimpleNamespace(joint_names=tuple(f"joint_{k}" for k in range(29)))

# First and last waypoint and punch (joint, N) of two run ids, printed by a C++ program with the published formulas.
WAYPOINTS = {
    0: ((0.782998288291, 0.810799756335, 3.122743714856), (-0.419837508293, 0.204011661981, -1.848445725881)),
    7: ((0.373611916261, -0.665872779413, 2.179407698473), (-0.421047319204, 0.509232834613, -2.656064514788)),
}
PUNCHES = {
    0: ((23, 88.6201489014, 70.0843071692, 102.316755306), (14, 375.436373974, -44.7405595383, 145.745929484)),
    7: ((2, -0.691502202413, 112.957917092, 90.3624592907), (17, 123.360214278, -224.636901094, -34.9143476887)),
}


@pytest.mark.parametrize("run_id", WAYPOINTS)
def test_waypoints_and_punches_are_those_of_the_published_program(run_id: int) -> None:
    way, hits = waypoints(run_id), punches(run_id, JOINTS, 3.0)  # type: ignore[arg-type]
    for k, expected in zip((0, -1), WAYPOINTS[run_id], strict=True):
        np.testing.assert_allclose(way[k], expected, atol=PRINTED)
    for k, (joint, *force) in zip((0, -1), PUNCHES[run_id], strict=True):
        assert hits[k].joint == f"joint_{joint}"
        np.testing.assert_allclose(np.array(hits[k].impulse) / hits[k].duration, force, rtol=1e-10)


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 2.0))
@settings(max_examples=20)
def test_a_punch_a_segment_no_harder_than_its_ceiling(run_id: int, factor: float) -> None:
    hits = punches(run_id, JOINTS, 3.0, factor)  # type: ignore[arg-type]
    assert [hit.time for hit in hits] == pytest.approx([3.1 + SEGMENT * k for k in range(18)])
    for k, hit in enumerate(hits):
        ceiling = factor * 500.0 * (1.0 / 3.0 + 2.0 / 3.0 * min(k / 12.0, 1.0))
        assert 0.5 * ceiling <= np.linalg.norm(hit.impulse) / hit.duration * (1.0 + 1e-9)
        assert np.linalg.norm(hit.impulse) / hit.duration <= ceiling * (1.0 + 1e-9)
    assert punches(run_id, JOINTS, 3.0, 0.0) == ()  # type: ignore[arg-type]


class Unicycle:
    """Does at once what it is told: speed in its own heading, and a rate of turn."""

    def __init__(self) -> None:
        self.truth = SimpleNamespace(torso=np.array([0.4, -0.2, 0.7]), attitude=np.array([0.0, 0.0, 0.8]))
        self.control_step, self.q, self.v = DT, np.zeros(7), np.zeros(6)

    def move(self, command: dict, seconds: float) -> None:
        yaw, (forward, left) = self.truth.attitude[2], command["speed"]
        self.truth.torso[0] += seconds * (math.cos(yaw) * forward - math.sin(yaw) * left)
        self.truth.torso[1] += seconds * (math.sin(yaw) * forward + math.cos(yaw) * left)
        self.truth.attitude[2] = math.remainder(yaw + seconds * command["yaw_rate"], 2.0 * math.pi)


@given(st.integers(0, 1000))
@settings(max_examples=10, deadline=None)
def test_who_does_what_it_is_told_arrives(run_id: int) -> None:
    body = Unicycle()
    legs = SimpleNamespace(
        joint_names=(), legs=(), model=_model(""), position_low=np.zeros(0), position_high=np.zeros(0)
    )
    controller = SimpleNamespace(robot=legs, telemetry=SimpleNamespace(torque=np.zeros(0)))
    tour = Tour(id=run_id, forward=1.0, lateral=1.0, yaw_rate=3.0)
    guide, orders = Guide(tour, body, controller, 1.0), []  # type: ignore[arg-type]
    assert guide.poll(0.999) == []
    for k in range(round(LENGTH / 0.02)):
        (order,) = guide.poll(1.0 + 0.02 * k)
        assert guide.poll(1.0 + 0.02 * k) == []
        speed, rate = order.command["speed"], order.command["yaw_rate"]
        assert abs(speed[0]) <= 1.0 + 1e-9
        assert speed[1] ** 6 + (rate / 3.0) ** 6 <= 1.0 + 1e-9  # not both at their limits
        orders.append(order)
        body.move(dict(order.command), 0.02)
    report = guide.report()
    assert [order.action for order in orders] == ["walk"] + [""] * (len(orders) - 1)
    assert [order.told for order in orders].count(True) == 1
    assert len(report.position_error) == len(report.yaw_error_deg) == 18
    assert max(report.position_error) < 0.1
    assert max(report.yaw_error_deg) < math.degrees(0.05)


def _model(arms: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><compiler angle="radian"/><worldbody><body name="torso" pos="0 0 1"><freejoint/>
        <geom size=".1"/>{arms}</body></worldbody></mujoco>"""
    )


def _arm(y: float, sign: int) -> str:
    """A shoulder with two axes and an elbow; the second axis points to the other side if the sign is negative."""
    return f"""<body pos="0 {y} .3"><joint axis="0 1 0" range="-2 2"/><geom size=".05"/>
        <body pos="0 0 0"><joint axis="{sign} 0 0" range="-1 1"/><geom size=".04"/>
        <body pos="0 0 -.3"><joint axis="0 1 0" range="-2 0"/><geom size=".04" pos="0 0 -.2"/></body></body></body>"""


@given(st.integers(0, 2**32 - 1), st.sampled_from([-1, 1]))
@settings(max_examples=10, deadline=None)
def test_arms_walk_mirrored_within_their_limits_with_the_hands_in_front(run_id: int, sign: int) -> None:
    model = _model(_arm(0.2, 1) + _arm(-0.2, sign))
    names = tuple(f"{side}_{name}" for side in ("left", "right") for name in ("pitch", "roll", "elbow"))
    low, high = model.jnt_range[1:].T
    made = SimpleNamespace(joint_names=names, legs=(), model=model, position_low=low, position_high=high)
    home = np.array([0.2, 0.1, -0.6, 0.2, -0.1 * sign, -0.6])
    walks = [ArmWalk(made, run_id, home) for _ in range(2)]  # type: ignore[arg-type]
    data, before, moved = mujoco.MjData(model), home, 0.0
    start = _hand(model, data, home)
    for k in range(500):
        posture = walks[0].posture(0.02 * k)
        assert posture == walks[1].posture(0.02 * k)
        now = np.array([posture[name] for name in names])
        assert now[3] == now[0]
        assert now[4] == -sign * now[1]
        assert np.all((low - 1e-12 <= now) & (now <= high + 1e-12))
        assert np.abs(now - before).max() <= 0.06 + 1e-9  # what one step of the walk allows
        moved = max(moved, float(np.abs(now - home).max()))
        if k % 25 == 24:  # a target is reached
            hand = _hand(model, data, now)
            assert hand[0] >= start[0] - 1e-9
            assert hand[2] <= 1.3 + 1e-9
        before = now
    assert moved > 0.1


def _hand(model: mujoco.MjModel, data: mujoco.MjData, angles: np.ndarray) -> np.ndarray:
    data.qpos[7:] = angles
    mujoco.mj_kinematics(model, data)
    return data.xipos[4]


def test_a_push_at_a_joint_turns_the_body_as_a_force_at_its_anchor_does() -> None:
    plant, force = floating(), np.array([30.0, -20.0, 10.0])
    name = robot().joint_names[2]
    plant.push(force, joint=name)
    model, data = plant._model, plant._data
    expected, found = np.zeros(model.nv), np.zeros(model.nv)
    body = int(model.jnt_bodyid[3])
    mujoco.mj_applyFT(model, data, force, np.zeros(3), data.xanchor[3], body, expected)
    applied = data.xfrc_applied[body]
    mujoco.mj_applyFT(model, data, applied[:3], applied[3:], data.xipos[body], body, found)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert np.abs(found[3:6]).max() > 0.1
    plant.push(np.zeros(3), joint=name)
    assert not data.xfrc_applied.any()
    with pytest.raises(BadInput, match="push\\.joint"):
        plant.push(force, joint="nothing")


def test_a_tour_repeats_to_the_last_bit_and_leads_to_its_waypoint() -> None:
    tour = {"id": 3, "forward": 0.3, "lateral": 0.15, "yaw_rate": 0.0}
    hits = [push.model_dump(mode="json") for push in punches(3, robot(), 1.0, 0.2)[:1]]
    scenario = make_scenario({"duration": 7.0, "tour": tour, "pushes": hits})
    one, two = (run_episode(scenario, robot=robot(), record=False).summary for _ in range(2))
    assert one.tour is not None
    assert not one.fell
    assert one.tour == two.tour
    assert one.torque_peak == two.torque_peak
    assert one.tour.position_error[0] < 0.3
    assert one.tour.energy > 0.0
    assert len(one.stages) == 2


def test_a_tour_takes_no_changes() -> None:
    tour = {"id": 3, "forward": 0.3, "lateral": 0.15, "yaw_rate": 0.0}
    with pytest.raises(BadInput, match="the tour says where to go"):
        make_scenario({"tour": tour, "changes": [{"time": 2.0, "speed": [0.1, 0.0]}]})
