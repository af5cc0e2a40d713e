"""The parameter server: what launch files would have put there."""

from __future__ import annotations

import logging
from typing import Any

import yaml

from tool0.api.robot import Robot
from tool0.errors import RosUnavailableError
from tool0.interfaces.ros1.meshes import with_found_meshes
from tool0.interfaces.ros1.node import RosNode

logger = logging.getLogger(__name__)


def upload(node: RosNode, robot: Robot) -> None:
    """Set robot_description, the controllers' YAML, and that time is simulated."""
    node.master.call("setParam", "/use_sim_time", True)
    urdf = with_found_meshes(robot.description.urdf)
    node.master.call("setParam", node.name("robot_description"), urdf)
    for name, value in robot.info.parameters.items():
        if (storable := _storable(value)) is not None:
            node.master.call("setParam", node.name(name), storable)


def _storable(value: object) -> object:
    """Return ``value`` as XML-RPC can carry it: no null, and integers of 32 bits."""
    match value:
        case dict():
            items = ((str(name), _storable(item)) for name, item in value.items())
            return {name: item for name, item in items if item is not None}
        case list():
            return [item for item in map(_storable, value) if item is not None]
        case bool():
            return value
        case int() if not -(2**31) <= value < 2**31:
            return float(value)
    return value


def controller_yaml(node: RosNode, name: str) -> str | None:
    """Return the parameters of a controller as YAML, None if the server has none."""
    try:
        value: Any = node.master.call("getParam", node.name(name))
    except RosUnavailableError:
        return None
    if not isinstance(value, dict) or "type" not in value:
        return None
    return yaml.safe_dump({name.strip("/"): value}, sort_keys=False)
