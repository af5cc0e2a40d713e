"""Write copies of the definitions that the ROS 2 node shares with tool0.

The node runs under another Python, without tool0's packages.  The node gets exact
copies, so that the code of an address and of a joint's motion is written only once.
Definitions on which the copied definitions depend are also copied.
"""

from __future__ import annotations

import ast
import importlib
import inspect
from functools import cache
from typing import Final

from tools.ros2_requests import NODE, formatted

MODULE = NODE / "copied.py"
COPIED: Final = (
    ("tool0.protocol.address", ("folders", "socket_path", "insecurity", "is_foreign")),
    ("tool0.description.transform", ("from_quaternion",)),
    ("tool0.description.model", ("Mimic",)),
    ("tool0.description.forward_kinematics", ("joint_transform",)),
)
"""Names of the copied definitions, by module."""
OWN: Final = {"TransportError": "errors", "Joint": "kinematics"}
"""Names that the node itself defines, with their modules.  A Joint is only an
annotation."""
HEAD: Final = '''\
"""Definitions that the node shares with tool0.

Copied by tools/ros2_copies.py from tool0's modules; do not edit.
"""

from __future__ import annotations
'''


class _Copies:
    """Copied definitions.

    Each definition comes after the definitions that it needs.
    """

    def __init__(self) -> None:
        self.texts: dict[tuple[str, str], str] = {}
        self.imports: set[str] = set()
        self.imports_for_types: set[str] = set()

    def add(self, module: str, name: str) -> None:
        """Add a definition of a module, and all definitions that it names."""
        if (module, name) in self.texts:
            return
        source, tree = _read(module)
        for statement in tree.body:
            if name in _defined(statement):
                self._add_definition(module, name, statement, source)
            self._add_import(statement, name, self.imports)
            if isinstance(statement, ast.If):  # this is an ``if TYPE_CHECKING``
                for inner in statement.body:
                    self._add_import(inner, name, self.imports_for_types)

    def _add_definition(
        self, module: str, name: str, statement: ast.stmt, source: list[str]
    ) -> None:
        self.texts[module, name] = ""
        left_out = [
            item for item in getattr(statement, "body", []) if _is_left_out(item)
        ]
        for item in ast.walk(statement):
            is_kept = not any(item in ast.walk(method) for method in left_out)
            for needed in sorted(_names(item)) if is_kept else ():
                self.add(module, needed)
        del self.texts[module, name]
        dropped = {line for item in left_out for line in _lines(item)}
        lines = [k for k in _lines(statement) if k not in dropped]
        self.texts[module, name] = "\n".join(source[k - 1] for k in lines)

    def _add_import(self, statement: ast.stmt, name: str, found: set[str]) -> None:
        if not isinstance(statement, ast.Import | ast.ImportFrom):
            return
        for item in statement.names:
            if name != (item.asname or item.name):
                continue
            origin = getattr(statement, "module", None) or ""
            if name in OWN:
                is_type = name == "Joint"
                where = self.imports_for_types if is_type else self.imports
                where.add(f"from tool0_ros2.{OWN[name]} import {name}")
            elif origin.startswith("tool0."):
                self.add(origin, name)
            else:
                one = (
                    ast.ImportFrom(origin, [item], 0) if origin else ast.Import([item])
                )
                found.add(ast.unparse(one))


@cache
def _read(module: str) -> tuple[list[str], ast.Module]:
    source = inspect.getsource(importlib.import_module(module))
    return source.splitlines(), ast.parse(source)


def _defined(statement: ast.stmt) -> set[str]:
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        return {statement.name}
    targets = getattr(statement, "targets", [getattr(statement, "target", None)])
    return {item.id for item in targets if isinstance(item, ast.Name)}


def _names(item: ast.AST) -> set[str]:
    """Return the names in a node.

    Names in the text of a type variable are included.
    """
    if isinstance(item, ast.Name):
        return {item.id}
    if not (isinstance(item, ast.Call) and ast.unparse(item.func) == "TypeVar"):
        return set()
    texts = [arg.value for arg in item.args[1:] if isinstance(arg, ast.Constant)]
    return {
        part.id
        for text in texts
        for part in ast.walk(ast.parse(str(text)))
        if isinstance(part, ast.Name)
    }


def _is_left_out(statement: ast.stmt) -> bool:
    """Return whether a method is omitted from the copies.

    A method is omitted if it needs NumPy, which the node's Python may lack, or if it
    checks values from users.  The node gets only checked values.
    """
    return isinstance(statement, ast.FunctionDef) and (
        statement.name == "__post_init__"
        or any(
            isinstance(item, ast.Import) and item.names[0].name == "numpy"
            for item in statement.body
        )
    )


def _lines(statement: ast.stmt) -> range:
    """Return the line numbers of a definition, including its decorators."""
    first = [statement, *getattr(statement, "decorator_list", [])]
    assert statement.end_lineno is not None
    return range(min(item.lineno for item in first), statement.end_lineno + 1)


def module_text() -> str:
    """Return the text of the module with the copies."""
    copies = _Copies()
    for module, names in COPIED:
        for name in names:
            copies.add(module, name)
    for_types = "\n".join(f"    {line}" for line in sorted(copies.imports_for_types))
    imports = {*copies.imports, "from typing import TYPE_CHECKING"}
    head = [HEAD, *sorted(imports), f"if TYPE_CHECKING:\n{for_types}"]
    return formatted("\n".join([*head, *copies.texts.values()]), MODULE)


if __name__ == "__main__":
    MODULE.write_text(module_text(), encoding="utf-8")
