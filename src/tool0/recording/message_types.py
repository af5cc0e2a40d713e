"""Definitions and serialization of a recording's ROS 2 message types with rosbags."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

JOINT_STATE: Final = "sensor_msgs/msg/JointState"
TRANSFORMS: Final = "tf2_msgs/msg/TFMessage"
WRENCH: Final = "geometry_msgs/msg/WrenchStamped"
POINTS: Final = "sensor_msgs/msg/PointCloud2"
IMAGE: Final = "sensor_msgs/msg/CompressedImage"
LOG: Final = "rcl_interfaces/msg/Log"
TEXT: Final = "std_msgs/msg/String"


@cache
def typestore() -> Typestore:
    """Return the type store of the ROS 2 message types."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_HUMBLE)


def definition(name: str) -> str:
    """Return the definition of a message type, including the types it contains."""
    text, _ = typestore().generate_msgdef(name, ros_version=2)
    return text


def message(kind: str, /, **fields: Any) -> bytes:
    """Return a message in CDR; the arguments are its fields."""
    store = typestore()
    return bytes(store.serialize_cdr(store.types[kind](**fields), kind))


def stamp_of(time: int) -> Any:
    """Return the builtin_interfaces/Time for a time [ns]."""
    sec, nanosec = divmod(time, 1_000_000_000)
    return typestore().types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec)
