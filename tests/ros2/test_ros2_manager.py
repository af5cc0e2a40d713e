"""The controller manager by the calls of spawner, unspawner and `ros2 control`."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros import Bringup
from ros2_client import Client
from ros2_manager import BEST_EFFORT, Manager
from ros2_rig import JTC
from ur5_rig import ARM_JOINTS
from waits import until

FILE = Path(__file__).parent.parent / "data" / "controllers" / "ros2_variants.yaml"
SPAWNED = "position_forwarder"
CLAIMS = {f"{joint}/position" for joint in ARM_JOINTS}
SERVICES = {
    "list_controllers": "ListControllers",
    "list_controller_types": "ListControllerTypes",
    "load_controller": "LoadController",
    "configure_controller": "ConfigureController",
    "unload_controller": "UnloadController",
    "switch_controller": "SwitchController",
    "reload_controller_libraries": "ReloadControllerLibraries",
    "list_hardware_components": "ListHardwareComponents",
    "list_hardware_interfaces": "ListHardwareInterfaces",
    "set_hardware_component_state": "SetHardwareComponentState",
}


@pytest.fixture(scope="module")
def manager(client: Client, bringup: Bringup) -> Manager:
    return Manager(client)


def test_its_services_have_ros_s_types(client: Client, manager: Manager) -> None:
    kinds = {
        f"/controller_manager/{service}": [f"controller_manager_msgs/srv/{kind}"]
        for service, kind in SERVICES.items()
    }
    until(lambda: kinds.items() <= client.services().items(), "the manager's services")
    nodes = {"/controller_manager", f"/{JTC}"}
    until(lambda: nodes <= set(client.nodes()), "the manager's and a controller's node")


def test_what_runs_after_the_start(manager: Manager) -> None:
    assert manager.states() == {
        "joint_state_broadcaster": "active",
        JTC: "active",
        "robotiq_gripper_controller": "active",
        "robotiq_activation_controller": "active",
        "io_and_status_controller": "active",
        "speed_scaling_state_broadcaster": "active",
        "force_torque_sensor_broadcaster": "active",
        "tcp_pose_broadcaster": "active",
        "scaled_joint_trajectory_controller": "inactive",
        "passthrough_trajectory_controller": "inactive",
        "freedrive_mode_controller": "inactive",
        "force_mode_controller": "inactive",
    }
    jtc = manager.controllers()[JTC]
    assert jtc.type == "joint_trajectory_controller/JointTrajectoryController"
    assert set(jtc.claimed_interfaces) == CLAIMS
    assert set(jtc.required_command_interfaces) == CLAIMS
    assert set(jtc.required_state_interfaces) == {
        *CLAIMS,
        *(f"{joint}/velocity" for joint in ARM_JOINTS),
        "speed_scaling/speed_scaling_factor",
    }


def test_the_spawner_loads_configures_and_activates(
    client: Client, manager: Manager
) -> None:
    """First in the states that --load-only and --inactive leave it in."""
    kind = "forward_command_controller/ForwardCommandController"
    for name, value in (("params_file", [str(FILE)]), ("type", kind)):
        named = {f"{SPAWNED}.{name}": value}
        (answer,) = client.set_named(manager.name, named)
        assert answer.successful, answer.reason
        assert client.parameters(manager.name, f"{SPAWNED}.{name}") == [value]
    assert manager.load(SPAWNED)
    assert manager.states()[SPAWNED] == "unconfigured"
    assert not manager.load(SPAWNED)
    assert not manager.switch([SPAWNED])
    assert manager.configure(SPAWNED)
    assert manager.states()[SPAWNED] == "inactive"
    assert client.parameters(f"/{SPAWNED}", "interface_name", "joints") == [
        "position",
        list(ARM_JOINTS),
    ]
    assert not manager.switch([SPAWNED])  # JTC has its interfaces
    assert manager.states()[JTC] == "active"
    assert manager.switch([SPAWNED], [JTC])
    assert set(manager.controllers()[SPAWNED].claimed_interfaces) == CLAIMS
    assert not manager.unload(SPAWNED)  # while it is active
    # and on Ctrl-C, with --unload-on-kill:
    assert manager.switch(deactivate=[SPAWNED])
    assert manager.unload(SPAWNED)
    assert SPAWNED not in manager.states()
    until(lambda: f"/{SPAWNED}" not in client.nodes(), "the end of its node")
    assert manager.switch([JTC])


def test_strictness_decides_about_names_that_are_unknown(manager: Manager) -> None:
    assert not manager.switch(deactivate=["nobody", JTC])
    assert manager.states()[JTC] == "active"
    assert manager.switch(deactivate=["nobody", JTC], strictness=BEST_EFFORT)
    assert manager.states()[JTC] == "inactive"
    assert manager.switch(activate=[JTC])
    for lists in ([["nobody"], [JTC]], [[], ["nobody"]]):
        assert not manager.switch(*lists, strictness=BEST_EFFORT)
    assert manager.states()[JTC] == "active"
    assert manager.switch([JTC], [JTC])  # a restart
    assert manager.states()[JTC] == "active"


def test_parameters_are_described_and_lists_are_refused_in_words(
    client: Client, manager: Manager
) -> None:
    found = client.call(
        f"/{JTC}/describe_parameters",
        "rcl_interfaces/srv/DescribeParameters",
        names=["joints", "constraints.goal_time"],
    )
    assert [one.read_only for one in found.descriptors] == [True, False]
    assert all(one.description for one in found.descriptors)
    for name, value in {"joints": ["a"], "constraints.goal_time": [1.0, 2.0]}.items():
        (answer,) = client.set_named(f"/{JTC}", {name: value})
        assert not answer.successful
        assert "Expected" not in answer.reason


def test_a_controller_without_a_type_is_not_loaded(manager: Manager) -> None:
    assert not manager.load("nobody")
    assert not manager.configure("nobody")
    assert not manager.unload("nobody")


def test_ros2_control_lists_types_hardware_and_interfaces(manager: Manager) -> None:
    listed = manager.call("list_controller_types", "ListControllerTypes")
    bases = dict(zip(listed.types, listed.base_classes, strict=True))
    kind = "joint_trajectory_controller/JointTrajectoryController"
    assert bases[kind] == "controller_interface::ControllerInterface"
    components = manager.call("list_hardware_components", "ListHardwareComponents")
    assert {one.type for one in components.component} >= {"system"}
    assert all(one.state.label == "active" for one in components.component)
    found = manager.call("list_hardware_interfaces", "ListHardwareInterfaces")
    commands = {one.name: one for one in found.command_interfaces}
    for joint in ARM_JOINTS:
        assert commands[f"{joint}/position"].is_claimed
        assert not commands[f"{joint}/velocity"].is_claimed
        assert commands[f"{joint}/velocity"].is_available
    states = {one.name for one in found.state_interfaces}
    assert states >= {
        f"{joint}/{interface}"
        for joint in ARM_JOINTS
        for interface in ("position", "velocity", "effort")
    }


def test_the_activity_topic_tells_the_states(client: Client, manager: Manager) -> None:
    kind = "controller_manager_msgs/msg/ControllerManagerActivity"
    name = f"{manager.name}/activity"
    with client.listening(name, kind, latched=True) as activity:
        states = {one.name: one.state.label for one in activity.last.controllers}
        assert states[JTC] == "active"
        assert manager.switch(deactivate=[JTC])
        activity.wait_for(
            lambda message: any(
                one.name == JTC and one.state.label == "inactive"
                for one in message.controllers
            )
        )
        assert manager.switch(activate=[JTC])


def test_it_and_its_controllers_use_simulated_time(
    client: Client, manager: Manager
) -> None:
    for node in (manager.name, f"/{JTC}", "/joint_state_broadcaster"):
        assert client.parameters(node, "use_sim_time") == [True]


def test_its_update_rate_is_a_parameter(client: Client, manager: Manager) -> None:
    assert client.parameters(manager.name, "update_rate") == [125]  # the UR5 is a CB3
