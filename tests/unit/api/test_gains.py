"""PID gains of a controller while it runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from raises_naming import raises_naming
from served import serving, use_folder
from ur5_rig import ARM

import tool0
from tool0.control.config import ControllerConfig
from tool0.errors import ConfigError, ControlError, RequestError

LIFT = "shoulder_lift_joint"


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def test_a_new_integral_gain_does_not_move_the_arm(robot: tool0.Robot) -> None:
    robot.run(3.0)  # the integral carries the weight
    controller, held = robot.controller(ARM), robot.joint_state
    controller.set_gains(LIFT, i=5000.0)
    assert controller.gains[LIFT].i == 5000.0
    robot.run(0.5)
    assert robot.joint_state.effort[LIFT] == pytest.approx(held.effort[LIFT], abs=0.01)
    assert robot.joint_state.position[LIFT] == pytest.approx(
        held.position[LIFT], abs=1e-5
    )


def test_a_running_controller_takes_new_gains_at_once(robot: tool0.Robot) -> None:
    robot.run(3.0)
    held = robot.joint_state.position[LIFT]
    gains = robot.controller(ARM).set_gains(LIFT, p=1000.0, i=0.0)
    assert (gains.p, gains.i, gains.d, gains.antiwindup) == (1000.0, 0.0, 200.0, True)
    robot.run(1.0)
    assert robot.joint_state.position[LIFT] - held > 0.005  # it sags by weight / p


def test_gains_hold_until_the_controller_is_unloaded(robot: tool0.Robot) -> None:
    controller = robot.controller(ARM)
    loaded = dict(controller.gains)
    controller.set_gains(LIFT, p=9000.0, i_clamp=50.0, antiwindup=False)
    robot.reset()
    robot.switch(stop=[ARM])
    changed = controller.set_gains(LIFT, d=150.0)  # also while it is stopped
    assert (changed.p, changed.d, changed.i_min, changed.i_max) == (
        *(9000.0, 150.0),
        *(-50.0, 50.0),
    )
    robot.switch(start=[ARM])
    assert controller.gains == {**loaded, LIFT: changed}
    robot.switch(stop=[ARM])
    robot.unload(ARM)
    robot.load(ARM)
    assert controller.gains == loaded


def test_what_cannot_be_set_changes_nothing(robot: tool0.Robot) -> None:
    controller = robot.controller(ARM)
    before = dict(controller.gains)
    with raises_naming(ControlError, "elbow", "elbow_joint"):
        controller.set_gains("elbow", p=1.0)
    with pytest.raises(RequestError):
        controller.set_gains(LIFT, p=float("nan"))
    with pytest.raises(RequestError):
        controller.set_gains(LIFT, i_clamp=-1.0)
    assert controller.gains == before
    for name in ("joint_state_controller", "joint_group_eff_controller"):
        assert robot.controller(name).gains == {}
        with raises_naming(ControlError, name, "no gains"):
            robot.controller(name).set_gains(LIFT, p=1.0)


def test_every_kind_of_pid_has_gains() -> None:
    text = """
position:
  type: effort_controllers/JointPositionController
  joint: elbow_joint
  pid: {p: 100, d: 5}
gripper:
  type: effort_controllers/GripperActionController
  joint: finger_joint
  gains: {finger_joint: {p: 10}}
"""
    config = ControllerConfig.from_text(text)
    with tool0.bringup(realtime=False, controllers=()) as robot:
        for name, joint in (("position", "elbow_joint"), ("gripper", "finger_joint")):
            robot.load(name, config)
            robot.switch(start=[name])
            robot.controller(name).set_gains(joint, p=20.0)
            assert robot.controller(name).gains[joint].p == 20.0
            with pytest.raises((ConfigError, ControlError)):
                robot.controller(name).set_gains(joint, p=1e400)


def test_gains_are_set_from_another_process(
    robot: tool0.Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    use_folder(monkeypatch, tmp_path)
    with serving(robot), tool0.connect() as remote:
        remote.controller(ARM).set_gains(LIFT, p=8000.0)
        assert robot.controller(ARM).gains[LIFT].p == 8000.0
        assert remote.controller(ARM).gains == robot.controller(ARM).gains
