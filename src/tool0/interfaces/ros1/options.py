"""What a person may say about the ROS 1 edge, as a value."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import final

from tool0.errors import ConfigError

NODE_NAME = "gazebo"
"""As in the launch files: clients wait for /gazebo/…, on either engine."""

_NAMESPACE = re.compile(r"(/?[A-Za-z]\w*)(/[A-Za-z]\w*)*/?|/?")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros1Options:
    """How a bring-up appears in ROS."""

    ns: str = ""
    """Put before every relative name, as by ``<group ns=…>``."""
    tf_prefix: str = ""
    """Put before every frame, as robot_state_publisher does."""
    tf_pub_rate: float = 125.0
    """Transforms per second of simulated time [Hz]."""
    camera_rate: float = 10.0
    """Pictures of each camera per second of simulated time [Hz], at most."""
    roscore: bool = False
    """Whether to start a roscore where none answers."""

    def __post_init__(self) -> None:
        if not _NAMESPACE.fullmatch(self.ns):
            raise ConfigError(
                f"'{self.ns}' is no namespace of ROS: write letters, digits and '_', "
                "between slashes, each part with a letter first"
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
    def frames(self) -> str:
        """The prefix of frames, without slashes around it."""
        return self.tf_prefix.strip("/")

    @property
    def root(self) -> str:
        """The namespace as the beginning of a name: ``""`` or ``/robot1``."""
        inner = self.ns.strip("/")
        return f"/{inner}" if inner else ""

    @property
    def node(self) -> str:
        """The node's full name."""
        return f"{self.root}/{NODE_NAME}"
