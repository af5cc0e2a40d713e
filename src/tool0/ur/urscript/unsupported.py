"""Functions of URScript that tool0 lacks, with the reasons for error messages."""

from __future__ import annotations

import re
from typing import Final

_REASONS: Final = (
    (r"(read|write)_port_.*", "the control box has no Modbus server of its own"),
    (r"(get|set|reset|stop|track)_conveyor.*", "there is no conveyor encoder"),
    (r"conveyor_.*|track_.*|encoder_.*", "there is no conveyor encoder"),
    (r"request_.*_from_primary_client", "there is no operator's screen"),
    (r"optimove[jl]", "OptiMove is not supported; use movej or movel"),
    (r"path_offset_.*", "path offsets are not supported"),
    (r"(end_)?screw_driving", "screw driving is not supported; use force_mode"),
    (r"tool_wrench_limit_.*", "limits of the tool's wrench are not supported"),
    (r"rtde_set_watchdog", "the RTDE watchdog is not supported in programs"),
    (r"powerdown", "use the dashboard server's 'shutdown'"),
    (r"(get|set|update)_world_model.*", "the world model is not supported"),
    (r"get_(joint|tool|controller)_temp", "temperatures are not simulated"),
    (r"set_base_acceleration|get_base_acceleration", "the base does not move"),
    (r"jacobian.*|get_jacobian.*|get_mass_matrix", "dynamics are not offered"),
    (r"direct_torque|torque_command", "direct torques are not supported"),
    (r"estimate_payload", "payloads are not estimated"),
    (r"(read|write)_(file|.*_file)", "programs cannot reach files"),
)


def reason_against(name: str) -> str | None:
    """Return why a function of URScript is not supported, or None."""
    for pattern, reason in _REASONS:
        if re.fullmatch(pattern, name):
            return reason
    return None
