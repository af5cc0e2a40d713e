"""Goals of many points: what is found when they are made, and that the rest is lazy."""

import logging
import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from toy_robot import ARM, ToyRobot

from tool0.control import spline as spline_module
from tool0.control.spline import Motion, Segment
from tool0.control.trajectory import BLOCK, MANY, TrajectoryGoal
from tool0.errors import GoalRejectedError
from tool0.protocol.trajectories import TrajectoryPoint

pytestmark = pytest.mark.slow

LOOSE = ARM.replace("trajectory: 0.1,", "") + "  allow_partial_joints_goal: true\n"
NAMES = ("hip", "slide", "wheel")
sizes = st.floats(-12.0, 12.0)
"""Powers of ten."""


# ---- what is found when the goal is made -------------------------------------------


def still(n_points: int, n_joints: int = 2) -> list[TrajectoryPoint]:
    rest = [0.0] * n_joints
    return [
        TrajectoryPoint(rest, rest, rest, time_from_start=float(k))
        for k in range(n_points)
    ]


def suspects(points: list[TrajectoryPoint]) -> list[int]:
    return list(TrajectoryGoal(points=points).suspects)


@settings(deadline=None)
@given(
    seed=st.integers(0, 2**32),
    size=st.tuples(sizes, sizes, sizes, sizes),
    start=st.floats(0.0, 1e6),
    shift=st.floats(-1e3, 1e3),
)
def test_what_is_no_suspect_is_bounded(
    seed: int, size: tuple[float, ...], start: float, shift: float
) -> None:
    rng = np.random.default_rng(seed)
    spread = 10.0 ** rng.uniform(-4.0, 0.0, (MANY, 4))
    scales = spread * np.power(10.0, size)
    times = np.cumsum(scales[:, 0] + 1e-12)
    numbers = rng.uniform(-1.0, 1.0, (3, MANY, 2)) * scales.T[1:, :, None]
    points = [
        TrajectoryPoint(
            *[*numbers[:order, k], None, None][:3], time_from_start=times[k]
        )
        for k, order in enumerate(rng.integers(1, 4, MANY))
    ]
    for k in set(range(MANY)) - set(suspects(points)):
        begin, end = (start + points[i].time_from_start for i in (k - 1, k))
        for column in range(2):
            first, last = (motion(points[i], column, shift) for i in (k - 1, k))
            assert Segment(begin, first, end, last).is_bounded()


def motion(point: TrajectoryPoint, column: int, shift: float) -> Motion:
    rows = [point.velocities, point.accelerations]
    given = [None if row is None else row[column] for row in rows]
    return Motion(point.positions[column] + shift, *given)


def test_usual_motions_are_no_suspects() -> None:
    rng = np.random.default_rng(0)
    points = [
        TrajectoryPoint(q, 3.0 * q, 50.0 * q, time_from_start=0.001 * k)
        for k, q in enumerate(rng.uniform(-6.0, 6.0, (3 * BLOCK, 6)))
    ]
    assert suspects(points) == [0]


# ---- segments made when they are executed are those made at once -------------------


@dataclass(frozen=True)
class Request:
    """A random goal, and for how many ticks it is followed."""

    seed: int
    n_points: int
    joints: tuple[str, ...] = NAMES
    spacing: float = 1e-3
    orders: tuple[int, ...] = (3,)
    """1 for positions alone; 2 with velocities; 3 with accelerations."""
    wait: float | None = None
    """Until it starts [s]; None for no stamp."""
    fault: str = ""
    n_ticks: int = 10
    cancel: bool = False


requests = st.builds(
    Request,
    seed=st.integers(0, 2**32),
    n_points=st.sampled_from([1, 5, MANY - 1, MANY, 80, BLOCK, BLOCK + 1])
    | st.integers(MANY, 3 * BLOCK),
    joints=st.permutations(NAMES).map(tuple)
    | st.sampled_from([("wheel",), ("slide", "wheel"), ("hip",)]),
    spacing=st.sampled_from([1e-4, 1e-3, 0.7e-3, 0.01]),
    orders=st.sampled_from([(1,), (2,), (3,), (1, 2, 3)]),
    wait=st.none() | st.floats(-0.5, 0.5),
    fault=st.sampled_from(
        ["", "", "", "nan", "order", "count", "limit", "huge", "jump"]
    ),
    n_ticks=st.integers(1, 60),
    cancel=st.booleans(),
)


