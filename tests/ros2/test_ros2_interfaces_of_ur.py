"""What UR's driver has besides trajectories: pins, modes, speed, payload, program."""

from __future__ import annotations

import numpy as np
import pytest
from ros import Bringup
from ros2_client import Client, Goal, Topic
from ros2_rig import JTC, follow, trajectory
from ur5_rig import ARM_JOINTS
from waits import until

import tool0

OPTIONS = ("--arm", "ur5e")
BOX = "/io_and_status_controller"
DASHBOARD = "/dashboard_client"
TRIGGER = "std_srvs/srv/Trigger"
SET_IO = "ur_msgs/srv/SetIO"
WRENCH = "geometry_msgs/msg/WrenchStamped"
WEIGHT = 0.921 * 9.81  # [N] of the gripper
DIGITAL, FLAG, ANALOG, VOLTAGE = 1, 2, 3, 4


@pytest.fixture
def start(client: Client, bringup: Bringup) -> np.ndarray:
    """Return where the arm is [rad]."""
    with client.listening("/joint_states", "sensor_msgs/msg/JointState") as topic:
        state = topic.last
    position = dict(zip(state.name, state.position, strict=True))
    return np.array([position[name] for name in ARM_JOINTS])


def speed(goal: Goal) -> float:
    """Return the speed of the fastest joint in the newest feedback [rad/s]."""
    feedback = goal.feedback()
    return max(map(abs, feedback[-1].actual.velocities)) if feedback else 0.0


def set_io(client: Client, fun: int, pin: int, state: float) -> bool:
    reply = client.call(f"{BOX}/set_io", SET_IO, fun=fun, pin=pin, state=state)
    return bool(reply.success)


def controllers(client: Client) -> dict[str, str]:
    reply = client.call(
        "/controller_manager/list_controllers",
        "controller_manager_msgs/srv/ListControllers",
    )
    return {item.name: item.state for item in reply.controller}


def test_pins_that_are_set_are_published(client: Client, bringup: Bringup) -> None:
    assert set_io(client, DIGITAL, 3, 1.0)
    assert set_io(client, DIGITAL, 17, 1.0)
    assert set_io(client, ANALOG, 1, 0.5)
    assert set_io(client, VOLTAGE, 0, 24.0)
    reply = client.call(
        f"{BOX}/set_analog_output",
        "ur_msgs/srv/SetAnalogOutput",
        data={"pin": 0, "domain": 0, "state": 0.25},
    )
    assert reply.success
    with client.listening(f"{BOX}/io_states", "ur_msgs/msg/IOStates") as topic:
        pins = topic.last
    assert [one.pin for one in pins.digital_out_states if one.state] == [3, 17]
    assert len(pins.digital_in_states) == len(pins.digital_out_states) == 18
    current, voltage = pins.analog_out_states
    assert (current.domain, current.state) == (0, pytest.approx(0.008))
    assert (voltage.domain, voltage.state) == (1, pytest.approx(5.0))
    with client.listening(f"{BOX}/tool_data", "ur_msgs/msg/ToolDataMsg") as topic:
        assert topic.last.tool_output_voltage == 24


def test_pins_that_no_box_has_are_refused(client: Client, bringup: Bringup) -> None:
    assert not set_io(client, DIGITAL, 18, 1.0)
    assert not set_io(client, FLAG, 0, 1.0)
    assert not set_io(client, ANALOG, 2, 0.5)
    assert not set_io(client, VOLTAGE, 0, 5.0)


def test_an_inactive_controller_refuses(client: Client, bringup: Bringup) -> None:
    switch = "/controller_manager/switch_controller"
    kind = "controller_manager_msgs/srv/SwitchController"
    name = BOX.strip("/")
    assert client.call(switch, kind, deactivate_controllers=[name], strictness=2).ok
    assert not set_io(client, DIGITAL, 0, 1.0)
    assert client.call(switch, kind, activate_controllers=[name], strictness=2).ok
    assert set_io(client, DIGITAL, 0, 1.0)


