"""The arrays of a recording as named columns."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from tool0.description.tool_poses import POSE
from tool0.recording.snapshots import Arrays

Array = NDArray[np.float64]

_JOINT: Final = (
    "position",
    "velocity",
    "effort",
    "desired_position",
    "desired_velocity",
)
_WRENCH: Final = ("fx", "fy", "fz", "tx", "ty", "tz")
_GRIPPER: Final = ("opening", "speed", "force")


def columns_of(recording: Arrays) -> dict[str, Array]:
    """Return the columns of ``recording.table``."""
    columns = {
        f"{joint}.{quantity}": getattr(recording, quantity)[:, i]
        for quantity in _JOINT
        for i, joint in enumerate(recording.joint_names)
    }
    for parts, arrays in (
        (POSE, recording.objects),
        (_WRENCH, recording.wrenches),
        (_GRIPPER, recording.gripper_states),
        (POSE, recording.tool_poses),
    ):
        for name, values in arrays.items():
            columns |= {f"{name}.{part}": values[:, i] for i, part in enumerate(parts)}
    return columns
