"""Grippers, drawn from the places of their joints in ``kinematics.yaml``.

Two kinds: fingers that swing on parallelograms below a dark tapered body, and fingers
that slide on a dark round one.  The left finger is the right one turned by pi about z,
so that one mesh serves both.
"""

from __future__ import annotations

from pathlib import Path

import yaml

from .model import ModelShape
from .sliding_fingers import SlidingFingers
from .swinging_fingers import SwingingFingers

MATERIALS = {
    "black": (0.16, 0.16, 0.17, 1.0),
    "grey": (0.68, 0.69, 0.71, 1.0),
    "metal": (0.82, 0.83, 0.84, 1.0),
    "rubber": (0.20, 0.20, 0.21, 1.0),
}


def gripper_shape(folder: Path) -> ModelShape:
    """Return the shapes of the gripper in ``folder``, one for both fingers."""
    places = yaml.safe_load((folder / "kinematics.yaml").read_text())["kinematics"]
    kind = SwingingFingers if "outer_knuckle" in places else SlidingFingers
    return ModelShape(
        kind="grippers",
        name=folder.name,
        materials=MATERIALS,
        links=kind(places).links(),
    )
