"""Gamepads and SpaceMice as teleoperators: what moves, and what does not."""

from __future__ import annotations

import signal
import struct
import subprocess
import sys
from collections.abc import Iterator, Sequence

import numpy as np
import pytest

pytest.importorskip("lerobot.policies")
pytest.importorskip("lerobot_robot_tool0")

from lerobot.processor.hil_processor import HasTeleopEvents
from lerobot.teleoperators.utils import TeleopEvents
from lerobot_robot_tool0 import (
    Tool0Gamepad,
    Tool0GamepadConfig,
    Tool0Robot,
    Tool0RobotConfig,
    Tool0SpaceMouseConfig,
    jogging,
    spacemouse,
)
from lerobot_robot_tool0.gamepad import Gamepad, pygame
from lerobot_robot_tool0.jogging import ArmJog
from lerobot_robot_tool0.spacemouse import SpaceMouse
from virtual_gamepad import VirtualGamepad

import tool0
from tool0.errors import ConfigError, ControlError

SHOULDER = pygame.CONTROLLER_BUTTON_LEFTSHOULDER
FORWARD = pygame.CONTROLLER_AXIS_LEFTY
FPS = 25
SPEED = 0.1
STILL = 2e-3
"""Of the way [m, rad]: the wrist creeps a little after it has braked."""


@pytest.fixture
def pad() -> Iterator[VirtualGamepad]:
    gamepad = VirtualGamepad()
    yield gamepad
    gamepad.unplug()


class Rig:
    """LeRobot's loop of a gamepad and a robot, in simulated time that a test passes."""

    def __init__(self, pad: VirtualGamepad) -> None:
        self.pad = pad
        self.world = tool0.connect()
        self.teleop = Tool0Gamepad(Tool0GamepadConfig(speed=SPEED))
        self.robot = Tool0Robot(Tool0RobotConfig(fps=FPS))
        self.teleop.connect()
        self.robot.connect()

    def loop(self, duration: float = 0.4) -> dict[str, float]:
        """Pass the loop's actions on; return the last one."""
        for _ in range(round(duration * FPS)):
            action = self.teleop.get_action()
            self.robot.send_action(action)
            self.world.run(1.0 / FPS)
        return action

    def moved(self, duration: float = 0.6) -> np.ndarray:
        """Return the way of the tool [m, rad], shape (6,), while the loop runs."""
        before = self.world.arm.pose()
        self.loop(duration)
        after = self.world.arm.pose()
        turn = after @ before.inverse()
        way = after.matrix[:3, 3] - before.matrix[:3, 3]
        return np.array([*way, *turn.rotation_vector])

    def hold_forward(self) -> None:
        self.pad.press(SHOULDER)
        self.pad.push(FORWARD, -1.0)

    def assert_only_a_fresh_push_moves(self) -> None:
        """The stick is held forward: nothing moves before it was in the middle."""
        assert np.abs(self.moved()).max() < STILL
        self.pad.push(FORWARD, 0.0)
        self.loop(0.1)
        self.pad.push(FORWARD, -1.0)
        assert self.moved()[0] > 0.02


