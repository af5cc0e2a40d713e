"""Arms over the Unix socket: their updates, and streams of targets without replies."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import waits
from served import serving, use_folder

import tool0
from tool0.errors import ControlError, Tool0Error
from tool0.protocol.arm_motion import (
    ReadArmMotion,
    ReturnArm,
    ServoJoints,
    SpeedJoints,
    StopArm,
    TakeArm,
)
from tool0.protocol.bus import Subscription
from tool0.protocol.socket_channel import SocketChannel
from tool0.protocol.state import ArmSample
from tool0.protocol.subscriptions import Subscribe

pytestmark = pytest.mark.slow

LONG = 30.0  # [wall s]; only a failing test waits so long


def of_arm(name: str) -> Subscribe:
    fields = ("joint_names", "position", "arms")
    return Subscribe(rate=500.0, fields=fields, arms=(name,), newest_only=True)


class Client:
    """A connection of a program that moves the arm."""

    def __init__(self) -> None:
        self.channel = SocketChannel("tool0")
        self.refusals: queue.Queue[Tool0Error] = queue.Queue()
        self.states: Subscription | None = None
        self.channel.when_refused = self.refusals.put

    def arm(self) -> ArmSample:
        """Return the arm in the next state."""
        assert self.states is not None
        snapshot = self.states.following(LONG)
        assert snapshot is not None
        return snapshot.arms["arm"]

    def until(self, mode: str) -> ArmSample:
        return self.first(lambda arm: arm.mode == mode, mode)

    def first(self, is_it: Callable[[ArmSample], bool], what: str) -> ArmSample:
        """Return the first update of the arm that is wanted."""
        arm: ArmSample | None = None

        def has_come() -> bool:
            nonlocal arm
            arm = self.arm()
            return is_it(arm)

        waits.until(has_come, lambda: f"{what}, last {arm}", period=0.0)
        assert arm is not None
        return arm

    def subscribe(self) -> None:
        self.states = self.channel.follow(of_arm("arm"))


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(gripper=None) as robot:
        yield robot


@pytest.fixture
def client(robot: tool0.Robot) -> Iterator[Client]:
    with serving(robot):
        client = Client()
        yield client
        robot.resume()
        client.channel.call(ReturnArm())
        waits.until(lambda: robot.arm.motion.state.mode == "free", "it is free")
        client.channel.close()


def test_every_update_has_the_arms_that_were_asked_for(client: Client) -> None:
    client.subscribe()
    free = client.arm()
    assert (free.mode, free.path, free.is_done) == ("free", 0, True)
    client.channel.call(TakeArm(by="test"))
    held = client.until("hold")
    assert held.setpoint.positions == pytest.approx(free.setpoint.positions, abs=0.05)
    assert len(held.wrench) == 6
    with pytest.raises(ControlError, match="no arm 'left'"):
        client.channel.call(of_arm("left"))


@pytest.mark.parametrize("names", [("first", "second"), ("panel", "panel")])
@pytest.mark.parametrize("arm", [None, "arm"])
def test_a_client_that_ends_stops_nobody_elses_arm(
    robot: tool0.Robot, client: Client, names: tuple[str, str], arm: str | None
) -> None:
    other = Client()
    other.channel.call(TakeArm(arm="arm", by=names[0]))
    client.channel.call(TakeArm(arm=arm, by=names[1]))
    velocities = (0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
    client.channel.call(SpeedJoints(velocities=velocities, timeout=LONG))
    other.channel.close()
    robot.run(0.3)
    assert robot.arm.control_box.state.taken_by == names[1]
    assert client.channel.call(ReadArmMotion()).mode == "speed"


def test_an_arm_is_returned_when_its_client_ends(
    robot: tool0.Robot, client: Client
) -> None:
    """Also if another one asked in vain to return it."""
    other = Client()
    other.channel.call(TakeArm(by="owner"))
    client.channel.call(ReturnArm(by="another"))
    other.channel.close()
    assert robot.channel.wait_until(
        lambda: not robot.arm.control_box.state.taken_by, LONG
    )


def test_only_who_moves_an_arm_returns_it_by_name(
    robot: tool0.Robot, client: Client
) -> None:
    client.channel.call(TakeArm(by="test"))
    client.channel.call(ReturnArm(by="another"))
    robot.run(0.2)
    assert robot.arm.control_box.state.taken_by == "test"
    client.channel.call(ReturnArm(by="test"))
    robot.run(0.2)
    assert robot.arm.control_box.state.taken_by == ""


def test_streamed_targets_are_executed_one_by_one(
    robot: tool0.Robot, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None is dropped or delayed, also while time stands still; the last one counts."""
    client.subscribe()
    client.channel.call(TakeArm(by="test"))
    start = client.until("hold").setpoint.positions
    controller = robot.simulation.core.arms.find(None).motion.controller
    aimed: queue.Queue[float] = queue.Queue()
    check = controller.require_positions

    def note(positions: tuple[float, ...], now: float) -> None:
        aimed.put(positions[0])
        check(positions, now)

    monkeypatch.setattr(controller, "require_positions", note)
    robot.pause()
    targets = [start[0] + 0.001 * k for k in range(200)]
    for target in targets:
        positions = (target, *start[1:])
        client.channel.post(ServoJoints(positions=positions, timeout=LONG))
    assert [aimed.get(timeout=LONG) for _ in targets] == targets
    robot.resume()
    end = targets[-1] - 0.01
    client.first(
        lambda arm: arm.mode == "servo" and arm.setpoint.positions[0] >= end, "the end"
    )


