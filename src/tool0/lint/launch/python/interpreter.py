"""Interprets the Python code of a launch file without executing it.

Statements are processed in order.  If a condition is unknown, both branches are
processed, and everything that they add is marked as uncertain.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final, final

from tool0.description.finding import Finding, error_at
from tool0.errors import SourceLocation
from tool0.lint.launch.python import grammar
from tool0.lint.launch.python.expressions import (
    Call,
    Expressions,
    assign,
    choice,
    iterated,
)
from tool0.lint.launch.python.library import (
    FUNCTIONS,
    PACKAGE_FOLDERS,
    call_function,
    call_method,
    change,
)
from tool0.lint.launch.python.values import (
    Choice,
    Function,
    Made,
    Method,
    Name,
    Scope,
    Unknown,
    Value,
    truth,
)

MAX_STEPS: Final = 200_000
"""Largest number of expressions and statements that are evaluated in one file."""
MAX_CALLS: Final = 30
"""Largest depth of nested calls of functions that the file defines."""
_XACRO: Final = ("xacro.process_file", "xacro.process")


class TooLongError(Exception):
    """Raised if the evaluation of the file takes too many steps."""


class _Return(Exception):  # noqa: N818  # control flow
    """Raised by a ``return`` statement, with the returned value."""

    def __init__(self, value: Value) -> None:
        self.value = value


class _Leave(Exception):  # noqa: N818  # control flow
    """Raised if the remaining statements of a branch or loop are not reached."""

    def __init__(self, node: ast.stmt) -> None:
        self.is_continue = isinstance(node, ast.Continue)
        self.is_break = isinstance(node, ast.Break)


@final
class Interpreter:
    """Interpreter of one file.

    The module is interpreted first, and then its functions.
    """

    def __init__(
        self,
        file: Path,
        tree: ast.Module,
        package_folder: Callable[[Value, SourceLocation], Value],
        perform: Callable[[Value], Value],
    ) -> None:
        """Interpret the module.

        Args:
            file: The launch file.
            tree: The file's syntax tree.
            package_folder: Function that returns the share folder of a package.
            perform: Function that returns the current value of a substitution.
        """
        self.findings: list[Finding] = []
        self._file = file
        self._package_folder, self._perform = package_folder, perform
        self._left = MAX_STEPS
        self._depth = 0
        self._uncertain = 0
        self._returns: list[list[Value]] = [[]]
        self._expressions = Expressions(
            call=self.call,
            look_up=self._look_up,
            misused=self._misused,
            locate=self._locate,
            spend=self._spend,
        )
        self.module = Scope(names={"__file__": str(file), "__name__": "launch"})
        with suppress(_Return, _Leave):
            self._run(tree.body, self.module)

    # --- calls ---

    def call(self, call: Call) -> Value:
        """Return the result of a call."""
        match call.function:
            case Function():
                return self.run(
                    call.function, call.arguments, call.keywords, is_whole=call.is_whole
                )
            case Name():
                return self._call_name(call.function, call)
            case Method(owner=owner, name=name):
                return self._call_method(owner, name, call)
        return Unknown("a call of something unknown")

    def run(
        self,
        function: Function,
        arguments: tuple[Value, ...],
        keywords: Mapping[str, Value],
        *,
        is_whole: bool = True,
    ) -> Value:
        """Return the result of a function that the file defines."""
        if self._depth >= MAX_CALLS:
            return Unknown("calls that are nested too deep")
        node = function.node
        scope = Scope(outer=function.scope)
        self._bind(node.args, arguments, keywords, scope, function.scope)
        if not is_whole:
            scope.names |= dict.fromkeys(
                (n for n in scope.names if n not in keywords), Unknown("an argument")
            )
        if isinstance(node, ast.Lambda):
            return self._expressions.value(node.body, scope)
        outside, self._uncertain = self._uncertain, 0
        self._depth += 1
        self._returns.append([])
        result: Value = None
        try:
            self._run(node.body, scope)
        except _Return as ended:
            result = ended.value
        except _Leave:
            result = Unknown("an exception")
        finally:
            self._depth -= 1
            self._uncertain = outside
            perhaps = self._returns.pop()
        return choice(*perhaps, result) if perhaps else result

    def _bind(
        self,
        parameters: ast.arguments,
        arguments: tuple[Value, ...],
        keywords: Mapping[str, Value],
        scope: Scope,
        around: Scope,
    ) -> None:
        positional = [*parameters.posonlyargs, *parameters.args]
        optional = positional[len(positional) - len(parameters.defaults) :]
        pairs = [
            *zip(optional, parameters.defaults, strict=True),
            *zip(parameters.kwonlyargs, parameters.kw_defaults, strict=True),
        ]
        for parameter in (*positional, *parameters.kwonlyargs):
            scope.names[parameter.arg] = Unknown(f"'{parameter.arg}' is not given")
        for parameter, default in pairs:
            if default is not None:
                value = self._expressions.value(default, around)
                scope.names[parameter.arg] = value
        for parameter, value in zip(positional, arguments, strict=False):
            scope.names[parameter.arg] = value
        known = {parameter.arg for parameter in (*positional, *parameters.kwonlyargs)}
        scope.names |= {k: value for k, value in keywords.items() if k in known}
        if parameters.vararg is not None:
            scope.names[parameters.vararg.arg] = arguments[len(positional) :]
        if parameters.kwarg is not None:
            others = {k: value for k, value in keywords.items() if k not in known}
            scope.names[parameters.kwarg.arg] = others

    def _call_name(self, name: Name, call: Call) -> Value:
        if name.is_of_launch:
            return self._make(name, call)
        if name.dotted in PACKAGE_FOLDERS and call.arguments:
            folder = self._package_folder(call.arguments[0], call.location)
            is_path = name.dotted.endswith("path") and isinstance(folder, str)
            return Path(str(folder)) if is_path else folder
        if name.dotted in _XACRO and call.arguments:
            return Made(
                "xacro",
                call.location,
                {"file": call.arguments[0], "mappings": call.keywords.get("mappings")},
            )
        if name.dotted == "open" and call.arguments:
            return Made("open", call.location, {"path": call.arguments[0]})
        if name.dotted in ("os.path.join", "str"):
            for value in call.arguments:
                if isinstance(value, Made) and value.name in grammar.SUBSTITUTIONS:
                    self._misused(value, call.location)
        return call_function(name.dotted, call.arguments, call.keywords)

    def _make(self, name: Name, call: Call) -> Value:
        if name.last not in grammar.SIGNATURES:
            near = grammar.misspelt(name.last)
            if near is not None:
                self.findings.append(_no_class(name, near, call.location))
            return Unknown(f"{name.dotted} is not read")
        made, findings = grammar.make(
            name.last,
            call.arguments,
            call.keywords,
            call.location,
            call.places,
            is_whole=call.is_whole,
        )
        self.findings += findings
        return made

    def _call_method(self, owner: Value, name: str, call: Call) -> Value:
        if isinstance(owner, Made):
            return self._method_of_made(owner, name, call)
        if isinstance(owner, list | dict) and change(
            owner, name, call.arguments, self._is_certain
        ):
            return None
        return call_method(owner, name, call.arguments, call.keywords)

    def _method_of_made(self, owner: Made, name: str, call: Call) -> Value:
        first = call.arguments[0] if call.arguments else None
        match owner.name, name:
            case _, "perform":
                return self._perform(owner)
            case "LaunchContext", "perform_substitution":
                return self._perform(first)
            case "launch_configurations", "get":
                wanted = {"variable_name": first}
                return self._perform(
                    Made("LaunchConfiguration", owner.location, wanted)
                )
            case (("FindPackageShare" | "FindPackage"), "find"):
                return self._package_folder(first, call.location)
            case "xacro", ("toxml" | "toprettyxml"):
                return owner
            case "open", "read":
                return Made("content", owner.location, owner.arguments)
            case "LaunchDescription", ("add_action" | "add_entity"):
                entities = owner.get("initial_entities")
                if not isinstance(entities, list):
                    entities = [entities]
                owner.arguments = {**owner.arguments, "initial_entities": entities}
                change(entities, "append", call.arguments, self._is_certain)
                return None
        return Unknown(f"{owner.name}.{name}() is not read")

    # --- statements ---

    def _run(self, body: list[ast.stmt], scope: Scope) -> None:
        for statement in body:
            self._statement(statement, scope)

    def _statement(self, node: ast.stmt, scope: Scope) -> None:
        self._spend()
        value = self._expressions.value
        match node:
            case ast.Import() | ast.ImportFrom():
                self._import(node, scope)
            case ast.FunctionDef(name=name):
                scope.names[name] = Function(node, scope)
            case ast.ClassDef(name=name):
                scope.names[name] = Unknown(f"the class {name}")
            case ast.Assign(targets=targets):
                result = value(node.value, scope)
                for target in targets:
                    self._assign(target, result, scope)
            case ast.AnnAssign(target=target) if node.value is not None:
                self._assign(target, value(node.value, scope), scope)
            case ast.AugAssign(target=target, op=op):
                before, added = value(target, scope), value(node.value, scope)
                if isinstance(before, list) and isinstance(op, ast.Add):
                    change(before, "extend", (added,), self._is_certain)
                    return
                where = self._locate(node)
                result = self._expressions.combined(op, before, added, where)
                self._assign(target, result, scope)
            case ast.Expr():
                value(node.value, scope)
            case ast.Return():
                result = None if node.value is None else value(node.value, scope)
                self._return(node, result)
            case ast.If(test=test, body=body, orelse=other):
                is_true = truth(value(test, scope))
                if is_true is None:
                    self._branch((body, other), scope)
                else:
                    self._run(body if is_true else other, scope)
            case ast.For():
                self._loop(node, scope)
            case ast.While(body=body):
                self._branch((body, []), scope)
            case ast.With(items=items, body=body):
                for item in items:
                    if item.optional_vars is not None:
                        given = value(item.context_expr, scope)
                        self._assign(item.optional_vars, given, scope)
                self._run(body, scope)
            case ast.Try(body=body, orelse=other, finalbody=last):
                self._run([*body, *other, *last], scope)
            case ast.Raise() | ast.Break() | ast.Continue():
                raise _Leave(node)

    def _return(self, node: ast.Return, value: Value) -> None:
        if not self._uncertain:
            raise _Return(value)
        self._returns[-1].append(value)
        raise _Leave(node)

    def _branch(self, bodies: tuple[list[ast.stmt], ...], scope: Scope) -> None:
        """Process several branches of which Python would execute only one."""
        before = dict(scope.names)
        after = []
        for body in bodies:
            scope.names = dict(before)
            with self._perhaps_left():
                self._run(body, scope)
            after.append(scope.names)
        names = {name: None for found in after for name in found}
        missing = Unknown("set in one branch only")
        scope.names = {
            name: choice(*(found.get(name, missing) for found in after))
            for name in names
        }

    @contextmanager
    def _perhaps_left(self) -> Iterator[None]:
        self._uncertain += 1
        try:
            yield
        except _Leave:
            pass
        finally:
            self._uncertain -= 1

    def _loop(self, node: ast.For, scope: Scope) -> None:
        items = self._expressions.value(node.iter, scope)
        if isinstance(items, Unknown | Choice | Made):
            assign(node.target, Unknown("an item of something unknown"), scope)
            self._branch((node.body, []), scope)
            return
        for item in iterated(items):
            assign(node.target, item, scope)
            try:
                self._run(node.body, scope)
            except _Leave as left:
                if left.is_break:
                    break
                if not left.is_continue:
                    raise

    def _assign(self, target: ast.expr, value: Value, scope: Scope) -> None:
        match target:
            case ast.Subscript(value=whole, slice=index):
                owner = self._expressions.value(whole, scope)
                key = self._expressions.value(index, scope)
                if isinstance(owner, dict) and isinstance(key, str | int):
                    before = owner.get(key)
                    is_certain = not self._uncertain
                    owner[key] = value if is_certain else choice(before, value)
            case _:
                assign(target, value, scope)

    def _import(self, node: ast.Import | ast.ImportFrom, scope: Scope) -> None:
        for alias in node.names:
            if isinstance(node, ast.ImportFrom):
                name = Name(f"{node.module or ''}.{alias.name}")
                scope.names[alias.asname or alias.name] = name
                near = grammar.misspelt(name.last) if name.is_of_launch else None
                if near is not None and near != name.last:
                    where = self._locate(node)
                    self.findings.append(_no_class(name, near, where))
            elif alias.asname is not None:
                scope.names[alias.asname] = Name(alias.name)
            else:
                top = alias.name.partition(".")[0]
                scope.names[top] = Name(top)

    # --- parts ---

    @property
    def _is_certain(self) -> bool:
        """Return whether the current statement is certainly executed."""
        return not self._uncertain

    def _look_up(self, name: str, scope: Scope) -> Value:
        found = scope.find(name)
        if found is not None:
            return found.names[name]
        if name in FUNCTIONS or name == "open":
            return Name(name)
        return Unknown(f"'{name}' is unknown")

    def _locate(self, node: ast.AST) -> SourceLocation:
        return SourceLocation(self._file, getattr(node, "lineno", None))

    def _spend(self) -> None:
        self._left -= 1
        if self._left < 0:
            raise TooLongError

    def _misused(self, value: Made, where: SourceLocation) -> None:
        self.findings.append(
            error_at(
                where,
                "bad-substitution",
                value.name,
                "has no value yet where the text is made: its value is known only when "
                "the launch file runs",
                "write a list of texts and substitutions, or PathJoinSubstitution",
            )
        )


def _no_class(name: Name, near: str, where: SourceLocation) -> Finding:
    module = name.dotted.rpartition(".")[0]
    return error_at(
        where,
        "unknown-element",
        name.last,
        f"is no part of {module}, and launch stops here",
        f"did you mean '{near}'?",
    )
