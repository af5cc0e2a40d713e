from __future__ import annotations

import ast
import importlib
import inspect
import pydoc
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import tool0
import tool0.collect
import tool0.gym
import tool0.policy
import tool0.scene

ROOT = Path(__file__).parent.parent.parent

LOADED = """
import sys
import tool0
heavy = {"mujoco", "numpy", "yaml", "xacro", "logging", "socket"}
print(sorted(heavy & sys.modules.keys()))
"""

HANDLES = (
    *("Arm", "CameraHandle", "ControllerHandle", "ForceTorque", "GoalHandle"),
    *("Gripper", "Recording", "Robot", "SceneHandle", "Subscription"),
)
"""What a program holds: classes whose instances come from a robot."""
FUNCTIONS = ("bringup", "check", "connect", "find_bin", "pick_and_place")
INTERNAL = {"Channel", "ControllerSpec", "Engine", "Simulation", "Unset"}
"""Ways into the inside: for those who read the source."""


def test_import_starts_nothing_heavy() -> None:
    done = subprocess.run(
        [sys.executable, "-c", LOADED], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_exports_are_sorted() -> None:
    assert tool0.__all__ == sorted(tool0.__all__)
    assert tool0.scene.__all__ == sorted(tool0.scene.__all__)


def test_every_export_is_there_and_shown() -> None:
    for module in (tool0, tool0.scene):
        for name in module.__all__:
            assert getattr(module, name) is not None
        assert set(module.__all__) <= set(dir(module))


def test_a_type_checker_sees_the_same_names() -> None:
    tree = ast.parse(Path(tool0.__file__).read_text(encoding="utf-8"))
    imported = {
        alias.name: node.module
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if (node.module or "").startswith("tool0.")
    }
    assert imported == tool0._HOMES
    assert list(imported) != []
    assert tool0.__all__ == list(tool0._HOMES)


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    assert not hasattr(tool0, "no_such_name")


def own_classes(module: ModuleType) -> set[str]:
    """Return the classes of tool0 that a module defines or imports, also for types."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(inspect.getsource(module))):
        if isinstance(node, ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.ImportFrom) and (node.module or "")[:5] == "tool0":
            source = importlib.import_module(node.module or "")
            names |= {
                alias.name
                for alias in node.names
                if isinstance(getattr(source, alias.name, None), type)
            }
    return names


def annotations_of(name: str) -> str:
    """Return every annotation of a function, or of a class's public attributes."""
    item = getattr(tool0, name)
    members = [item]
    if isinstance(item, type):
        members = [
            getattr(value, "fget", None) or getattr(value, "__func__", value)
            for key, value in vars(item).items()
            if not key.startswith("_")
        ]
    found = [
        str(text)
        for member in members
        if inspect.isfunction(member)
        for text in member.__annotations__.values()
    ]
    return " ".join(found)


@pytest.mark.parametrize("name", [*HANDLES, *FUNCTIONS])
def test_what_is_taken_and_returned_is_exported(name: str) -> None:
    module = sys.modules[getattr(tool0, name).__module__]
    named = set(re.findall(r"[A-Za-z_]\w*", annotations_of(name)))
    needed = named & own_classes(module) - INTERNAL
    assert needed <= {*tool0.__all__, *tool0.scene.__all__}


@pytest.mark.parametrize("name", HANDLES)
def test_help_shows_every_public_attribute(name: str) -> None:
    kind = getattr(tool0, name)
    source = inspect.getsource(kind)
    if not hasattr(kind, "__dataclass_fields__"):
        assert re.findall(r"self\.([a-z]\w*)(?:: [^=\n]+)? = ", source) == []
    text = pydoc.plain(pydoc.render_doc(kind))
    for attribute, value in vars(kind).items():
        if not attribute.startswith("_") and not inspect.ismemberdescriptor(value):
            assert re.search(rf"^ \|  {attribute}\b", text, re.MULTILINE), attribute
            assert inspect.getdoc(value), attribute


def test_docs_and_examples_need_no_subpackage() -> None:
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    for path in [*pages, *(ROOT / "examples").glob("*.py")]:
        if path.name in ("CHANGELOG.md", "architecture.md"):
            continue
        found = re.findall(
            r"(?:from|import) (tool0\.[\w.]+)", path.read_text(encoding="utf-8")
        )
        assert set(found) <= {
            "tool0.collect",
            "tool0.gym",
            "tool0.policy",
            "tool0.scene",
        }, path


def test_the_reference_has_every_export() -> None:
    pages = (ROOT / "docs/reference/api").glob("*.rst")
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    listed = re.findall(r"^\.\. auto\w+:: (?:tool0\.)?(\S+)$", text, re.MULTILINE)
    scene = {f"scene.{name}" for name in tool0.scene.__all__ if name != "Pose"}
    gym = {f"gym.{name}" for name in tool0.gym.__all__}
    collect = {f"collect.{name}" for name in tool0.collect.__all__}
    policy = {f"policy.{name}" for name in tool0.policy.__all__}
    every = {*tool0.__all__, *scene, *gym, *collect, *policy}
    assert sorted(listed) == sorted(every)


def undocumented(name: str) -> list[str]:
    """Return the public members of a class that have no docstring."""
    kind = getattr(tool0, name, None) or getattr(tool0.scene, name)
    if not isinstance(kind, type):
        return [] if inspect.getdoc(kind) else [name]
    (tree,) = ast.parse(inspect.getsource(kind)).body
    assert isinstance(tree, ast.ClassDef)
    found = [] if ast.get_docstring(tree) else [name]
    for item, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(item, ast.FunctionDef):
            is_overload = any("overload" in ast.dump(d) for d in item.decorator_list)
            has = ast.get_docstring(item) or is_overload
            member = item.name
        elif isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
            member = item.target.id
            has = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        else:
            continue
        if not member.startswith("_") and not has:
            found.append(f"{name}.{member}")
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", [*tool0.__all__, *tool0.scene.__all__])
def test_every_public_member_is_documented(name: str) -> None:
    assert undocumented(name) == []