def test_a_refused_target_is_reported(client: Client) -> None:
    client.channel.post(ServoJoints(positions=(0.0,) * 6))
    error = client.refusals.get(timeout=LONG)
    assert "no program moves the arm" in str(error)
    client.channel.call(TakeArm(by="test"))
    client.channel.post(ServoJoints(positions=(9.0,) * 6))
    assert "beyond its limits" in str(client.refusals.get(timeout=LONG))


def test_a_target_does_not_overtake_the_request_before_it(client: Client) -> None:
    client.subscribe()
    client.channel.call(TakeArm(by="test"))
    start = client.until("hold").setpoint.positions
    for _ in range(20):
        client.channel.submit(StopArm(), lambda outcome: outcome())
        client.channel.post(ServoJoints(positions=start))
        assert client.channel.call(ReadArmMotion()).mode == "servo"


@pytest.mark.slow
def test_while_time_runs_fast_updates_have_the_arms_of_their_instant() -> None:
    with tool0.bringup(gripper=None, realtime=False) as robot, serving(robot):
        client = Client()
        client.channel.call(TakeArm(by="test"))
        client.subscribe()
        is_over = threading.Event()

        def run() -> None:
            while not is_over.is_set():
                robot.run(0.5)

        runner = threading.Thread(target=run)
        runner.start()
        try:
            client.until("hold")
            motion = robot.arm.motion
            goal = tuple(q + 0.3 for q in motion.state.setpoint.positions)
            path = motion.execute_path([60.0], [goal], [(0.0,) * 6])
            arm = client.first(lambda arm: arm.path == path and arm.is_done, "its end")
            assert arm.setpoint.positions == pytest.approx(goal)
            assert arm.path_time == 60.0
        finally:
            is_over.set()
            runner.join()
            client.channel.close()


def test_an_arm_comes_to_rest_when_the_program_that_took_it_is_gone(
    client: Client, robot: tool0.Robot
) -> None:
    client.subscribe()
    other = Client()
    other.channel.call(TakeArm(by="other"))
    other.channel.post(SpeedJoints(velocities=(0.2, 0, 0, 0, 0, 0), acceleration=2.0))
    client.until("speed")
    other.channel.close()
    client.until("free")
    assert robot.arm.control_box.state.taken_by == ""
