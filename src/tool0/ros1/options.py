"""The options of the ROS 1 interface."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import final

from tool0.errors import ConfigError

NODE_NAME = "gazebo"
"""Name of the node, which is the same for all physics engines.  Clients, including
launch files, wait for the services of this node, such as /gazebo/…."""

_NAMESPACE = re.compile(r"(/?[A-Za-z]\w*)(/[A-Za-z]\w*)*/?|/?")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros1Options:
    """ROS 1."""

    roscore: bool = False
    """Start a roscore if none is running."""
    ns: str = ""
    """Namespace of all ROS names, such as robot1, to separate several robots that share
    one roscore."""
    tf_pub_rate: float = 125.0
    """Rate of the transforms, in simulated time [Hz]."""
    camera_rate: float = 10.0
    """Maximum image rate of each camera, in simulated time [Hz]."""

    def __post_init__(self) -> None:
        if not _NAMESPACE.fullmatch(self.ns):
            raise ConfigError(
                f"'{self.ns}' is not a ROS namespace: write letters, digits and '_' "
                "between slashes, with a letter first in each part"
            )
        if not 0.0 < self.tf_pub_rate <= 1000.0:
            raise ConfigError(
                f"the rate of transforms must be in (0, 1000] Hz, got "
                f"{self.tf_pub_rate:g}"
            )
        if not 0.0 < self.camera_rate <= 125.0:
            raise ConfigError(
                f"the rate of cameras must be in (0, 125] Hz, got {self.camera_rate:g}"
            )

    @property
    def root(self) -> str:
        """The namespace as the beginning of a name, such as ``""`` or ``/robot1``."""
        inner = self.ns.strip("/")
        return f"/{inner}" if inner else ""

    @property
    def node(self) -> str:
        """The node's full name."""
        return f"{self.root}/{NODE_NAME}"
