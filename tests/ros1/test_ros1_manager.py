"""controller_manager's services, by rosservice and by what its command line calls."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml
from ros import Bringup, Ros
from ros_client import (
    arm_client,
    call,
    follow_goal,
    listening,
    outcome,
    publishing,
    trajectory,
)
from ros_spawner import spawned
from ur5_rig import ARM, GRIPPER
from waits import until

MANAGER = "/controller_manager"
GROUP = "joint_group_eff_controller"
OWN = "own_controller"
OWN_YAML = """
own_controller:
  type: effort_controllers/JointTrajectoryController
  joints: [wrist_3_joint]
  gains:
    wrist_3_joint: {p: 10, i: 0, d: 0.1, i_clamp: 1}
  state_publish_rate: 25
"""
LOADED = ["joint_state_controller", ARM, GRIPPER, GROUP]


def rosservice(ros: Ros, service: str, **arguments: object) -> Any:
    """Return what ``rosservice call`` prints, read as the YAML that it is."""
    return yaml.safe_load(
        ros.run(
            *("rosservice", "call", f"{MANAGER}/{service}", json.dumps(arguments)),
        )
    )


def manage(service: str, *arguments: object, **named: object) -> bool:
    """Call a service of controller_manager that answers whether it succeeded."""
    srv = importlib.import_module("controller_manager_msgs.srv")
    kind = getattr(srv, service.title().replace("_", ""))
    ok: bool = call(f"{MANAGER}/{service}", kind, *arguments, **named).ok
    return ok


def load(name: str) -> bool:
    return manage("load_controller", name)


def unload(name: str) -> bool:
    return manage("unload_controller", name)


def switch(start: list[str], stop: list[str], strictness: int = 2) -> bool:
    return manage("switch_controller", start, stop, strictness, False, 0.0)


def states() -> dict[str, str]:
    """Return controller → state."""
    from controller_manager_msgs.srv import ListControllers

    response = call(f"{MANAGER}/list_controllers", ListControllers)
    return {one.name: one.state for one in response.controller}


def test_all_six_services_by_rosservice(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    listed = rosservice(ros, "list_controllers")["controller"]
    assert [one["name"] for one in listed] == LOADED
    assert listed[0]["claimed_resources"] == [
        {
            "hardware_interface": "hardware_interface::JointStateInterface",
            "resources": [],
        }
    ]
    assert listed[1]["claimed_resources"][0]["hardware_interface"] == (
        "hardware_interface::EffortJointInterface"
    )
    types = rosservice(ros, "list_controller_types")
    assert "effort_controllers/JointTrajectoryController" in types["types"]
    assert len(types["base_classes"]) == len(types["types"])
    stopped = rosservice(
        ros, "switch_controller", stop_controllers=[GRIPPER], strictness=2
    )
    assert stopped == {"ok": True}
    assert states()[GRIPPER] == "stopped"
    assert rosservice(ros, "unload_controller", name=GRIPPER) == {"ok": True}
    assert GRIPPER not in states()
    assert rosservice(ros, "load_controller", name=GRIPPER) == {"ok": True}
    assert states()[GRIPPER] == "initialized"
    assert switch([GRIPPER], [])
    refused = rosservice(ros, "reload_controller_libraries", force_kill=False)
    assert refused == {"ok": False}


def test_a_refusal_changes_nothing(rospy: ModuleType, bringup: Bringup) -> None:
    before = states()
    assert before[ARM] == "running"
    assert not load(ARM)
    assert ARM in bringup.wait_for("LoadController")
    assert not load("arm_controller")
    bringup.wait_for("arm_controller")
    assert not unload(ARM)
    assert ARM in bringup.wait_for("UnloadController")
    assert not unload("arm_controller")
    for start, stop in (
        ([GROUP], []),  # its joints are the arm's
        (["arm_controller"], [ARM]),
        ([ARM], []),  # runs
        ([], [GROUP]),  # does not run
        ([ARM], [ARM]),
    ):
        assert not switch(start, stop)
    assert states() == before


def test_best_effort_skips_the_impossible(rospy: ModuleType, bringup: Bringup) -> None:
    best_effort = 1
    assert switch(["arm_controller", ARM], [GRIPPER, GROUP], best_effort)
    assert states()[GRIPPER] == "stopped"
    assert states()[ARM] == "running"
    assert switch([GRIPPER], [], 0)  # 0 counts as best effort
    assert states()[GRIPPER] == "running"
    assert not switch([GROUP], [], best_effort)  # a conflict is one in any case


def test_unloading_unregisters_the_controllers_names(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    query, state = f"/{GRIPPER}/query_state", f"/{GRIPPER}/state"
    assert query in ros.services()
    assert state in ros.publishers()
    assert switch([], [GRIPPER])
    assert query in ros.services()
    assert unload(GRIPPER)
    assert query not in ros.services()
    topics = [name for name, nodes in ros.publishers().items() if "/gazebo" in nodes]
    assert not [name for name in topics if name.startswith(f"/{GRIPPER}/")]
    assert load(GRIPPER)
    assert switch([GRIPPER], [])
    client = arm_client(GRIPPER)
    client.send_goal(follow_goal(trajectory([(0.5, [0.3])], ["finger_joint"])))
    assert outcome(client)[0] == 3


def test_a_controller_of_the_parameter_server_is_loaded_and_runs(
    ros: Ros, rospy: ModuleType, bringup: Bringup, tmp_path: Path
) -> None:
    """As ``rosparam load`` and the spawner do, to the end that Ctrl-C makes of it."""
    from control_msgs.msg import JointTrajectoryControllerState

    file = tmp_path / "own.yaml"
    file.write_text(OWN_YAML, encoding="utf-8")
    assert not load(OWN)
    ros.run("rosparam", "load", str(file))
    for service in ("load", "switch", "unload"):
        rospy.wait_for_service(f"{MANAGER}/{service}_controller", timeout=30)
    assert load(OWN)
    assert not switch([OWN], [])  # the arm's controller has its joint
    assert switch([OWN], [ARM])
    with listening(f"/{OWN}/state", JointTrajectoryControllerState) as topic:
        assert topic.next(3)[0].joint_names == ["wrist_3_joint"]
        client = arm_client(OWN)
        client.send_goal(follow_goal(trajectory([(0.5, [0.4])], ["wrist_3_joint"])))
        assert outcome(client)[0] == 3
        assert topic.next()[0].actual.positions[0] == pytest.approx(0.4, abs=0.02)
    assert switch([], [OWN])
    assert unload(OWN)
    assert switch([ARM], [])
    # Another run, with other parameters.
    ros.run("rosparam", "set", f"/{OWN}/joints", "[wrist_2_joint]")
    assert not load(OWN)
    bringup.wait_for("gains/wrist_2_joint")
    ros.run("rosparam", "delete", f"/{OWN}")


def test_the_spawner_starts_controllers_and_stops_them_at_ctrl_c(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    assert switch([], [GRIPPER])
    assert unload(GRIPPER)
    before = states()
    with spawned(ros, GRIPPER):
        assert states()[GRIPPER] == "running"
    assert states() == before
    assert load(GRIPPER)
    assert switch([GRIPPER], [])


def test_libraries_are_reloaded_if_controllers_may_be_killed(
    rospy: ModuleType, bringup: Bringup
) -> None:
    """As ``controller_manager reload-libraries --restore`` does."""
    before = states()
    assert not manage("reload_controller_libraries", False)
    assert states() == before
    assert manage("reload_controller_libraries", True)
    assert states() == {}
    assert manage("reload_controller_libraries", False)  # nothing is loaded
    for name in before:
        assert load(name)
    running = [name for name, state in before.items() if state == "running"]
    assert switch(running, [])
    assert states() == before


def test_a_group_controller_forwards_its_topic(
    ros: Ros, rospy: ModuleType, bringup: Bringup
) -> None:
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray

    assert switch([GROUP], [ARM])
    try:
        with (
            listening("/joint_states", JointState) as received,
            publishing(f"/{GROUP}/command", Float64MultiArray) as command,
        ):
            pan = received.next()[0].name.index("shoulder_pan_joint")

            def effort() -> float:
                value: float = received.next()[0].effort[pan]
                return value

            # Gravity is carried only as long as the arm waits for its first command.
            assert max(map(abs, received.next()[0].velocity)) < 0.01
            command(Float64MultiArray(data=[0.3, -20.0, -20.0, -2.0, 0.0, 0.0]))
            until(lambda: effort() == pytest.approx(0.3), "the effort commanded")
            command(Float64MultiArray(data=[0.0, 0.0, 0.0, 0.0, 0.1]))
            assert "5" in bringup.wait_for(f"{GROUP}/command")
            command(Float64MultiArray(data=[float("nan")] * 6))
            bringup.wait_for("nan")
            assert effort() == pytest.approx(0.3)
            command(Float64MultiArray(data=[-0.3, -20.0, -20.0, -2.0, 0.0, 0.0]))
            until(lambda: effort() == pytest.approx(-0.3), "the effort commanded")
    finally:
        assert switch([ARM], [GROUP])
    assert states()[GROUP] == "stopped"
