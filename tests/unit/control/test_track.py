"""Tracks of many points are those of few, but for when their pieces are made."""

import logging
import math
import random
from dataclasses import dataclass, replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from toy_robot import ARM, ToyRobot

from tool0.control import playback as playback_module
from tool0.control import track as track_module
from tool0.control.point_survey import BLOCK, MANY
from tool0.control.segment import Segment
from tool0.control.track import LongTrack, Piece, Track
from tool0.control.trajectory import TrajectoryGoal, TrajectoryPoint
from tool0.errors import GoalRejectedError

LOOSE = ARM.replace("trajectory: 0.1,", "") + "  allow_partial_joints_goal: true\n"
NAMES = ("hip", "slide", "wheel")


@dataclass(frozen=True)
class Request:
    """A random goal, and for how many ticks it is followed."""

    seed: int
    n_points: int
    joints: tuple[str, ...]
    spacing: float
    orders: tuple[int, ...]
    """1 for positions alone; 2 with velocities; 3 with accelerations."""
    wait: float | None
    """Until it starts [s]; None for no stamp."""
    fault: str
    n_ticks: int
    cancel: bool


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
    positions = list(point.positions)
    if fault == "nan":
        return replace(point, accelerations=[math.nan] * len(positions))
    if fault == "order":
        return replace(point, time_from_start=-1.0)
    if fault == "count":
        return replace(point, velocities=[0.0] * (len(positions) + 1))
    if fault == "limit":
        return replace(point, positions=[*positions[:-1], 6.1])
    if fault == "huge":
        return replace(point, velocities=[1e300] * len(positions))
    return point


def unsurveyed(goal: TrajectoryGoal) -> TrajectoryGoal:
    """Return the goal as one of few points is: all of them are looked at at once."""
    plain = replace(goal)
    object.__setattr__(plain, "survey", None)
    return plain


def rows(track: Track, handle: object) -> list[tuple]:
    """Return every number of a track, by its pieces."""
    return [row(piece, handle) for piece in track]


def row(piece: Piece, handle: object) -> tuple:
    segment, goal, tolerances, time = piece
    # Its text tells -0.0 from 0.0.
    numbers = repr((segment.start, segment.end, segment.coefficients, time))
    return numbers, goal is handle, goal is None, tolerances


