"""Reads conditions of actions, and settings that actions make for later actions."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from tool0.errors import SourceLocation
from tool0.lint.launch import grammar as roslaunch
from tool0.lint.launch.model import Condition, Statement, Text
from tool0.lint.launch.python.substitution import Resolver, as_boolean
from tool0.lint.launch.python.values import Made, Value


def read_condition(
    value: Value, where: SourceLocation, resolver: Resolver
) -> Condition | None:
    """Return the condition of the action at ``where``."""
    if value is None:
        return None
    if not isinstance(value, Made):
        text = Text(raw="?", resolved=None, location=where, reason="unknown")
        return Condition(kind="if", text=text, holds=None)
    is_unless = value.name == "UnlessCondition"
    kind: Literal["if", "unless"] = "unless" if is_unless else "if"
    if value.name.startswith("LaunchConfiguration"):
        name = {"variable_name": value.get("launch_configuration_name")}
        one = resolver.text(Made("LaunchConfiguration", where, name), where)
        two = resolver.text(value.get("expected_value"), where)
        is_known = one.resolved is not None and two.resolved is not None
        is_wanted = value.name == "LaunchConfigurationEquals"
        is_equal = one.resolved == two.resolved
        holds = (is_equal is is_wanted) if is_known else None
        return Condition(kind="if", text=one, holds=holds)
    text = resolver.text(value.get("predicate_expression"), where)
    text = replace(text, location=where)
    word = None if text.resolved is None else as_boolean(text.resolved)
    if word is None and text.resolved is not None:
        resolver.report(
            where,
            "bad-if",
            value.name,
            f"must be true, false, 1 or 0, and is '{text.resolved}': launch stops here",
            "write PythonExpression or EqualsSubstitution in it, or give the "
            "argument such a value",
        )
    holds = None if word is None else word is (kind == "if")
    return Condition(kind=kind, text=text, holds=holds)


def set_configuration(made: Made, resolver: Resolver) -> None:
    """Process ``SetLaunchConfiguration`` or ``UnsetLaunchConfiguration``."""
    key = resolver.text(made.get("name"), made.location).resolved
    if resolver.state.holds is False:
        return
    if key is None:
        resolver.state.unread.append("a configuration whose name is unknown")
    elif made.name.startswith("Unset"):
        resolver.state.configurations.pop(key, None)
    else:
        text = resolver.text(made.get("value"), made.place("value"))
        resolver.state.configurations[key] = resolver.state.if_active(text)


def push_namespace(made: Made, resolver: Resolver) -> None:
    """Process ``PushROSNamespace``."""
    text = resolver.text(made.get("namespace"), made.location)
    if resolver.state.namespace is None or text.resolved is None:
        resolver.state.namespace = None
    else:
        joined = roslaunch.join(resolver.state.namespace, text.resolved)
        resolver.state.namespace = roslaunch.as_namespace(joined)


def set_statement(made: Made, resolver: Resolver) -> Statement:
    """Process ``SetRemap`` or ``SetEnvironmentVariable``, and return the statement."""
    is_remap = made.name == "SetRemap"
    keys = (("src", "from"), ("dst", "to"))
    keys = keys if is_remap else (("name", "name"), ("value", "value"))
    statement = Statement(
        kind="remap" if is_remap else "env",
        place=resolver.state.place(made.location),
        texts=tuple(
            (shown, resolver.text(made.get(key), made.location)) for key, shown in keys
        ),
    )
    if is_remap:
        resolver.state.remaps = (*resolver.state.remaps, statement)
    else:
        resolver.state.environment = (*resolver.state.environment, statement)
    return statement


def set_parameter(made: Made, resolver: Resolver) -> None:
    """Process ``SetParameter`` or ``SetUseSimTime``, which apply to all later nodes."""
    key: str | None = "use_sim_time"
    if made.name == "SetParameter":
        key = resolver.text(made.get("name"), made.location).resolved
    if key is not None and resolver.state.holds is not False:
        resolver.state.parameters[key] = made.get("value")


def read_process(made: Made, resolver: Resolver) -> Statement:
    """Return an ``ExecuteProcess`` action as a statement."""
    where = made.place("cmd")
    command = made.get("cmd")
    words = command if isinstance(command, list | tuple) else [command]
    spaced = [part for word in words for part in (" ", word)][1:]
    name = resolver.text(made.get("name") or list(words)[:1], made.location)
    texts = (("name", name), ("cmd", resolver.text(spaced, where)))
    place = resolver.state.place(made.location)
    return Statement(kind="process", place=place, texts=texts)
