"""The node's source: ROS 2's own Python runs it, without tool0's packages."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

import tool0
from tool0.control.ros2.dialect import ROS2

FOLDER = Path(tool0.__file__).parent / "ros_packages" / "tool0_ros2"
FILES = sorted(FOLDER.glob("tool0_ros2/*.py"))
OLDEST_PYTHON = (3, 10)


def imported(tree: ast.AST) -> set[str]:
    """Return the top-level packages that a module imports, anywhere in it.

    Not those for annotations: under ``if TYPE_CHECKING`` at its top level.
    """
    found = set()
    executed = [
        node
        for node in getattr(tree, "body", [tree])
        if not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    ]
    for node in (inner for part in executed for inner in ast.walk(part)):
        if isinstance(node, ast.Import):
            found |= {name.name.partition(".")[0] for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "a relative import"
            found.add(str(node.module).partition(".")[0])
    return found


def is_allowed(package: str) -> bool:
    """Return whether a package is Python's own, rclpy, the node, or has messages."""
    return (
        package in sys.stdlib_module_names
        or package in {"rclpy", "tool0_ros2"}
        or package.endswith(("_msgs", "_interfaces", "_srvs"))
    )


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_it_imports_python_rclpy_and_messages_only(file: Path) -> None:
    tree = ast.parse(file.read_text(), feature_version=OLDEST_PYTHON)
    assert [name for name in imported(tree) if not is_allowed(name)] == []


def test_another_import_is_found() -> None:
    source = "def f():\n    import numpy as np, json\n    from msgspec import json\n"
    found = imported(ast.parse(source))
    assert {name for name in found if not is_allowed(name)} == {"numpy", "msgspec"}


@pytest.mark.slow
def test_what_the_node_cannot_do_without_is_a_dependency_of_the_ros_package() -> None:
    trees = [ast.parse(file.read_text()) for file in FILES]
    for tree in trees:  # packages that a function imports may be missing
        tree.body = [n for n in tree.body if isinstance(n, ast.Import | ast.ImportFrom)]
    packages = set().union(*map(imported, trees))
    needed = packages - sys.stdlib_module_names - {"tool0_ros2"}
    declared = (FOLDER / "package.xml").read_text()
    assert [
        n for n in needed if f"<exec_depend>{n}</exec_depend>" not in declared
    ] == []


def test_every_controller_that_can_be_loaded_is_presented() -> None:
    tree = ast.parse((FOLDER / "tool0_ros2" / "registry.py").read_text())
    (table,) = (
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign)
        and isinstance(node.targets[0], ast.Name)
        and node.targets[0].id == "CONTROLLERS"
    )
    assert isinstance(table, ast.Dict)
    presented = {key.value for key in table.keys if isinstance(key, ast.Constant)}
    assert presented == set(ROS2.types)