def points_of(request: Request) -> list[TrajectoryPoint]:
    rng = random.Random(request.seed)
    many = len(request.joints)
    drift = [
        rng.uniform(-1.0, 1.0)
        + (rng.choice([0.0, 9.0, -30.0]) if name == "wheel" else 0)
        for name in request.joints
    ]
    time, points = 0.0, []
    for _ in range(request.n_points):
        time += request.spacing * rng.choice([1.0, 0.5])
        drift = [q + rng.uniform(-1e-3, 1e-3) for q in drift]
        order = rng.choice(request.orders)
        rows = [drift, [rng.gauss(0.0, 1.0) for _ in drift], [0.1] * many]
        rows = [*rows[:order], None, None][:3]
        points.append(TrajectoryPoint(*rows, time_from_start=time))
    victim = rng.randrange(request.n_points)
    points[victim] = spoiled(points[victim], request.fault)
    if request.fault == "jump" and victim > 0:
        just_after = points[victim - 1].time_from_start + 1e-10
        points[victim] = replace(points[victim], time_from_start=just_after)
    return points


def spoiled(point: TrajectoryPoint, fault: str) -> TrajectoryPoint:
    """Return the point with the fault, or as it is if there is no such fault."""
    positions = list(point.positions)
    n = len(positions)
    faults = {
        "nan": {"accelerations": [math.nan] * n},
        "infinite": {"positions": [math.inf] * n},
        "order": {"time_from_start": -1.0},
        "no time": {"time_from_start": math.nan},
        "count": {"velocities": [0.0] * (n + 1)},
        "empty": {"positions": []},
        "limit": {"positions": [*positions[:-1], 6.1]},
        "huge": {"velocities": [1e300] * n},
    }
    return replace(point, **faults.get(fault, {}))


def unexamined(goal: TrajectoryGoal) -> TrajectoryGoal:
    """Return the goal as one of few points is: each is examined at the acceptance."""
    plain = replace(goal)
    object.__setattr__(plain, "suspects", range(len(goal.points)))
    object.__setattr__(plain, "position_ranges", None)
    return plain


class Pair:
    """Two robots with the same requests; one of them makes its segments at once."""

    def __init__(self) -> None:
        self.robots = ToyRobot(LOOSE), ToyRobot(LOOSE)
        self.controllers = tuple(robot.start("arm") for robot in self.robots)
        self.goals = dict.fromkeys(self.controllers)

    def follow(self, request: Request) -> str:
        start = None
        if request.wait is not None:
            start = self.robots[0].time + request.wait
        return self.send(points_of(request), joint_names=request.joints, stamp=start)

    def send(self, points: list[TrajectoryPoint], **options) -> str:
        """Return how both reject the goal, or nothing if they do not."""
        goal = TrajectoryGoal(points=points, **options)
        now = self.robots[0].time
        answers = []
        for controller, sent in zip(
            self.controllers, (goal, unexamined(goal)), strict=True
        ):
            try:
                self.goals[controller] = controller.follow(sent, now)
                answers.append("")
            except GoalRejectedError as error:
                answers.append(str(error))
        assert answers[0] == answers[1]
        return answers[0]

    def compare(self) -> None:
        now = self.robots[0].time
        lazy, eager = self.controllers
        for ours, theirs in zip(
            lazy.setpoint().splines, eager.setpoint().splines, strict=True
        ):
            assert [row for section in ours.sections for row in rows(section)] == [
                row for section in theirs.sections for row in rows(section)
            ]
            for k in range(10):
                time = now + 1e-4 + k * (ours.end - now) / 9.0
                assert ours.sample(time) == theirs.sample(time)
        assert lazy.setpoint().target() == eager.setpoint().target()
        assert lazy.setpoint().state() == eager.setpoint().state()

    def run(self, n_ticks: int) -> None:
        for _ in range(n_ticks):
            for robot in self.robots:
                robot.tick()
            assert self.robots[0].hardware.command == self.robots[1].hardware.command
        assert self.robots[0].position == self.robots[1].position

    def cancel(self) -> None:
        for robot, controller in zip(self.robots, self.controllers, strict=True):
            controller.cancel(self.goals[controller], robot.time)


