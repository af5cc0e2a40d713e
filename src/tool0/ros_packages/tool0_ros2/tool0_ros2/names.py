"""ROS names of the robot, or of one robot of a cell."""

import re
from collections.abc import Callable, Sequence
from typing import Any

_COMMAND = re.compile(r"`tool0 controllers (\w+) ([^`]*)` or robot\.\w+\([^)]*\)")
"""Pattern of a command for a controller in the simulation's messages."""
_ROS_COMMANDS = {
    "start": "switch_controllers --activate {}",
    "switch": "switch_controllers {}",
    "load": "load_controller {}",
    "configure": "set_controller_state {} inactive",
}


class Names:
    """A ROS namespace that contains the whole robot, or one robot of a cell.

    In its own namespace, a robot of a cell has the names that it has outside a cell.
    For example, the model's ``left_elbow_joint`` is ``elbow_joint`` in ``/left``, and
    ``left_tool0`` is the frame ``left/tool0``. *Full* names are the model's names, and
    *own* names are the names in ROS.  If a robot has no namespace of its own, its full
    names and own names are the same.
    """

    def __init__(
        self,
        root: str,
        prefix: str = "",
        *,
        tf_prefix: str = "",
        longer: Sequence[str] = (),
    ) -> None:
        """Create the names for a namespace such as ``""`` or ``/robot1``.

        Args:
            root: The namespace, without a trailing slash.
            prefix: Prefix of the robot's full names, such as ``left_``.
            tf_prefix: Prefix of every frame, without leading and trailing slashes.
            longer: Prefixes of other robots that begin with this prefix.
        """
        self.root = root
        self.prefix = prefix
        self.tf_prefix = tf_prefix
        self._longer = tuple(longer)
        self._in_text = re.compile(rf"(?<!\w){re.escape(prefix)}(?=\w)")

    def owns(self, full: str) -> bool:
        """Return whether the namespace contains the item with this full name."""
        return full.startswith(self.prefix) and not full.startswith(self._longer)

    def to_ros(self, full: str) -> str:
        """Return the name in ROS for a full name.

        Names of other robots do not change.
        """
        return full[len(self.prefix) :] if self.owns(full) else full

    def to_model(self, own: str) -> str:
        """Return the full name for a name in ROS."""
        return self.prefix + own

    def text(self, text: object) -> str:
        """Return a message with names in ROS and with commands of ``ros2 control``."""
        own = self._in_text.sub("", str(text)) if self.prefix else str(text)
        return _COMMAND.sub(self._ros_command, own)

    def _ros_command(self, match: "re.Match[str]") -> str:
        verb, rest = match.groups()
        rest = rest.replace("--start", "--activate").replace("--stop", "--deactivate")
        manager = f" -c {self.root}/controller_manager" if self.root else ""
        return f"`ros2 control {_ROS_COMMANDS[verb].format(rest)}{manager}`"

    def own_values(self, value: Any) -> Any:
        """Return plain values whose keys and texts contain the names in ROS."""
        return _renamed(value, self.text) if self.prefix else value

    def topic(self, relative: str) -> str:
        """Return the full name of a topic or service in the namespace."""
        return relative if relative[:1] == "/" else f"{self.root}/{relative}"

    def frame(self, link: str) -> str:
        """Return the frame of a link, which is given by its full name."""
        own = self.to_ros(link)
        return f"{self.tf_prefix}/{own}" if self.tf_prefix else own


def _renamed(value: Any, rename: Callable[[str], str]) -> Any:
    if isinstance(value, dict):
        return {rename(k): _renamed(item, rename) for k, item in value.items()}
    if isinstance(value, list):
        return [_renamed(item, rename) for item in value]
    return rename(value) if isinstance(value, str) else value