def test_late_subscribers_get_the_modes(client: Client, bringup: Bringup) -> None:
    messages = {
        "robot_mode": ("ur_dashboard_msgs/msg/RobotMode", "mode", 7),
        "safety_mode": ("ur_dashboard_msgs/msg/SafetyMode", "mode", 1),
        "robot_program_running": ("std_msgs/msg/Bool", "data", True),
    }
    for name, (kind, field, value) in messages.items():
        with client.listening(f"{BOX}/{name}", kind, latched=True) as topic:
            assert getattr(topic.last, field) == value, name


def test_the_speed_slider_slows_trajectories(client: Client, start: np.ndarray) -> None:
    kind = "ur_msgs/srv/SetSpeedSliderFraction"
    service = f"{BOX}/set_speed_slider"
    assert not client.call(service, kind, speed_slider_fraction=0.0).success
    assert client.call(service, kind, speed_slider_fraction=0.5).success
    topic = "/speed_scaling_state_broadcaster/speed_scaling"
    with client.listening(topic, "std_msgs/msg/Float64") as scaling:
        scaling.wait_for(lambda message: message.data == 50.0)
    try:
        goal = follow(client, trajectory([(1.0, start + 0.3)]))
        assert goal.outcome()[0] == "succeeded"
        stamps = [one.header.stamp for one in goal.feedback()]
        assert stamps[-1] - stamps[0] == pytest.approx(2.0, abs=0.4)  # not 1 s
    finally:
        client.call(service, kind, speed_slider_fraction=1.0)


def test_a_payload_beyond_the_rated_one_is_refused(
    client: Client, bringup: Bringup
) -> None:
    answer = client.call(
        f"{BOX}/set_payload",
        "ur_msgs/srv/SetPayload",
        mass=50.0,
        center_of_gravity={"x": 0.0, "y": 0.0, "z": 0.0},
    )
    assert not answer.success


def test_payload_and_tare_change_the_wrench(client: Client, bringup: Bringup) -> None:
    def force(topic: Topic) -> float:
        (one,) = topic.next()
        vector = one.wrench.force
        return float(np.linalg.norm([vector.x, vector.y, vector.z]))

    with client.listening("/force_torque_sensor_broadcaster/wrench", WRENCH) as topic:
        assert topic.last.header.frame_id
        until(lambda: abs(force(topic) - WEIGHT) < 0.2, "the tool's weight")
        assert client.call(
            f"{BOX}/set_payload",
            "ur_msgs/srv/SetPayload",
            mass=0.921,
            center_of_gravity={"x": 0.0, "y": 0.0, "z": 0.047},
        ).success
        until(lambda: force(topic) < 0.2, "the weight less the payload")
        assert client.call(f"{BOX}/zero_ftsensor", TRIGGER).success
        until(lambda: force(topic) < 0.01, "a tared sensor")
        stamps = [one.header.stamp for one in topic.next(100)]
    assert np.median(np.diff(stamps)) == pytest.approx(0.002, abs=1e-9)


def test_the_pose_of_the_tool_is_that_of_the_frames(
    client: Client, bringup: Bringup
) -> None:
    with client.listening(
        "/tcp_pose_broadcaster/pose", "geometry_msgs/msg/PoseStamped"
    ) as topic:
        pose = topic.last
    assert pose.header.frame_id == "base"
    with client.listening("/tf", "tf2_msgs/msg/TFMessage") as topic:
        frames = topic.wait_for(
            lambda message: message.transforms[0].child_frame_id == "tool0_controller"
        )
    place = frames.transforms[0].transform.translation
    position = pose.pose.position
    for axis in "xyz":
        assert getattr(place, axis) == pytest.approx(getattr(position, axis), abs=1e-3)
    reach = np.linalg.norm([position.x, position.y, position.z])
    assert 0.2 < reach < 1.4


def test_a_paused_program_pauses_the_motion(client: Client, start: np.ndarray) -> None:
    goal = follow(client, trajectory([(1.0, start - 0.3)]))
    until(lambda: speed(goal) > 0.1, "the arm to move")
    assert client.call(f"{DASHBOARD}/pause", TRIGGER).success
    until(lambda: speed(goal) < 0.005, "the arm to stand still")
    assert not goal.has_ended
    reply = client.call(
        f"{DASHBOARD}/program_state", "ur_dashboard_msgs/srv/GetProgramState"
    )
    assert reply.state.state == "PAUSED"
    assert client.call(f"{DASHBOARD}/play", TRIGGER).success
    assert goal.outcome()[0] == "succeeded"


