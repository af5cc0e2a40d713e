"""Whatever a Python launch file does, it is read without an exception."""

from __future__ import annotations

import ast
import random
from pathlib import Path

import pytest

from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.installation.colcon.bringup import colcon_packages
from tool0.lint.launch.argument_flow import argument_flow
from tool0.lint.launch.explanation import contents
from tool0.lint.launch.reader import read_launch
from tool0.lint.launch.xacro_files import xacro_robots
from tool0.lint.packages import PackageIndex

pytestmark = pytest.mark.slow

CONTROLLERS = """
controller_manager:
  ros__parameters:
    arm: {type: joint_trajectory_controller/JointTrajectoryController}
arm:
  ros__parameters:
    joints: [elbow_joint]
"""
OTHERS = ("None", "3", "'x'", "[]", "{}", "()", "True", "f()", "[x for x in 1]", "f''")


class Mutation(ast.NodeTransformer):
    """Replaces one expression in fifty by another one."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)

    def visit(self, node: ast.AST) -> ast.AST:
        inner = self.generic_visit(node)
        is_read = isinstance(getattr(node, "ctx", ast.Load()), ast.Load)
        if isinstance(node, ast.expr) and is_read and self._random.random() < 0.02:
            return ast.parse(self._random.choice(OTHERS), mode="eval").body
        return inner


@pytest.fixture(scope="module")
def launch_files() -> list[str]:
    """The launch files that `tool0 workspace --ros2` writes."""
    description = load_description(DescriptionConfig(ros2_control=True))
    files = colcon_packages(description, controllers=CONTROLLERS, started=["arm"])
    return [data.decode() for path, data in files.items() if path.suffix == ".py"]


@pytest.mark.parametrize("seed", range(5))
def test_a_launch_file_with_other_expressions_is_read(
    launch_files: list[str], seed: int, tmp_path: Path
) -> None:
    packages = PackageIndex({})
    for number, text in enumerate(launch_files):
        tree = Mutation(seed).visit(ast.parse(text))
        file = tmp_path / f"{number}.launch.py"
        try:
            file.write_text(ast.unparse(ast.fix_missing_locations(tree)))
        except (ValueError, TypeError, AttributeError):
            continue  # such a tree has no text
        launch = read_launch(file, {}, packages)
        robots = xacro_robots(launch, packages)
        contents(launch, robots)
        argument_flow(launch, robots)
        assert all(finding.location.file for finding in launch.findings)