class Pair:
    """Two robots that are asked the same; one of them makes its pieces at once."""

    def __init__(self) -> None:
        self.robots = ToyRobot(LOOSE), ToyRobot(LOOSE)
        self.controllers = tuple(robot.start("arm") for robot in self.robots)

    def follow(self, request: Request) -> str:
        start = None
        if request.wait is not None:
            start = self.robots[0].time + request.wait
        return self.ask(points_of(request), joint_names=request.joints, stamp=start)

    def ask(self, points: list[TrajectoryPoint], **options) -> str:
        """Return how both reject the goal, or nothing if they do not."""
        goal = TrajectoryGoal(points=points, **options)
        now = self.robots[0].time
        answers = []
        for controller, asked in zip(
            self.controllers, (goal, unsurveyed(goal)), strict=True
        ):
            try:
                controller.follow(asked, now)
                answers.append("")
            except GoalRejectedError as error:
                answers.append(str(error))
        assert answers[0] == answers[1]
        return answers[0]

    def compare(self) -> None:
        now = self.robots[0].time
        lazy, eager = self.controllers
        for ours, theirs in zip(
            lazy.setpoint().tracks, eager.setpoint().tracks, strict=True
        ):
            assert not isinstance(theirs, LongTrack)
            assert rows(ours, lazy.active_goal) == rows(theirs, eager.active_goal)
            assert len(ours) == len(theirs)
            assert row(ours[-1], None) == row(theirs[-1], None)
            times = {
                now,
                *(piece.segment.start for piece in theirs[:: len(theirs) // 9 + 1]),
            }
        for time in times:
            later = max(time, now) + 1e-4
            assert lazy.query_state(later) == eager.query_state(later)
        assert lazy.setpoint().target() == eager.setpoint().target()
        assert lazy.state() == eager.state()

    def run(self, n_ticks: int) -> None:
        for _ in range(n_ticks):
            for robot in self.robots:
                robot.tick()
            assert self.robots[0].hardware.command == self.robots[1].hardware.command
        assert self.robots[0].position == self.robots[1].position

    def cancel(self) -> None:
        for robot, controller in zip(self.robots, self.controllers, strict=True):
            controller.cancel(controller.active_goal, robot.time)


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.lists(requests, min_size=1, max_size=4))
def test_pieces_made_when_played_are_those_made_at_once(asked: list[Request]) -> None:
    pair = Pair()
    logging.disable(logging.WARNING)
    try:
        for request in asked:
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


def plain(n_points: int, wait: float | None, **options) -> Request:
    return Request(
        **{
            "seed": n_points,
            "n_points": n_points,
            "joints": NAMES,
            "spacing": 1e-3,
            "orders": (3,),
            "wait": wait,
            "fault": "",
            "n_ticks": 20,
            "cancel": False,
            **options,
        }
    )


def test_goals_that_start_later_keep_long_ways_before_them() -> None:
    pair = Pair()
    for request in (
        plain(2000, None),
        plain(1000, 0.4),
        plain(400, 0.6, joints=("wheel", "slide")),
        plain(3, 0.7),
    ):
        assert pair.follow(request) == ""
        pair.compare()
        pair.run(10)
    long = pair.controllers[0].setpoint().tracks[2]
    assert isinstance(long, LongTrack)
    assert len(long.parts) == 4
    pair.run(700)
    pair.compare()
    assert pair.follow(plain(2, None)) == ""
    pair.compare()
    tracks = pair.controllers[0].setpoint().tracks
    assert all(isinstance(track, tuple) for track in tracks), "and nothing is left"


@pytest.mark.parametrize("fault", ["nan", "order", "count", "limit", "huge"])
@pytest.mark.parametrize("victim", [0, 1, BLOCK, 1999])
def test_one_wrong_point_of_many_is_found(fault: str, victim: int) -> None:
    pair = Pair()
    points = points_of(plain(2000, None, joints=("wheel", "slide", "hip")))
    if fault == "order":  # of the first point and the second it is the second
        victim = max(victim, 1)
    points[victim] = spoiled(points[victim], fault)
    assert pair.ask(points, joint_names=("wheel", "slide", "hip"))
    pair.compare()


@pytest.mark.parametrize("index", [0, 1, 70, 2000, -1, -2000, -2001])
def test_a_long_track_is_a_sequence(index: int) -> None:
    pair = Pair()
    pair.follow(plain(2000, None))
    long, short = (each.setpoint().tracks[0] for each in pair.controllers)
    assert len(long) == len(short) == 2001
    assert row(long[index], None)[0] == row(short[index], None)[0]
    for end in (index + 1, index + 49, index + 300, -3):
        ours, theirs = long[index:end], short[index:end]
        assert [row(piece, None)[0] for piece in ours] == [
            row(piece, None)[0] for piece in theirs
        ]
    ours, theirs = long[index::-7], short[index::-7]
    assert [row(piece, None)[0] for piece in ours] == [
        row(piece, None)[0] for piece in theirs
    ]
    for beyond in (2001, -2002):
        with pytest.raises(IndexError):
            long[beyond]


def test_accepting_many_points_makes_as_many_pieces_as_a_few(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = []

    def counted(*args) -> Segment:
        made.append(args)
        return Segment(*args)

    monkeypatch.setattr(track_module, "Segment", counted)
    monkeypatch.setattr(playback_module, "Segment", counted)
    robot = ToyRobot(LOOSE)
    controller = robot.start("arm")
    robot.tick()
    controller.follow(TrajectoryGoal(points=points_of(plain(20_000, None))), robot.time)
    assert len(made) <= 3 * len(NAMES)
    robot.tick()
    assert len(made) <= 6 * len(NAMES)