def test_a_stopped_program_ends_the_motion(client: Client, start: np.ndarray) -> None:
    goal = follow(client, trajectory([(4.0, start + 0.4)]))
    until(lambda: speed(goal) > 0.02, "the arm to move")
    with client.listening(
        f"{BOX}/robot_program_running", "std_msgs/msg/Bool", latched=True
    ) as running:
        assert client.call(f"{BOX}/hand_back_control", TRIGGER).success
        running.wait_for(lambda message: not message.data)
        assert goal.outcome()[0] == "aborted"
        assert controllers(client)[JTC] == "inactive"
        assert not follow(client, trajectory([(1.0, start)])).is_accepted
        assert client.call(f"{BOX}/resend_robot_program", TRIGGER).success
        until(lambda: running.last.data, "the program to run again")
    assert controllers(client)[JTC] == "active"
    goal = follow(client, trajectory([(1.0, start)], ARM_JOINTS))
    assert goal.outcome()[0] == "succeeded"


def test_the_dashboard_refuses_what_there_is_not(
    client: Client, bringup: Bringup
) -> None:
    for name in ("unlock_protective_stop", "shutdown"):
        reply = client.call(f"{DASHBOARD}/{name}", TRIGGER)
        assert not reply.success
        assert reply.message
    for name in ("power_on", "brake_release", "restart_safety", "close_popup"):
        assert client.call(f"{DASHBOARD}/{name}", TRIGGER).success, name
    mode = client.call(
        f"{DASHBOARD}/get_robot_mode", "ur_dashboard_msgs/srv/GetRobotMode"
    )
    assert (mode.success, mode.robot_mode.mode) == (True, 7)
    reply = client.call(
        f"{DASHBOARD}/load_program", "ur_dashboard_msgs/srv/Load", filename="a.urp"
    )
    assert not reply.success


def test_the_arm_can_be_powered_off_and_on(
    client: Client, bringup: Bringup, start: np.ndarray
) -> None:
    def call(name: str) -> bool:
        return bool(client.call(f"{DASHBOARD}/{name}", TRIGGER).success)

    modes = client.listening(
        f"{BOX}/robot_mode", "ur_dashboard_msgs/msg/RobotMode", latched=True
    )
    goal = follow(client, trajectory([(4.0, start + 0.4)]))
    until(lambda: speed(goal) > 0.02, "the arm to move")
    with modes as mode:
        assert call("power_off")
        assert goal.outcome()[0] == "aborted"
        mode.wait_for(lambda message: message.mode == 3)
        assert not call("play")
        assert not follow(client, trajectory([(1.0, start)])).is_accepted
        assert call("power_on")
        mode.wait_for(lambda message: message.mode == 5)
        assert call("brake_release")
        mode.wait_for(lambda message: message.mode == 7)
    assert controllers(client)[JTC] == "inactive"
    assert call("play")
    assert controllers(client)[JTC] == "active"


def test_a_protective_stop_is_shown_and_cleared(
    client: Client, bringup: Bringup, monkeypatch: pytest.MonkeyPatch
) -> None:
    def call(name: str) -> bool:
        return bool(client.call(f"{DASHBOARD}/{name}", TRIGGER).success)

    monkeypatch.setenv("XDG_RUNTIME_DIR", bringup.runtime_folder)
    kind = "ur_dashboard_msgs/msg/SafetyMode"
    with (
        client.listening(f"{BOX}/safety_mode", kind, latched=True) as mode,
        client.listening(
            f"{BOX}/robot_program_running", "std_msgs/msg/Bool", latched=True
        ) as running,
        tool0.connect() as robot,
    ):
        robot.arm.control_box.stop_protectively("a test")
        mode.wait_for(lambda message: message.mode == 3)
        running.wait_for(lambda message: not message.data)
        assert not call("play")
        assert not call("unlock_protective_stop")  # not within 5 s
        assert call("restart_safety")
        mode.wait_for(lambda message: message.mode == 1)
        assert call("brake_release")
        assert call("play")
        until(lambda: running.last.data, "the program to run again")
