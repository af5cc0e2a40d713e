"""The options of the ROS 2 interface."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, final

from tool0.errors import ConfigError

MAX_DOMAIN: Final = 232
"""Largest ROS_DOMAIN_ID.  The ports of an ID above 101 may collide with the ports of
other programs."""
_NAMESPACE = re.compile(r"(/?[A-Za-z]\w*)(/[A-Za-z]\w*)*/?|/?")


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Ros2Options:
    """ROS 2."""

    ns: str = ""
    """Namespace of all ROS names, such as robot1, to separate several robots in one
    domain."""
    domain: int | None = None
    """ROS domain ID; None selects the value of the environment variable
    ROS_DOMAIN_ID."""
    tf_rate: float = 50.0
    """Rate of the transforms, in simulated time [Hz]."""
    camera_rate: float = 10.0
    """Maximum image rate of each camera, in simulated time [Hz]."""

    def __post_init__(self) -> None:
        if not _NAMESPACE.fullmatch(self.ns):
            raise ConfigError(
                f"'{self.ns}' is not a ROS namespace: write letters, digits and '_' "
                "between slashes, with a letter first in each part"
            )
        if self.domain is not None and not 0 <= self.domain <= MAX_DOMAIN:
            raise ConfigError(
                f"a ROS domain must be in [0, {MAX_DOMAIN}], got {self.domain}"
            )
        if not 0.0 < self.tf_rate <= 500.0:
            raise ConfigError(
                f"the rate of transforms must be in (0, 500] Hz, got {self.tf_rate:g}"
            )
        if not 0.0 < self.camera_rate <= 125.0:
            raise ConfigError(
                f"the rate of cameras must be in (0, 125] Hz, got {self.camera_rate:g}"
            )
