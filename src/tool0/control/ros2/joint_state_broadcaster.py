"""The parameters of joint_state_broadcaster: joints and interfaces to publish."""

from __future__ import annotations

from tool0.control.parameters import RobotJoints
from tool0.control.passive import PassiveSpec
from tool0.description.yaml_values import Namespace
from tool0.errors import ConfigError, did_you_mean


def parse(
    name: str, type_name: str, parameters: Namespace, robot: RobotJoints
) -> PassiveSpec:
    """Return the checked parameters of a JointStateBroadcaster.

    The broadcaster publishes the given ``interfaces`` of the given ``joints``.  If
    either list is empty, the broadcaster publishes all interfaces of the robot.
    """
    joints = parameters.texts("joints", ())
    interfaces = parameters.texts("interfaces", ())
    parameters.texts("extra_joints", ())
    parameters.text("frame_id", "base_link")
    parameters.boolean("use_local_topics", default=False)
    parameters.boolean("use_urdf_to_filter", default=True)
    parameters.boolean("publish_dynamic_joint_states", default=True)
    for kind in ("position", "velocity", "effort"):
        parameters.text(f"map_interface_to_joint_state/{kind}", kind)
    states = robot.joint_states
    if joints and interfaces:
        wanted = [f"{joint}/{kind}" for joint in joints for kind in interfaces]
        entry = parameters.find("joints") or parameters.entry
        for state in wanted:
            if state not in states:
                raise ConfigError(
                    f"'{entry.key}': the robot has no state interface '{state}'"
                    + did_you_mean(state, states),
                    entry.location,
                )
        states = tuple(wanted)
    return PassiveSpec(name=name, type=type_name, state_interfaces=states)
