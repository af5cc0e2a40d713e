"""Tool poses in requests, transformed to the frames of an arm."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

from tool0.description.forward_kinematics import link_poses

if TYPE_CHECKING:
    from tool0.description.model import RobotModel
    from tool0.kinematics.chain import ArmChain, Array


class OfTool(Protocol):
    """Fields that specify the tool in requests and targets."""

    @property
    def tip(self) -> str | None: ...
    @property
    def tool(self) -> Any: ...
    @property
    def relative_to(self) -> str | None: ...


class ToPose(OfTool, Protocol):
    """A request or target that contains a pose of the tool."""

    @property
    def pose(self) -> Any: ...


def tool_in_flange(model: RobotModel, chain: ArmChain, wanted: OfTool) -> Array:
    """Return the pose of the tool in the flange frame, shape (4, 4)."""
    import numpy as np

    from tool0.description.transform import as_matrix
    from tool0.kinematics.chain import fixed_transform

    T = np.eye(4) if wanted.tool is None else as_matrix(wanted.tool)
    if wanted.tip is None or wanted.tip == chain.tip:
        return T
    T_tip_tool: Array = fixed_transform(model, chain.tip, wanted.tip).matrix @ T
    return T_tip_tool


def pose_in_base(
    model: RobotModel,
    chain: ArmChain,
    wanted: ToPose,
    positions: Mapping[str, float],
) -> Array:
    """Return the pose in the frame of the link that carries the arm, shape (4, 4).

    ``positions`` are the positions of all joints [rad | m].
    """
    from tool0.description.transform import as_matrix

    found = link_poses(model, positions)
    T = as_matrix(wanted.pose)
    if wanted.relative_to is not None:
        T = found[model.link(wanted.relative_to).name].matrix @ T
    T_base_tool: Array = found[chain.base].inverse().matrix @ T
    return T_base_tool
