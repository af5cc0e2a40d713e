"""The parameter server: what launch files would have set, and controllers' YAML."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import yaml

from tool0.api.robot import Robot
from tool0.description.packages import BUNDLED
from tool0.errors import RosUnavailableError

if TYPE_CHECKING:
    from tool0.interfaces.ros1.node import RosNode  # not importable without ROS


def upload_parameters(node: RosNode, robot: Robot) -> None:
    """Set use_sim_time, robot_description and the controllers' YAML."""
    node.master.call("setParam", "/use_sim_time", True)
    urdf = with_mesh_files(robot.description.urdf)
    node.master.call("setParam", node.name("robot_description"), urdf)
    for name, value in robot.info.parameters.items():
        if (converted := _to_xmlrpc(value)) is not None:
            node.master.call("setParam", node.name(name), converted)


def with_mesh_files(urdf: str) -> str:
    """Return the URDF with ``file://`` URIs for the meshes that tool0 bundles.

    ROS does not know the packages inside tool0: RViz would show no robot unless their
    folder were in ``ROS_PACKAGE_PATH``.  Other ``package://`` URIs stay as they are.
    """
    for folder in BUNDLED.iterdir():
        if (folder / "package.xml").is_file():
            urdf = urdf.replace(f"package://{folder.name}/", f"{folder.as_uri()}/")
    return urdf


def controller_yaml(node: RosNode, name: str) -> str | None:
    """Return the parameters of a controller as YAML, None if the server has none."""
    try:
        value: Any = node.master.call("getParam", node.name(name))
    except RosUnavailableError:
        return None
    if not isinstance(value, dict) or "type" not in value:
        return None
    return yaml.safe_dump({name.strip("/"): value}, sort_keys=False)


def _to_xmlrpc(value: object) -> object:
    """Return ``value`` as XML-RPC can carry it: no null, and integers of 32 bits."""
    match value:
        case dict():
            items = ((str(name), _to_xmlrpc(item)) for name, item in value.items())
            return {name: item for name, item in items if item is not None}
        case list():
            return [item for item in map(_to_xmlrpc, value) if item is not None]
        case bool():
            return value
        case int() if not -(2**31) <= value < 2**31:
            return float(value)
    return value
