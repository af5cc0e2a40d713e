"""URScript functions that tool0 does not support, with reasons for error messages."""

from __future__ import annotations

import re
from typing import Final

_REASONS: Final = (
    (r"(read|write)_port_.*", "the control box has no Modbus server of its own"),
    (r"(get|set|reset|stop|track)_conveyor.*", "there is no conveyor"),
    (r"conveyor_.*|track_.*|encoder_enable_pulse_decode", "there is no conveyor"),
    (r"eip_.*", "there is no EtherNet/IP adapter"),
    (r"(get|set)_euromap_.*", "there is no injection moulding machine (Euromap 67)"),
    (r"ros_.*_factory", "there is no ROS inside of the control box; see --ros2"),
    (
        r"(tool_)?serial_.*|tool_serial_config",
        "the tool has no serial line",
    ),
    (r"request_.*_from_primary_client", "there is no operator's screen"),
    (r"path_offset_.*", "path offsets are not supported"),
    (r"tool_wrench_limit_set", "limits of the tool's wrench are not supported"),
    (r"jerk_gain_scaling_.*", "there is one kind of profiles"),
    (r"reset_revolution_counter", "no joint turns without limits"),
    (r"(get|set|update|reset)_world_model.*", "there is no world model"),
    (r"(add|attach|delete|move|is)_frame|frame_.*", "there is no world model"),
    (
        r"delete_all_frames|get_frame_parent|get_children",
        "there is no world model",
    ),
    (r"convert_pose|get_pose|set_mass_properties", "there is no world model"),
    (r"set_payload_from_attached_frames", "there is no world model"),
    (r"torque_command", "it is called direct_torque since PolyScope 5.23"),
    (r"estimate_payload", "payloads are not estimated"),
    (r"(read|write)_(file|.*_file)", "programs cannot reach files"),
)


def reason_against(name: str) -> str | None:
    """Return the reason why a URScript function is not supported, or None."""
    for pattern, reason in _REASONS:
        if re.fullmatch(pattern, name):
            return reason
    return None