@pytest.fixture
def rig(pad: VirtualGamepad, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    with tool0.bringup(realtime=False) as world:
        monkeypatch.setattr(tool0, "connect", lambda name="tool0": world)
        monkeypatch.setattr(jogging, "_PAUSE", 30.0)  # a test may stand still
        found = Rig(pad)
        yield found
        found.teleop.disconnect()


@pytest.mark.parametrize(
    ("axis", "share", "column", "sign"),
    [
        (pygame.CONTROLLER_AXIS_LEFTY, -1.0, 0, 1),
        (pygame.CONTROLLER_AXIS_LEFTX, -1.0, 1, 1),
        (pygame.CONTROLLER_AXIS_TRIGGERRIGHT, 1.0, 2, 1),
        (pygame.CONTROLLER_AXIS_TRIGGERLEFT, 1.0, 2, -1),
        (pygame.CONTROLLER_AXIS_RIGHTX, 1.0, 3, 1),
        (pygame.CONTROLLER_AXIS_RIGHTY, -1.0, 4, 1),
    ],
)
def test_each_axis_moves_the_tool_along_its_own_until_it_is_let_go(
    rig: Rig, axis: int, share: float, column: int, sign: int
) -> None:
    rig.loop(0.2)
    rig.pad.press(SHOULDER)
    rig.pad.push(axis, share)
    way = rig.moved(0.8) * sign
    assert way[column] > (0.05 if column < 3 else 0.2)
    others = np.delete(way, column)
    assert np.abs(others).max() < 0.05 * way[column]
    rig.pad.push(axis, 0.0)
    rig.loop(0.3)
    assert np.abs(rig.moved()).max() < STILL


def test_nothing_moves_without_the_shoulder_button(rig: Rig) -> None:
    rig.loop(0.2)
    rig.pad.push(FORWARD, -1.0)
    rig.pad.press(pygame.CONTROLLER_BUTTON_A)
    assert np.abs(rig.moved()).max() < STILL
    assert rig.world.gripper.opening > 0.08


def test_a_stick_that_is_held_at_the_start_moves_nothing(rig: Rig) -> None:
    rig.hold_forward()
    rig.assert_only_a_fresh_push_moves()


def test_the_arm_holds_while_the_gamepad_is_unplugged_and_after_it(rig: Rig) -> None:
    rig.loop(0.2)
    rig.hold_forward()
    assert rig.moved()[0] > 0.02
    rig.pad.unplug()
    rig.loop(0.3)  # the arm comes to rest
    assert np.abs(rig.moved()).max() < STILL
    rig.pad.plug_in()
    rig.hold_forward()
    rig.assert_only_a_fresh_push_moves()


def test_after_a_pause_of_the_loop_only_a_fresh_push_moves(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig.loop(0.2)
    rig.hold_forward()
    assert rig.moved()[0] > 0.02
    rig.world.run(1.0)
    with monkeypatch.context() as patch:
        patch.setattr(jogging, "_PAUSE", 0.0)
        rig.loop(1 / FPS)
    rig.assert_only_a_fresh_push_moves()


def test_after_an_emergency_stop_only_a_fresh_push_moves(rig: Rig) -> None:
    rig.loop(0.2)
    rig.hold_forward()
    assert rig.moved()[0] > 0.02
    rig.world.emergency_stop()
    action = rig.teleop.get_action()
    with pytest.raises(ControlError):
        rig.robot.send_action(action)
    rig.world.run(0.5)
    rig.world.emergency_stop(False)
    rig.robot.connect()
    rig.assert_only_a_fresh_push_moves()


def test_after_a_reset_only_a_fresh_push_moves(rig: Rig) -> None:
    rig.loop(0.2)
    rig.hold_forward()
    assert rig.moved()[0] > 0.02
    rig.world.reset()
    rig.robot.connect()
    rig.assert_only_a_fresh_push_moves()


def test_the_dpad_scales_the_speed(rig: Rig) -> None:
    rig.loop(0.2)
    rig.hold_forward()
    full = rig.moved(1.0)[0]
    for down in (True, False):
        rig.pad.press(pygame.CONTROLLER_BUTTON_DPAD_DOWN, down)
        rig.loop(0.3)
    half = rig.moved(1.0)[0]
    assert half == pytest.approx(0.5 * SPEED, rel=0.1)
    assert full > 1.5 * half


def test_buttons_open_and_close_the_gripper_at_a_press(rig: Rig) -> None:
    rig.loop(0.2)
    rig.pad.press(SHOULDER)
    for button, is_open in ((0, False), (1, True)):
        rig.pad.press((pygame.CONTROLLER_BUTTON_A, pygame.CONTROLLER_BUTTON_B)[button])
        rig.loop(1.2)
        assert (rig.world.gripper.opening > 0.04) == is_open


def test_buttons_end_an_episode_once(rig: Rig) -> None:
    assert isinstance(rig.teleop, HasTeleopEvents)
    rig.loop(0.1)
    for button, event in (
        (pygame.CONTROLLER_BUTTON_Y, TeleopEvents.SUCCESS),
        (pygame.CONTROLLER_BUTTON_X, TeleopEvents.RERECORD_EPISODE),
        (pygame.CONTROLLER_BUTTON_BACK, TeleopEvents.FAILURE),
    ):
        rig.pad.press(button)
        rig.loop(1 / FPS)  # get_action reads the device, too
        events = rig.teleop.get_teleop_events()
        assert {key for key, value in events.items() if value} == {
            event,
            TeleopEvents.TERMINATE_EPISODE,
        }
        assert not any(rig.teleop.get_teleop_events().values())
    rig.hold_forward()
    assert rig.teleop.get_teleop_events()[TeleopEvents.IS_INTERVENTION]


def test_joints_keep_their_speed_and_the_target_its_lead() -> None:
    rng = np.random.default_rng(7)
    with tool0.bringup(realtime=False) as world:
        arm = world.arm
        fastest, q_before = arm.kinematics.fastest, None
        with arm.motion.taken():
            for frame in ("root", "tool"):
                jog = ArmJog(world, "", speed=(0.25, 1.0), frame=frame)
                for _ in range(6):
                    jog.follow(np.zeros(6))
                    jog.follow(np.zeros(6))
                    shares = rng.uniform(-1.0, 1.0, 6)
                    for _ in range(10):
                        q = jog.follow(shares)
                        setpoint = arm.motion.state.setpoint
                        assert setpoint is not None
                        assert np.abs(q - setpoint.positions).max() <= jogging.LEAD
                        if q_before is not None:
                            step = np.abs(q - q_before) / (fastest * 0.04)
                            assert step.max() <= jogging.FASTEST + 1e-9
                        q_before = q
                        arm.motion.servo_joints(q.tolist(), lookahead_time=0.06)
                        world.run(0.04)


def test_a_joint_stops_at_its_limit_and_comes_back() -> None:
    with tool0.bringup(realtime=False) as world, world.arm.motion.taken():
        jog = ArmJog(world, "", speed=(0.2, 1.0), frame="root")
        limits = jog.arm.kinematics
        start = jog.follow(np.zeros(6))
        limits.lower[:], limits.upper[:] = start - 0.1, start + 0.1

        def followed(x: float, steps: int) -> np.ndarray:
            for _ in range(steps):
                q = jog.follow(np.array([x, 0.0, 0.0, 0.0, 0.0, 0.0]))
                assert (np.abs(q - start) <= 0.1 + 1e-9).all()
                jog.arm.motion.servo_joints(q.tolist(), lookahead_time=0.06)
                world.run(0.04)
            return q

        far = np.abs(followed(1.0, 40) - start).max()
        assert far > 0.05
        assert np.abs(followed(-1.0, 5) - start).max() < far - 0.02


def test_options_out_of_range_are_refused() -> None:
    for options in ({"speed": 2.0}, {"turn_speed": float("nan")}, {"dead_zone": 1.0}):
        with pytest.raises(ConfigError, match=next(iter(options))):
            Tool0SpaceMouseConfig(**options)
    with pytest.raises(ConfigError, match="root or tool"):
        Tool0GamepadConfig(frame="flange")  # type: ignore[arg-type]


def test_a_gamepad_is_found_by_its_name(pad: VirtualGamepad) -> None:
    assert Gamepad(0.1, "virtual").read() is not None
    with pytest.raises(ControlError, match=r"'Xbox'.*\['Virtual Controller'\]"):
        Gamepad(0.1, "Xbox")


def test_a_program_with_a_gamepad_ends_by_sigterm() -> None:
    code = (
        "from lerobot_robot_tool0.gamepad import controller; controller.init(); "
        "print('ready', flush=True); import time; time.sleep(60)"
    )
    words = [sys.executable, "-c", code]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        process.terminate()
        assert process.wait(20.0) == -signal.SIGTERM


class Reports:
    """A device of hidapi that has these reports to read."""

    def __init__(self) -> None:
        self.waiting: list[bytes] = []
        self.is_there = True

    def read(self, max_length: int) -> Sequence[int]:
        if not self.is_there:
            raise OSError("read error")
        return list(self.waiting.pop(0)[:max_length]) if self.waiting else []

    def close(self) -> None:
        self.is_there = False


def report(number: int, *counts: int) -> bytes:
    return bytes([number]) + struct.pack(f"<{len(counts)}h", *counts)


@pytest.mark.parametrize(
    ("counts", "shares"),
    [  # x right, y towards the user, z down, to x forward, y left, z up
        ((350, 0, 0, 0, 0, 0), (0, -1, 0, 0, 0, 0)),
        ((0, -350, 0, 0, 0, 0), (1, 0, 0, 0, 0, 0)),
        ((0, 0, -350, 0, 0, 0), (0, 0, 1, 0, 0, 0)),
        ((0, 0, 0, -350, 0, 0), (0, 0, 0, 0, 1, 0)),
        ((0, 0, 0, 0, -350, 0), (0, 0, 0, 1, 0, 0)),
        ((0, 0, 0, 0, 0, -350), (0, 0, 0, 0, 0, 1)),
        ((0, 500, 35, 0, 0, 0), (-1, 0, 0, 0, 0, 0)),
    ],
)
@pytest.mark.parametrize("is_one", [True, False])
def test_reports_of_a_spacemouse_are_read(
    counts: tuple[int, ...], shares: tuple[float, ...], is_one: bool
) -> None:
    device = Reports()
    mouse = SpaceMouse(0.1, lambda: device)
    if is_one:  # newer devices
        device.waiting = [report(1, *counts)]
    else:
        device.waiting = [report(1, *counts[:3]), report(2, *counts[3:])]
    command = mouse.read()
    assert command is not None
    np.testing.assert_allclose(command.shares, shares, atol=1e-12)


def test_silence_of_a_spacemouse_is_neutral(monkeypatch: pytest.MonkeyPatch) -> None:
    device = Reports()
    mouse = SpaceMouse(0.1, lambda: device)
    device.waiting = [report(1, 0, -350, 0)]
    assert mouse.read().shares[0] == 1.0  # type: ignore[union-attr]
    monkeypatch.setattr(spacemouse, "_SILENCE", 0.0)
    device.waiting = [b"\x17\x64\x01"]  # its battery says nothing about its cap
    assert not mouse.read().shares.any()  # type: ignore[union-attr]


def test_buttons_of_a_spacemouse_grip_though_they_are_let_go_before_the_next_look() -> (
    None
):
    device = Reports()
    mouse = SpaceMouse(0.1, lambda: device)
    for bit, grip in ((1, "close"), (2, "open")):
        device.waiting = [bytes([3, bit, 0]), bytes([3, 0, 0])]
        assert mouse.read().grip == grip  # type: ignore[union-attr]
        assert mouse.read().grip is None  # type: ignore[union-attr]


def test_a_spacemouse_that_is_plugged_in_again_is_found(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    devices = [Reports(), Reports()]
    waiting = list(devices)

    def plugged() -> Reports:
        if not waiting:
            raise ControlError("no SpaceMouse is plugged in")
        return waiting.pop(0)

    mouse = SpaceMouse(0.1, plugged)
    devices[0].waiting = [report(1, 0, -350, 0)]
    assert mouse.read() is not None
    devices[0].is_there = False
    assert mouse.read() is None
    assert mouse.read() is None  # it is not looked for at once
    monkeypatch.setattr(spacemouse, "_RETRY", 0.0)
    assert mouse.read() is None
    command = mouse.read()
    assert command is not None
    assert not command.shares.any()


def test_a_spacemouse_that_is_not_there_is_an_error() -> None:
    with pytest.raises(ControlError, match="no SpaceMouse is plugged in"):
        SpaceMouse(0.1)
