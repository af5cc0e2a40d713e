"""The parameters that the built-in arms are drawn from, by name."""

from __future__ import annotations

from make_meshes import arm_folders
from meshes.arm_parameters import read_parameters

ARMS = {folder.name: read_parameters(folder) for folder in arm_folders()}
