"""Write the visual meshes and the collision primitives of arms and grippers.

Run ``python tools/make_meshes.py`` after you change a shape, or an arm's
appearance.yaml or kinematics.  Use ``--output`` to write to another folder.  If you
give folders of your own arms, the meshes of each arm are written into the arm's folder.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from meshes.arm import arm_shape
from meshes.arm_parameters import read_parameters
from meshes.files import write_models, write_own
from meshes.gripper import gripper_shape
from meshes.model import ModelShape

PACKAGE = Path(__file__).parents[1] / "src/tool0/ros_packages/tool0_description"


def arm_folders() -> list[Path]:
    """Return the folders of the built-in arms: ur3, ur3e, …, ur30."""
    found = (PACKAGE / "config" / "arms").glob("*/appearance.yaml")
    return sorted((file.parent for file in found), key=_natural)


def model_shapes() -> Iterator[ModelShape]:
    """Yield the shapes of all built-in models."""
    for folder in arm_folders():
        yield arm_shape(read_parameters(folder))
    for file in sorted((PACKAGE / "config" / "grippers").glob("*/macro.xacro")):
        yield gripper_shape(file.parent)


def _natural(folder: Path) -> tuple[int, str]:
    digits = re.sub(r"\D", "", folder.name)
    return int(digits or 0), folder.name


def main(arguments: Sequence[str]) -> None:
    """Write the models that the command line specifies."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path, help="arms of your own")
    parser.add_argument("--output", type=Path, default=PACKAGE)
    options = parser.parse_args(arguments)
    files = []
    for folder in options.folders:
        files += write_own(arm_shape(read_parameters(folder)), folder)
    if not options.folders:
        files += write_models(model_shapes(), options.output)
    size = sum(file.stat().st_size for file in files)
    print(f"{len(files)} files, {size / 1000:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])
