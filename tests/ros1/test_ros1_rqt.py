"""rqt_joint_trajectory_controller: what it looks up, and the motion of its stream."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from xml.etree import ElementTree

import numpy as np
from ros import Bringup, Ros, system_python
from ros_client import Topic, at, listening, publishing, trajectory
from ur5_rig import ARM, ARM_JOINTS, HOME
from waits import until

ENGINES = ("mujoco", "gazebo")
SERVICES = {
    "list_controllers": "ListControllers",
    "list_controller_types": "ListControllerTypes",
    "load_controller": "LoadController",
    "unload_controller": "UnloadController",
    "switch_controller": "SwitchController",
    "reload_controller_libraries": "ReloadControllerLibraries",
}
RATE = 10.0  # [Hz] of the commands
SPEED = 0.5  # of the slider for the speed, as it starts
LEAD = 0.5 / SPEED  # [s], the time of every point, of which half is the plugin's least
DRAGGED = np.array([0.8, 0.3, -0.4, 0.3, 0.2, -0.8])  # [rad] from HOME
DRAGGED_FOR, LET_GO_FOR = 2.0, 2.5  # [s]


def test_it_finds_the_controller_and_the_limits_of_its_joints(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    import rosservice
    from controller_manager_msgs.srv import ListControllers

    for service, kind in SERVICES.items():
        found = rosservice.get_service_type(f"/controller_manager/{service}")
        assert found == f"controller_manager_msgs/{kind}"
    manager = rospy.ServiceProxy(
        "/controller_manager/list_controllers", ListControllers, persistent=True
    )
    try:
        for _ in range(3):
            listed = {one.name: one for one in manager().controller}
    finally:
        manager.close()
    shown = [
        one
        for one in listed.values()
        if "JointTrajectoryController" in one.type and one.state == "running"
    ]
    assert [one.name for one in shown] == [ARM, "gripper_controller"]
    limits = limits_of(ros)
    for one in shown:
        joints = one.claimed_resources[0].resources
        assert joints
        for joint in joints:
            lower, upper, speed = limits[joint]
            assert lower < upper
            assert speed > 0.0
    assert listed[ARM].claimed_resources[0].resources == sorted(ARM_JOINTS)


def test_it_finds_managers_and_controllers_through_the_utils_module(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    from controller_manager_msgs import utils

    list_managers = utils.ControllerManagerLister()
    assert [list_managers(), list_managers()] == [["/controller_manager"]] * 2
    assert utils.get_controller_managers("/elsewhere") == []
    assert not utils.is_controller_manager("/gazebo")
    list_controllers = utils.ControllerLister("/controller_manager")
    loaded = list_controllers()
    assert ARM in [one.name for one in loaded]
    assert [one.name for one in list_controllers()] == [one.name for one in loaded]
    assert utils.ControllerLister("/nowhere")() == []
    running = utils.filter_by_state(loaded, "running")
    trajectory = utils.filter_by_type(running, "JointTrajectory", match_substring=True)
    assert [one.name for one in trajectory] == [ARM, "gripper_controller"]
    states = "hardware_interface::JointStateInterface"
    (reader,) = utils.filter_by_hardware_interface(loaded, states)
    assert utils.filter_by_name(loaded, reader.name) == [reader]
    both = ["elbow_joint", "finger_joint"]
    assert utils.filter_by_resources(running, both) == []
    assert utils.filter_by_resources(running, both, match_any=True) == trajectory
    defined = utils.get_rosparam_controller_names("/")
    assert {one.name for one in loaded} <= set(defined)
    assert "gazebo" not in defined
    assert utils.get_rosparam_controller_names("/elsewhere") == []


def test_catkin_accepts_the_generated_packages(ros: Ros, bringup: Bringup) -> None:
    """Rqt reads every package.xml on its path, and reports those that do not parse."""
    from controller_manager_msgs import utils

    manifests = Path(utils.__file__).parents[1].glob("*/package.xml")
    program = "import sys; from catkin_pkg.package import parse_package\n"
    program += "for file in sys.argv[1:]: print(parse_package(file).name)"
    parsed = ros.run(system_python(), "-c", program, *map(str, manifests)).split()
    assert "controller_manager_msgs" in parsed


def limits_of(ros: Ros) -> dict[str, tuple[float, ...]]:
    """Return joint → lower, upper [rad], speed [rad/s] of robot_description."""
    tree = ElementTree.fromstring(ros.parameter("/robot_description"))
    return {
        joint.get("name", ""): tuple(
            float(limit.get(key, "nan")) for key in ("lower", "upper", "velocity")
        )
        for joint in tree.findall("joint")
        if joint.get("type") != "fixed" and joint.find("mimic") is None
        for limit in [joint.find("limit")]
        if limit is not None
    }


def test_its_stream_of_positions_moves_the_arm_smoothly(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    """Ten times a second comes a point without velocities, T = 1 s or more ahead.

    Each replaces a ramp by another, from the desired position now to where the
    slider is.  After a time dt in which the slider went by ds, the new ramp's speed is
    v + (ds - v dt) / T.  The speed lags behind the slider's, so no step is larger than
    the slider's speed times dt / T; and what is left when the last ramp ends is less,
    for it falls by that part with each point after the slider has come to rest.
    """
    from control_msgs.msg import JointTrajectoryControllerState

    with listening(f"/{ARM}/state", JointTrajectoryControllerState) as states:
        go_home(rospy, states)
        since = len(states.messages)
        sent = drag_sliders(rospy, states, limits_of(ros))
        until(
            lambda: at(states.messages[-1].header.stamp) > sent[-1] + 1.5,
            "the end of the last ramp",
        )
        received = states.messages[since:]
    gap = float(np.diff(sent).max())  # 0.1 s where this process is not kept waiting
    largest = float(np.abs(DRAGGED).max()) / DRAGGED_FOR * gap / LEAD
    desired = np.array([one.desired.velocities for one in received])
    actual = np.array([one.actual.velocities for one in received])
    assert np.abs(np.diff(desired, axis=0)).max() <= 1.1 * largest
    # The loop's response to a step of the desired speed: it lags by at most the step,
    # and overshoots by less than half of it; in between joints push one another.
    assert np.abs(actual - desired).max() <= 1.5 * largest
    assert np.abs(actual).max() <= 1.2 * np.abs(DRAGGED).max() / DRAGGED_FOR
    (last,) = received[-1:]
    np.testing.assert_allclose(last.desired.positions, HOME + DRAGGED, atol=1e-9)
    np.testing.assert_allclose(last.actual.positions, HOME + DRAGGED, atol=0.02)
    assert not any("error" in line.lower() for line in bringup.lines)


def go_home(rospy: ModuleType, states: Topic) -> None:
    """Begin at HOME, also when a test is repeated."""
    from trajectory_msgs.msg import JointTrajectory

    def rests() -> bool:
        last = states.messages[-1]
        away = np.abs(np.subtract(last.actual.positions, HOME)).max()
        speed = np.abs(last.actual.velocities).max()
        return bool(max(away, speed) < 0.005 and not any(last.desired.velocities))

    until(lambda: states.messages, "a state")
    if not rests():
        with publishing(f"/{ARM}/command", JointTrajectory) as command:
            command(trajectory([(2.0, tuple(HOME))]))
            until(rests, "HOME")


def drag_sliders(
    rospy: ModuleType, states: Topic, limits: Mapping[str, tuple[float, ...]]
) -> list[float]:
    """Publish as the plugin does; return when [s], in ROS's time."""
    from trajectory_msgs.msg import JointTrajectory

    fastest = np.array([limits[joint][2] for joint in ARM_JOINTS])
    sent: list[float] = []
    timer = threading.Event()  # nobody sets it: the plugin's timer, of wall time
    with publishing(f"/{ARM}/command", JointTrajectory) as command:
        begin = time.monotonic()
        while (now := time.monotonic() - begin) < DRAGGED_FOR + LET_GO_FOR:
            sliders = HOME + min(now / DRAGGED_FOR, 1.0) * DRAGGED
            left = np.abs(sliders - states.messages[-1].actual.positions)
            lead = max(float(np.max(left / fastest)), 0.5) / SPEED
            assert lead == LEAD  # no slider is far ahead of its joint
            stamp = rospy.Time.now()
            command(trajectory([(lead, tuple(sliders))], stamp=stamp, at_rest=False))
            sent.append(at(stamp))
            timer.wait(begin + len(sent) / RATE - time.monotonic())
    return sent
