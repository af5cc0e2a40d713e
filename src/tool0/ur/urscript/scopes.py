"""Scopes of variables and functions (URScript manual, "Scoping rules").

Variables at the program's first level are global. In a function or thread, a name is
global if the program has a global variable with this name. A name is local if the
program has no global variable with this name, or if the name is declared with
``local``. Functions and threads are visible in the body that defines them and in all
bodies inside that body.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

from tool0.ur.urscript import syntax as s

_OUTPUTS: Final = "digital_out"


@final
@dataclass(frozen=True, slots=True)
class Scope:
    """The names that the body of a definition can use."""

    definition: s.Definition
    parent: Scope | None
    functions: dict[str, s.Definition]
    """Definitions in this body, by name."""
    locals: frozenset[str]
    globals: frozenset[str]
    """Global names of the program, which are the same in all scopes."""

    def find(self, name: str) -> tuple[s.Definition, Scope] | None:
        """Return a visible function or thread and the scope that defines it."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.functions:
                return scope.functions[name], scope
            scope = scope.parent
        return None

    def output_call(self, statement: s.Assign) -> s.Evaluate | None:
        """Return the call that ``digital_out[n] = b`` stands for; None for a variable.

        The assignment is the oldest form of ``set_digital_out(n, b)``, which urx still
        sends.
        """
        name, at = statement.name, statement.at
        if name != _OUTPUTS or len(statement.indexes) != 1:
            return None
        if name in self.locals or name in self.globals:
            return None
        values = (*statement.indexes, statement.value)
        arguments = tuple(s.Argument(at, None, value) for value in values)
        return s.Evaluate(at, s.Call(at, "set_digital_out", arguments))

    def visible_functions(self) -> list[str]:
        """Return the names of all visible functions and threads."""
        own = list(self.functions)
        return own + (self.parent.visible_functions() if self.parent else [])

    def extended(self, block: s.Block) -> Scope:
        """Return the scope, extended with names in additional statements of the body.

        New variables are global at the program's first level and local in a function.
        """
        own = list(_own(block))
        functions = {item.name: item for item in own if isinstance(item, s.Definition)}
        known, local = set(self.globals), set(self.locals)
        for item in own:
            if not isinstance(item, s.Assign) or item.indexes:
                continue
            if self.parent is None or item.scope == "global":
                known.add(item.name)
            elif item.scope == "local" or item.name not in known:
                local.add(item.name)
        return Scope(
            self.definition,
            self.parent,
            {**self.functions, **functions},
            frozenset(local),
            frozenset(known),
        )

    def inner(self, definition: s.Definition) -> Scope:
        """Return the scope of a definition inside the body of the scope."""
        return _scope(definition, self, self.globals)


def program_scope(program: s.Definition) -> Scope:
    """Return the scope of a complete program."""
    own = {
        item.name
        for item in _own(program.body)
        if isinstance(item, s.Assign) and not item.indexes
    }
    declared = {
        item.name
        for item in _all(program.body)
        if isinstance(item, s.Assign) and item.scope == "global"
    }
    return _scope(program, None, frozenset(own | declared))


def _scope(
    definition: s.Definition, parent: Scope | None, known: frozenset[str]
) -> Scope:
    own = list(_own(definition.body))
    functions = {item.name: item for item in own if isinstance(item, s.Definition)}
    local = {item.name for item in definition.parameters}
    if parent is not None:
        for item in own:
            is_local = isinstance(item, s.Assign) and (
                item.scope == "local"
                or (item.scope is None and not item.indexes and item.name not in known)
            )
            if is_local and isinstance(item, s.Assign):
                local.add(item.name)
    return Scope(definition, parent, functions, frozenset(local), known)


def _own(block: s.Block) -> Iterator[s.Statement]:
    """Yield the statements of a body, without the statements of nested definitions."""
    for item in block:
        yield item
        for inner in _blocks(item):
            yield from _own(inner)


def _all(block: s.Block) -> Iterator[s.Statement]:
    for item in _own(block):
        yield item
        if isinstance(item, s.Definition):
            yield from _all(item.body)


def _blocks(item: s.Statement) -> tuple[s.Block, ...]:
    if isinstance(item, s.While):
        return (item.body,)
    if isinstance(item, s.If):
        return (*(body for _, body in item.branches), item.otherwise)
    return ()
