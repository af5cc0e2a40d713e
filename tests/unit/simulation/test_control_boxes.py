"""The control box of an arm: what is stored, and what acts."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
from ur5_rig import ARM

import tool0
from tool0.description.config import DescriptionConfig
from tool0.errors import ControlError, RequestError
from tool0.protocol.codec import (
    Reply,
    decode_request,
    decode_response,
    encode_reply,
    encode_request,
)
from tool0.protocol.control_box import ReadIO, SetIO
from tool0.protocol.control_box_state import (
    AnalogDomain,
    AnalogPin,
    ProgramState,
    RobotMode,
    SafetyMode,
)
from tool0.protocol.state_message import (
    SNAPSHOT_FIELDS,
    StateMask,
    snapshot_of,
    state_message,
)
from tool0.simulation.config import ControlConfig

GRAVITY = 9.81
CELL = DescriptionConfig(robots=("left=ur5e+2f85", "right=ur3e+hande@1,0,0"))
SERVOED = """
arm:
  type: position_controllers/JointTrajectoryController
  joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint,
           wrist_2_joint, wrist_3_joint]
"""


@pytest.fixture
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(realtime=False) as robot:
        yield robot


def test_pins_are_stored(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    box.set_digital_output(0, True)
    box.set_digital_output(17, True)
    box.set_digital_input(8, True)
    box.set_analog_output(1, 0.5, AnalogDomain.CURRENT)
    box.set_analog_input(0, 3.5)
    box.set_analog_input(1, 0.01, AnalogDomain.CURRENT, tool=True)
    box.set_tool_voltage(24)
    state = box.state
    assert [k for k, on in enumerate(state.digital_outputs) if on] == [0, 17]
    assert [k for k, on in enumerate(state.digital_inputs) if on] == [8]
    assert state.analog_outputs[1] == AnalogPin(0.012, AnalogDomain.CURRENT)
    assert state.analog_inputs[0] == AnalogPin(3.5, AnalogDomain.VOLTAGE)
    assert state.tool_analog_inputs[1] == AnalogPin(0.01, AnalogDomain.CURRENT)
    assert state.tool_voltage == 24
    box.set_digital_output(0, False)
    assert [k for k, on in enumerate(box.state.digital_outputs) if on] == [17]


def test_what_no_box_has_is_refused(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    before = box.state
    with pytest.raises(RequestError, match="17"):
        box.set_digital_output(18, True)
    with pytest.raises(RequestError, match="'level'"):
        box.set_analog_output(0, 1.5)
    with pytest.raises(RequestError, match="tool_voltage"):
        box.set_tool_voltage(5)
    with pytest.raises(RequestError, match=r"0\.01"):
        box.set_speed_slider(0.0)
    with pytest.raises(RequestError, match="'mass'"):
        box.set_payload(-1.0)
    with pytest.raises(RequestError, match="finite"):
        box.set_payload(1.0, (0.0, 0.0, float("nan")))
    assert box.state == before


def test_snapshots_share_what_did_not_change(robot: tool0.Robot) -> None:
    before = robot.snapshot.control_boxes
    robot.run(0.1)
    assert robot.snapshot.control_boxes is before
    robot.arm.control_box.set_digital_output(2, True)
    after = robot.snapshot.control_boxes
    assert after is not before
    assert after[0] == robot.arm.control_box.state
    robot.arm.control_box.set_digital_output(2, True)
    assert robot.snapshot.control_boxes is after


def test_each_arm_of_a_cell_has_its_own() -> None:
    with tool0.bringup(description=CELL, realtime=False) as robot:
        left, right = (robot.arms[name].control_box for name in ("left", "right"))
        left.set_digital_output(1, True)
        right.set_speed_slider(0.5)
        robot.run(0.3)
        assert left.state.digital_outputs[1]
        assert not right.state.digital_outputs[1]
        assert left.state.speed_scaling == 1.0
        assert right.state.speed_scaling == 0.5
        assert left.state.prefix == "left_"
        left.stop()
        statuses = robot.snapshot.controllers
        running = [item.name for item in statuses if item.is_running]
        assert any(name.startswith("right") for name in running)
        with pytest.raises(ControlError, match="left, right"):
            robot.channel.call(ReadIO())


def test_the_speed_scaling_follows_the_slider_smoothly(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    box.set_speed_slider(0.5)
    assert box.state.speed_slider == 0.5
    seen = []
    for _ in range(15):
        robot.run(0.008)
        seen.append(box.state.speed_scaling)
    steps = [a - b for a, b in zip([1.0, *seen], seen, strict=False)]
    assert all(-1e-12 <= step <= 0.0400001 for step in steps)
    assert seen[-1] == 0.5


def test_a_paused_program_scales_to_zero_and_back(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    box.set_speed_slider(0.8)
    box.pause()
    robot.run(0.3)
    assert box.state.program is ProgramState.PAUSED
    assert box.state.speed_scaling == 0.0
    assert not box.state.is_program_running
    box.play()
    robot.run(0.3)
    assert box.state.speed_scaling == 0.8
    assert box.state.is_program_running


def test_a_stopped_program_stops_the_arms_controllers(robot: tool0.Robot) -> None:
    box = robot.arm.control_box

    def running() -> set[str]:
        statuses = robot.snapshot.controllers
        return {item.name for item in statuses if item.is_running}

    before = running()
    goal, *_ = robot.move_joints({"elbow_joint": 1.0})
    robot.run(0.1)
    box.stop()
    box.stop()
    assert before - running() == {ARM}
    assert goal.status.is_terminal
    robot.run(0.3)
    with pytest.raises(ControlError, match="stopped"):
        box.pause()
    box.play()
    assert running() == before
    goals = robot.move_joints({"elbow_joint": 1.0})
    assert goals[0].wait(5.0)


def test_the_emergency_stop_shows_in_the_modes(robot: tool0.Robot) -> None:
    box = robot.arm.control_box
    robot.emergency_stop()
    assert box.state.safety_mode is SafetyMode.ROBOT_EMERGENCY_STOP
    assert box.state.robot_mode is RobotMode.POWER_OFF
    assert not box.state.is_program_running
    with pytest.raises(ControlError, match="emergency stop"):
        box.play()
    robot.emergency_stop(False)
    assert box.state.safety_mode is SafetyMode.NORMAL
    assert box.state.robot_mode is RobotMode.RUNNING


@pytest.fixture
def servoed(tmp_path: Path) -> Iterator[tool0.Robot]:
    """A robot whose arm is driven by position servos."""
    file = tmp_path / "controllers.yaml"
    file.write_text(SERVOED)
    interface = "hardware_interface/PositionJointInterface"
    with tool0.bringup(
        description=DescriptionConfig(transmission_hw_interface=interface),
        control=ControlConfig(controllers_file=file, controllers="arm"),
        realtime=False,
    ) as robot:
        robot.run(0.3)
        yield robot


def droop(robot: tool0.Robot, load: float, at: tuple[float, float, float]) -> float:
    """Hang ``load`` [kg] at a point of the flange; return the largest droop [m]."""
    start = robot.arm.pose()
    force = (0.0, 0.0, -load * GRAVITY)
    robot.apply_wrench("wrist_3_link", force=force, point=start.apply(at))
    lowest = 0.0
    for _ in range(30):
        robot.run(0.008)
        lowest = max(lowest, start.position[2] - robot.arm.pose().position[2])
    return lowest


def test_a_payload_that_is_set_does_not_droop(servoed: tool0.Robot) -> None:
    load, at = 3.0, (0.0, 0.03, 0.15)
    surprised = droop(servoed, load, at)
    servoed.reset()
    servoed.run(0.3)
    box = servoed.arm.control_box
    tool = box.state.payload
    mass = tool.mass + load
    center = [
        (tool.mass * a + load * b) / mass
        for a, b in zip(tool.center_of_gravity, at, strict=True)
    ]
    box.set_payload(mass, center)
    assert box.state.payload.mass == mass
    assert surprised > 0.5e-3
    assert droop(servoed, load, at) < 0.01 * surprised


@pytest.mark.slow
def test_a_wrong_payload_moves_the_arm(servoed: tool0.Robot) -> None:
    box, start = servoed.arm.control_box, servoed.arm.pose().position[2]
    box.set_payload(8.0, (0.0, 0.0, 0.1))
    servoed.run(0.05)
    assert servoed.arm.pose().position[2] > start + 0.5e-3
    box.clear_payload()
    assert box.state.payload.mass == pytest.approx(0.92, abs=0.01)


def test_sensors_subtract_the_payload(robot: tool0.Robot) -> None:
    sensor, box = robot.force_torque, robot.arm.control_box
    robot.run(0.5)
    weight = sensor.read().force
    tool = box.state.payload
    assert sum(f * f for f in weight) ** 0.5 == pytest.approx(0.921 * GRAVITY, abs=0.05)
    box.set_payload(tool.mass, tool.center_of_gravity)
    robot.run(0.5)
    left = sensor.read()
    assert max(map(abs, left.force)) < 0.05
    assert max(map(abs, left.torque)) < 0.01
    sensor.stop()
    again = sensor.read()  # one that starts later knows the payload, too
    assert max(map(abs, again.force)) < 0.05


def test_a_socket_carries_changes_only() -> None:
    with tool0.bringup(realtime=False) as robot:
        first = robot.snapshot
        robot.run(0.1)
        second = robot.snapshot
        robot.arm.control_box.set_digital_output(5, True)
        third = robot.snapshot
    mask = StateMask(SNAPSHOT_FIELDS)
    unchanged = state_message(second, mask, first)
    assert not unchanged.control_boxes
    received = snapshot_of(unchanged, snapshot_of(state_message(first, mask)))
    assert received.control_boxes == first.control_boxes
    changed = snapshot_of(state_message(third, mask, second), received)
    assert changed.control_boxes[0].digital_outputs[5]


def test_a_socket_carries_the_whole_state(robot: tool0.Robot) -> None:
    robot.arm.control_box.set_analog_output(0, 1.0, AnalogDomain.CURRENT)
    state, request = robot.arm.control_box.state, ReadIO()
    reply = msgspec.json.decode(encode_reply(1, request, state), type=Reply)
    assert isinstance(reply.result, msgspec.Raw)
    assert decode_response(request, reply.result) == state
    sent = encode_request(1, SetIO(digital_outputs={16: True}, tool_voltage=12))
    assert decode_request(sent) == (
        1,
        SetIO(digital_outputs={16: True}, tool_voltage=12),
    )