def rows(section: spline_module.SplineSection) -> list[tuple]:
    """Return every number of a section; its text tells -0.0 from 0.0."""
    segments = map(section.segment, section.span)
    return [
        (repr((each.start, each.end, each.coefficients)), section.tolerances)
        for each in segments
    ]


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.lists(requests, min_size=1, max_size=4))
def test_segments_made_when_executed_are_those_made_at_once(
    sequence: list[Request],
) -> None:
    pair = Pair()
    logging.disable(logging.WARNING)
    try:
        for request in sequence:
            pair.follow(request)
            pair.compare()
            pair.run(request.n_ticks)
            pair.compare()
            if request.cancel:
                pair.cancel()
                pair.compare()
                pair.run(3)
    finally:
        logging.disable(logging.NOTSET)


def test_goals_that_start_later_keep_many_points_before_them() -> None:
    pair = Pair()
    for request in (
        Request(1, 2000),
        Request(2, 1000, wait=0.4),
        Request(3, 400, wait=0.6, joints=("wheel", "slide")),
        Request(4, 3, wait=0.7),
    ):
        assert pair.follow(request) == ""
        pair.compare()
        pair.run(10)
    assert len(pair.controllers[0].setpoint().splines[2].sections) == 4
    pair.run(700)
    pair.compare()
    assert pair.follow(Request(5, 2)) == ""
    pair.compare()
    for spline in pair.controllers[0].setpoint().splines:
        assert [len(section.span) for section in spline.sections] == [1, 2]


@pytest.mark.parametrize(
    "fault",
    ["nan", "infinite", "order", "no time", "count", "empty", "limit", "huge"],
)
@pytest.mark.parametrize("victim", [0, 1, BLOCK - 1, BLOCK, 2 * BLOCK])
def test_one_wrong_point_of_many_is_found(fault: str, victim: int) -> None:
    pair = Pair()
    points = points_of(Request(0, 2 * BLOCK + 1, joints=("wheel", "slide", "hip")))
    if fault == "order":  # of the first point and the second it is the second
        victim = max(victim, 1)
    points[victim] = spoiled(points[victim], fault)
    assert pair.send(points, joint_names=("wheel", "slide", "hip"))
    pair.compare()


# ---- the tick does not wait --------------------------------------------------------


class Counted(Sequence):
    """Counts which of the points are read."""

    def __init__(self, points: Sequence[TrajectoryPoint]) -> None:
        self.points = points
        self.n_read = 0

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, index: int) -> TrajectoryPoint:
        self.n_read += 1
        return self.points[index]


@pytest.mark.parametrize("stamp", [None, -0.5])
def test_accepting_100_000_points_reads_a_few_and_makes_few_segments(
    stamp: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []

    def counted(*args) -> Segment:
        made.append(args)
        return Segment(*args)

    monkeypatch.setattr(spline_module, "Segment", counted)
    robot = ToyRobot(LOOSE)
    controller = robot.start("arm")
    robot.tick()
    still_there = TrajectoryPoint([0.1] * 3, [0.0] * 3, time_from_start=0.0)
    points = [replace(still_there, time_from_start=1e-3 * k) for k in range(100_000)]
    goal = TrajectoryGoal(points=points, stamp=stamp)
    read = Counted(goal.points)
    object.__setattr__(goal, "points", read)
    made.clear()
    controller.follow(goal, robot.time)
    for n_ticks in range(1, 10):
        robot.tick()
        assert len(made) <= 3 * len(NAMES) * n_ticks
        assert read.n_read <= 6 * len(NAMES) * n_ticks
