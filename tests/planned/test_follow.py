"""The law that follows a plan: the plan itself on its own footholds, and a pendulum's motion on others."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.planned.plans import DOUBLE, HEIGHT, JOINTS, SINGLE, STEP, WIDTH, two_steps

from gaitsmith.compiled import Arena
from gaitsmith.planned.clock import EARLY, make_plan_clock
from gaitsmith.planned.evaluate import make_plan_sample
from gaitsmith.planned.follow import follow
from gaitsmith.planned.footholds import _room
from gaitsmith.planned.law import make_following
from gaitsmith.robots.sole import Sole
from gaitsmith.whole_body.reference import NONE, make_reference

DT = 1e-3
SOLE = Sole(kind="rectangle", heel=0.06, toe=0.1, half_width=0.045)
ROBOT = SimpleNamespace(
    legs=[SimpleNamespace(sole=SOLE)] * 2,
    joint_names=["joint"] * JOINTS,
    mass=20.0,
    model=SimpleNamespace(opt=SimpleNamespace(gravity=np.array([0.0, 0.0, -9.81]))),
)


POLYGON = Sole.model_validate({"kind": "polygon", "points": ((-0.06, -0.03), (0.1, 0.0), (0.02, 0.045), (-0.06, 0.03))})


@pytest.mark.parametrize("sole", [SOLE, POLYGON], ids=["rectangle", "polygon"])
@pytest.mark.parametrize(("axis", "sign"), [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)])
def test_the_room_of_a_centre_of_pressure_ends_at_the_margin_from_an_edge(sole, axis, sign):
    machine = SimpleNamespace(**{**vars(ROBOT), "legs": [SimpleNamespace(sole=sole)] * 2})
    following = make_following(machine, SimpleNamespace(table=two_steps(2), height=HEIGHT))
    cop, effort = np.array([0.01, 0.002]), following.sample.effort
    effort[-6:] = 0.0, 0.0, 50.0, 50.0 * cop[1], -50.0 * cop[0], 0.0
    cop[axis] += sign * _room(Arena(following), 1, axis, sign)
    gaps = sole.edges[:, 2] - sole.edges[:, :2] @ cop
    assert gaps.min() == pytest.approx(following.law.margin, abs=1e-12)


class World:
    """Soles that go where they are told, and land displaced; a CoM that does what the reference says."""

    def __init__(self, heading=0.0, misses=(0.0, 0.0), offset=(0.0, 0.0, 0.0), passes=2):
        plan = SimpleNamespace(table=two_steps(passes), height=HEIGHT)
        self.following = make_following(ROBOT, plan)
        self.reference = make_reference(2, JOINTS)
        cos, sin = np.cos(heading), np.sin(heading)
        self.turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        self.soles = np.array([[0.0, 0.0, 0.0], [-STEP, -WIDTH, 0.0]]) @ self.turn.T + offset
        self.com = self.turn @ (0.0, -0.5 * WIDTH, HEIGHT) + offset
        self.speed = np.zeros(3)
        self.misses = np.array([*misses, 0.0])
        self.first = True

    def tick(self, force=0.0, push=(0.0, 0.0, 0.0)):
        given, soles = self.reference, self.soles
        rotation = np.tile(self.turn, (2, 1, 1))
        forces = np.where(given.contact == NONE, force, 100.0)
        if self.first:
            forces[:] = 0.0
        com = self.com + push
        event = follow(self.following, soles, rotation, com, self.speed, forces, given, DT)
        for row in range(2):
            if given.contact[row] == NONE:
                soles[row] = given.sole_position[row] + self.turn @ self.misses
        self.com, self.speed = given.com[0].copy(), given.com[1].copy()
        self.first = False
        return event

    def run(self, duration, landing=True):
        for _ in range(round(duration / DT)):
            time = self.following.clock.time[0]
            self.tick(force=100.0 if landing and time > SINGLE - 1.5 * DT else 0.0)
        return self


@pytest.mark.parametrize("heading", [0.0, 1.2])
def test_on_its_own_footholds_the_reference_is_the_plan(heading):
    world = World(heading, offset=(3.0, -2.0, 0.1))
    world.run(SINGLE + 0.5 * DOUBLE)
    speed = STEP / (SINGLE + DOUBLE)
    along = world.turn.T @ (world.reference.com[0] - (3.0, -2.0, 0.1))
    expected = speed * (SINGLE + 0.5 * DOUBLE) - 0.5 * STEP + 0.5 * speed * DOUBLE
    np.testing.assert_allclose(along, (expected, -0.5 * WIDTH, HEIGHT), atol=3e-3)
    np.testing.assert_allclose(world.turn.T @ world.reference.com[1], (speed, 0.0, 0.0), atol=0.03)
    np.testing.assert_allclose(world.following.state.foothold, 0.0, atol=1e-12)


def test_a_plan_goes_on_along_the_sole_that_bears_next():
    world, yaw = World(), 0.3
    place = world.following.plan.place
    place[1, 1, 3] = yaw
    place[2, 0] = -np.cos(yaw) * STEP + np.sin(yaw) * WIDTH, np.sin(yaw) * STEP + np.cos(yaw) * WIDTH, 0.0, -yaw
    world.run(SINGLE + DOUBLE + 0.01)
    state = world.following.state
    assert state.heading[0] == pytest.approx(yaw)
    np.testing.assert_allclose(state.place[1], world.soles[1], atol=1e-12)
    np.testing.assert_allclose(state.anchor[0], world.soles[1], atol=3e-3)


def test_the_reference_moves_with_footholds_that_miss_and_stays_smooth():
    world = World(misses=(0.02, 0.01), passes=6)
    before, largest = None, 0.0
    for _ in range(round(8.0 * (SINGLE + DOUBLE) / DT)):
        world.tick(force=100.0 if world.following.clock.time[0] > SINGLE - 1.5 * DT else 0.0)
        if before is not None:
            largest = max(largest, float(np.abs(world.reference.com[0] - before).max()))
        before = world.reference.com[0].copy()
    assert largest < 2.0 * DT * STEP / (SINGLE + DOUBLE)


def test_steps_that_fall_short_are_made_up_for():
    """The integral of the speed: a sole that always lands 2 cm short is sent 2 cm further."""
    world = World(misses=(-0.02, 0.0), passes=12)
    world.run(16.0 * (SINGLE + DOUBLE))
    np.testing.assert_allclose(world.following.state.bias[:, 0], 0.02, atol=2e-3)


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_foothold_moves_towards_where_the_robot_falls(axis, sign):
    world, push = World(), np.zeros(3)
    push[axis] = sign * 0.08
    for _ in range(round(0.1 / DT)):
        world.tick(push=push)
    shift = world.following.state.foothold[1, axis]
    inward = axis == 1 and sign > 0.0
    law = world.following.law
    assert 0.0 < sign * shift <= (law.reach[axis] if not inward else WIDTH - law.separation) + 1e-12


def test_pushed_over_its_stance_leg_the_robot_waits_and_pushed_away_from_it_it_does_not():
    times = []
    for push in (0.0, 0.05, -0.05):
        world = World()
        for _ in range(round(0.1 / DT)):
            world.tick(push=np.array([0.0, push, 0.0]))
        times.append(float(world.following.clock.time[0]))
    plain, over, away = times
    assert plain == pytest.approx(0.1)
    assert over < 0.7 * plain
    assert away == pytest.approx(plain)


def test_in_flight_neither_clock_nor_footholds_answer_to_a_push():
    world, push = World(), np.array([0.0, 0.05, 0.0])
    world.following.plan.contact[0] = NONE
    for _ in range(round(0.1 / DT)):
        world.tick(push=push)
    assert world.following.clock.time[0] == pytest.approx(0.1)
    np.testing.assert_array_equal(world.following.state.foothold, 0.0)


def test_small_errors_are_left_to_the_centre_of_pressure():
    world = World()
    for _ in range(round(0.05 / DT)):
        world.tick(push=np.array([0.004, 0.004, 0.0]))
    np.testing.assert_array_equal(world.following.state.foothold, 0.0)


def test_a_sole_that_waits_for_the_ground_goes_down():
    world = World().run(SINGLE + 0.02, landing=False)
    law = world.following.law
    assert world.reference.sole_velocity[1, 2] == -law.descent_speed
    assert world.reference.sole_position[1, 2] == pytest.approx(-0.02 * law.descent_speed, rel=0.2)
    assert world.tick(force=100.0) > EARLY


def test_a_plan_at_its_end_stands_still():
    world = World(passes=1).run(2.0 * (SINGLE + DOUBLE) + 0.1)
    assert world.following.clock.ended[0] == 1
    np.testing.assert_array_equal(world.reference.joint[1:], 0.0)
    np.testing.assert_array_equal(world.reference.sole_velocity, 0.0)


def test_without_a_plan_there_is_room_for_one():
    following = make_following(ROBOT)
    assert len(following.plan.sequence) == 1
    assert len(make_plan_clock().touchdowns) == 4
    assert make_plan_sample(2, JOINTS).motion.shape == (3, 18 + JOINTS)
