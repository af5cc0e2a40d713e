"""Write the visual meshes and the collision primitives of arms and grippers.

Run ``python tools/make_meshes.py`` after changing a shape or an arm's kinematics. Give
``--output`` to write elsewhere, and names of models to write others than the bundled.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from meshes.arm import arm_shape
from meshes.arm_parameters import ARMS, with_kinematics
from meshes.files import write_model
from meshes.gripper import gripper_shape
from meshes.model import ModelShape

PACKAGE = Path(__file__).parents[1] / "src/tool0/ros_packages/tool0_description"
GRIPPERS = PACKAGE / "config" / "grippers"
BUNDLED = ("ur5", *sorted(file.parent.name for file in GRIPPERS.glob("*/macro.xacro")))


def model_shape(name: str) -> ModelShape:
    """Return the shapes of a model, with the kinematics in ``config/`` if there."""
    if (GRIPPERS / name).is_dir():
        return gripper_shape(GRIPPERS / name)
    arm = ARMS[name]
    kinematics = PACKAGE / "config" / "arms" / name / "default_kinematics.yaml"
    if kinematics.exists():
        arm = with_kinematics(arm, kinematics)
    return arm_shape(arm)


def main(arguments: Sequence[str]) -> None:
    """Write the models that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    known = sorted({*BUNDLED, *ARMS})
    parser.add_argument("models", nargs="*", help=", ".join(known))
    parser.add_argument("--output", type=Path, default=PACKAGE)
    options = parser.parse_args(arguments)
    for name in options.models or BUNDLED:
        if name not in known:
            parser.error(f"unknown model {name!r}: need {', '.join(known)}")
        files = write_model(model_shape(name), options.output)
        size = sum(file.stat().st_size for file in files)
        print(f"{name}: {len(files)} files, {size / 1000:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])
