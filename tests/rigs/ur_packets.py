"""A reader of UR's packets, from the tables of UR's documents.

It shares nothing with the code that writes them: names and types stand here once more.
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from typing import Any

MODE = (
    "timestamp:Q connected:? enabled:? power_on:? emergency_stopped:? "
    "protective_stopped:? program_running:? program_paused:? robot_mode:B "
    "control_mode:B target_speed_fraction:d speed_scaling:d speed_limit:d"
)
JOINT = (
    "q_actual:d q_target:d qd_actual:d I_actual:f V_actual:f T_motor:f T_micro:f mode:B"
)
TOOL = (
    "range_2:B range_3:B input_2:d input_3:d voltage_48:f output_voltage:B current:f "
    "temperature:f mode:B"
)
MASTERBOARD = (
    "inputs:I outputs:I range_0:B range_1:B input_0:d input_1:d domain_0:b domain_1:b "
    "output_0:d output_1:d temperature:f voltage_48:f robot_current:f io_current:f "
    "safety_mode:B reduced:B euromap:B reserved:I selector:B enabling_device:B"
)
CARTESIAN = "X:d Y:d Z:d Rx:d Ry:d Rz:d x:d y:d z:d rx:d ry:d rz:d"
KINEMATICS = "checksum:6I theta:6d a:6d d:6d alpha:6d status:I"
CONFIGURATION = (
    "limits:12d motion:12d v_joint:d a_joint:d v_tool:d a_tool:d radius:d a:6d d:6d "
    "alpha:6d theta:6d masterboard:i box:i robot:i sub_type:i"
)
FORCE = "wrench:6d dexterity:d"
PACKAGES = {
    0: ("mode", MODE),
    1: ("joints", JOINT),
    2: ("tool", TOOL),
    3: ("masterboard", MASTERBOARD),
    4: ("cartesian", CARTESIAN),
    5: ("kinematics", KINEMATICS),
    6: ("configuration", CONFIGURATION),
    7: ("force", FORCE),
    8: ("additional", "teach_pressed:B teach_enabled:B"),
    11: ("connection", "enabled:? baud:i parity:i stop_bits:i rx:f tx:f"),
    12: ("tool_mode", "output:B pin_0:B pin_1:B"),
}
REALTIME = (
    "time:d q_target:6d qd_target:6d qdd_target:6d I_target:6d M_target:6d q_actual:6d "
    "qd_actual:6d I_actual:6d I_control:6d tool_vector:6d tcp_speed:6d tcp_force:6d "
    "tool_vector_target:6d tcp_speed_target:6d digital_inputs:d temperatures:6d "
    "timer:d test:d robot_mode:d joint_modes:6d safety_mode:d unused_1:6d "
    "accelerometer:3d unused_2:6d speed_scaling:d momentum:d unused_3:d unused_4:d "
    "V_main:d V_robot:d I_robot:d V_actual:6d digital_outputs:d program_state:d "
    "elbow_position:3d elbow_velocity:3d safety_status:d unused_5:3d payload_mass:d "
    "payload_cog:3d payload_inertia:6d"
)
MESSAGES = {
    0: ("text", ""),
    2: ("popup", "request:I kind:B warning:? error:? blocking:? title:s"),
    3: ("version", "name:s major:B minor:B bugfix:i build:i"),
    5: ("safety", "code:i argument:i mode:B data_type:I data:I"),
    6: ("error", "code:i argument:i level:i data_type:I data:I"),
    7: ("key", "code:i argument:i title:s"),
    10: ("exception", "line:i column:i"),
}


def unpack(fields: str, data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return named values, and what is left."""
    values: dict[str, Any] = {}
    for field in fields.split():
        name, form = field.split(":")
        if form == "s":
            form, data = f"{data[0]}s", data[1:]
        size = struct.calcsize(f">{form}")
        items = struct.unpack(f">{form}", data[:size])
        values[name] = items[0] if len(items) == 1 else items
        if form.endswith("s"):
            values[name] = values[name].decode()
        data = data[size:]
    return values, data


def state(packet: bytes) -> dict[str, Any]:
    """Return the sub-packages of a packet of type 16."""
    found: dict[str, Any] = {}
    data = packet[5:]
    while data:
        size, kind = struct.unpack(">iB", data[:5])
        name, fields = PACKAGES[kind]
        body, data = data[5:size], data[size:]
        if name == "joints":
            found[name] = []
            while body:
                joint, body = unpack(fields, body)
                found[name].append(joint)
        else:
            found[name], rest = unpack(fields, body)
            assert len(rest) <= 2, f"{name} has {len(rest)} bytes too many"
            found[f"{name}_size"] = size
    return found


def message(packet: bytes) -> tuple[str, dict[str, Any]]:
    """Return the kind and the content of a packet of type 20."""
    head, data = unpack("size:i type:B timestamp:Q source:b kind:B", packet)
    name, fields = MESSAGES[head["kind"]]
    values, rest = unpack(fields, data)
    return name, values | {"text": rest.decode(), "source": head["source"]}


class Packets:
    """Reads whole packets of the primary or secondary interface."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            piece = self.connection.recv(count - len(data))
            if not piece:
                raise ConnectionError("the connection has ended")
            data += piece
        return data

    def next(self) -> bytes:
        """Return the next packet."""
        head = self._exactly(4)
        return head + self._exactly(int.from_bytes(head, "big") - 4)

    def states(self) -> Iterator[dict[str, Any]]:
        """Return the states that arrive."""
        while True:
            packet = self.next()
            if packet[4] == 16:
                yield state(packet)

    def messages(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Return the messages that arrive."""
        while True:
            packet = self.next()
            if packet[4] == 20:
                yield message(packet)

    def realtime(self) -> dict[str, Any]:
        """Return the next packet of the real-time interface."""
        packet = self.next()
        values, rest = unpack(REALTIME, packet[4:])
        assert not rest
        return values
