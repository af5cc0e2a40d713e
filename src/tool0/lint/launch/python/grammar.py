"""The classes of the packages launch and launch_ros, and the classes' arguments.

The source is the code of launch and launch_ros, https://github.com/ros2/launch and
https://github.com/ros2/launch_ros, in the branches from humble to rolling.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

from tool0.description.finding import Finding, error_at
from tool0.errors import SourceLocation, did_you_mean, is_typo, nearest_name
from tool0.lint.launch.python.values import Made, Value

_ACTION: Final = "condition"
_LOCAL: Final = (
    f"{_ACTION} shell sigterm_timeout sigkill_timeout emulate_tty output output_format"
    " cached_output log_cmd on_exit respawn respawn_delay respawn_max_retries"
    " additional_env cwd env name prefix"
)
_NODE: Final = (
    f"{_LOCAL} package namespace exec_name parameters remappings ros_arguments"
    " arguments"
)
_HANDLER: Final = "handle_once"

_CLASSES: Final = {
    # Actions, with positional arguments before the bar and keywords after it.  An
    # exclamation mark marks a required argument.
    "AppendEnvironmentVariable": f"name! value! prepend separator | {_ACTION}",
    "DeclareLaunchArgument": f"name! | default_value description choices {_ACTION}",
    "EmitEvent": f"| event! {_ACTION}",
    "ExecuteLocal": f"| process_description! {_LOCAL}",
    "ExecuteProcess": f"| cmd! {_LOCAL}",
    "GroupAction": f"actions! | scoped forwarding launch_configurations {_ACTION}",
    "IncludeLaunchDescription": (
        f"launch_description_source! | launch_arguments {_ACTION}"
    ),
    "LogInfo": f"| msg! {_ACTION}",
    "OpaqueCoroutine": f"| coroutine! args kwargs ignore_context {_ACTION}",
    "OpaqueFunction": f"| function! args kwargs {_ACTION}",
    "PopEnvironment": f"| {_ACTION}",
    "PopLaunchConfigurations": f"| {_ACTION}",
    "PushEnvironment": f"| {_ACTION}",
    "PushLaunchConfigurations": f"| {_ACTION}",
    "RegisterEventHandler": f"event_handler! | {_ACTION}",
    "ResetEnvironment": f"| {_ACTION}",
    "ResetLaunchConfigurations": f"launch_configurations | {_ACTION}",
    "SetEnvironmentVariable": f"name! value! | {_ACTION}",
    "SetLaunchConfiguration": f"name! value! | {_ACTION}",
    "Shutdown": f"| reason {_ACTION}",
    "TimerAction": f"| period! actions! cancel_on_shutdown {_ACTION}",
    "UnregisterEventHandler": f"event_handler! | {_ACTION}",
    "UnsetEnvironmentVariable": f"name! | {_ACTION}",
    "UnsetLaunchConfiguration": f"name! | {_ACTION}",
    "LaunchDescription": "initial_entities | deprecated_reason",
    # actions of launch_ros
    "Node": f"| executable! {_NODE}",
    "LifecycleNode": f"| executable! name! namespace! autostart {_NODE}",
    "ComposableNodeContainer": (
        f"| executable name! namespace! composable_node_descriptions {_NODE}"
    ),
    "ComposableLifecycleNode": (
        "| package! plugin! name namespace parameters remappings extra_arguments"
        f" autostart {_ACTION}"
    ),
    "LifecycleTransition": f"| lifecycle_node_names! transition_ids! {_ACTION}",
    "LoadComposableNodes": (
        f"| composable_node_descriptions! target_container! {_ACTION}"
    ),
    "PushRosNamespace": f"namespace! | {_ACTION}",
    "PushROSNamespace": f"namespace! | {_ACTION}",
    "ROSTimer": f"| period! actions! cancel_on_shutdown {_ACTION}",
    "RosTimer": f"| period! actions! cancel_on_shutdown {_ACTION}",
    "SetParameter": f"name! value! | {_ACTION}",
    "SetParametersFromFile": f"filename! | node_name {_ACTION}",
    "SetRemap": f"src! dst! | {_ACTION}",
    "SetROSLogDir": f"new_log_dir! | {_ACTION}",
    "SetUseSimTime": f"value! | {_ACTION}",
    "ComposableNode": (
        "| package! plugin! name namespace parameters remappings extra_arguments"
        " condition"
    ),
    # conditions
    "IfCondition": "predicate_expression! |",
    "UnlessCondition": "predicate_expression! |",
    "LaunchConfigurationEquals": "launch_configuration_name! expected_value! |",
    "LaunchConfigurationNotEquals": "launch_configuration_name! expected_value! |",
    # event handlers
    "OnExecutionComplete": f"| target_action on_completion! {_HANDLER}",
    "OnProcessExit": f"| target_action on_exit! {_HANDLER}",
    "OnProcessIO": f"| target_action on_stdin on_stdout on_stderr {_HANDLER}",
    "OnProcessStart": f"| target_action on_start! {_HANDLER}",
    "OnShutdown": f"| on_shutdown! {_HANDLER}",
    "OnStateTransition": (
        "| entities! target_lifecycle_node transition start_state goal_state matcher"
        f" {_HANDLER}"
    ),
    # sources of included files
    "AnyLaunchDescriptionSource": "launch_file_path! |",
    "FrontendLaunchDescriptionSource": "launch_file_path! | method parser",
    "PythonLaunchDescriptionSource": "launch_file_path! |",
    "XMLLaunchDescriptionSource": "launch_file_path! |",
    "YAMLLaunchDescriptionSource": "launch_file_path! |",
    # parameters
    "Parameter": "name! value default | value_type",
    "ParameterFile": "param_file! | allow_substs",
    "ParameterValue": "value! | value_type",
}
_SUBSTITUTIONS: Final = {
    "AllSubstitution": "*args |",
    "AndSubstitution": "left! right! |",
    "AnonName": "name! |",
    "AnySubstitution": "*args |",
    "BooleanSubstitution": "value! |",
    "Command": "command! | on_stderr",
    "EnvironmentVariable": "name! | default_value",
    "EqualsSubstitution": "left! right! |",
    "ExecutableInPackage": "executable! package! |",
    "FileContent": "path! |",
    "FindExecutable": "| name!",
    "FindPackage": "package! |",
    "FindPackagePrefix": "package! |",
    "FindPackageShare": "package! |",
    "IfElseSubstitution": "condition! if_value else_value |",
    "LaunchConfiguration": "variable_name! | default",
    "LaunchLogDir": "|",
    "LocalSubstitution": "expression! description |",
    "NotEqualsSubstitution": "left! right! |",
    "NotSubstitution": "value! |",
    "OrSubstitution": "left! right! |",
    "PathJoinSubstitution": "substitutions! |",
    "PathSubstitution": "path! |",
    "PythonExpression": "expression! python_modules |",
    "StringJoinSubstitution": "substitutions! delimiter |",
    "TextSubstitution": "| text!",
    "ThisLaunchFile": "|",
    "ThisLaunchFileDir": "|",
}
SUBSTITUTIONS: Final = frozenset(_SUBSTITUTIONS)


@final
@dataclass(frozen=True, slots=True)
class Signature:
    """Arguments of a class."""

    positional: tuple[str, ...]
    names: frozenset[str]
    required: tuple[str, ...]
    takes_any: str = ""
    """Name under which any number of positional arguments is stored; empty if the class
    has a fixed number of arguments."""


def _signature(text: str) -> Signature:
    before, _, after = text.partition("|")
    every = [*before.split(), *after.split()]
    many = next((word[1:] for word in every if word.startswith("*")), "")
    return Signature(
        positional=tuple(w.rstrip("!") for w in before.split() if w[0] != "*"),
        names=frozenset(word.strip("!*") for word in every),
        required=tuple(word[:-1] for word in every if word.endswith("!")),
        takes_any=many,
    )


SIGNATURES: Final[Mapping[str, Signature]] = {
    name: _signature(text) for name, text in {**_CLASSES, **_SUBSTITUTIONS}.items()
}


def make(
    name: str,
    arguments: Sequence[Value],
    keywords: Mapping[str, Value],
    location: SourceLocation,
    places: Mapping[str, SourceLocation],
    *,
    is_whole: bool = True,
) -> tuple[Made, list[Finding]]:
    """Return the object that a call creates, and the faults of the call.

    Args:
        name: Name of the class, which is a key of ``SIGNATURES``.
        arguments: The positional arguments.
        keywords: The keyword arguments.
        location: Location of the call.
        places: Locations of the keywords.
        is_whole: Whether all arguments are known.
    """
    signature = SIGNATURES[name]
    given = dict(zip(signature.positional, arguments, strict=False))
    if signature.takes_any:
        given[signature.takes_any] = list(arguments)
    findings = []
    for key in keywords:
        if key not in signature.names:
            findings.append(
                error_at(
                    places.get(key, location),
                    "unknown-attribute",
                    key,
                    f"is no argument of {name}, and launch stops here"
                    + did_you_mean(key, signature.names),
                    f"remove {key}, or write the argument that was meant",
                )
            )
        elif key in given:
            findings.append(
                error_at(
                    places.get(key, location),
                    "duplicate-argument",
                    key,
                    f"is given to {name} twice, also by position: launch stops here",
                    "remove one of them",
                )
            )
    given |= keywords
    missing = [key for key in signature.required if key not in given]
    for key in missing if is_whole else ():
        findings.append(
            error_at(
                location,
                "missing-attribute",
                key,
                f"is missing from {name}, and launch stops without it",
                f"write {key}=…",
            )
        )
    extra = len(arguments) - len(signature.positional)
    if extra > 0 and not signature.takes_any:
        takes = f"{len(signature.positional) or 'no'} arguments by position"
        findings.append(
            error_at(
                location,
                "bad-value",
                name,
                f"takes {takes}, not {len(arguments)}: launch stops here",
                "write the others as NAME=VALUE",
            )
        )
    return Made(name, location, given, places), findings


def misspelt(name: str) -> str | None:
    """Return the class whose name is misspelled as ``name``; None if there is none."""
    near = nearest_name(name, SIGNATURES)
    return near if near is not None and is_typo(name, near) else None
