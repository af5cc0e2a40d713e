"""Python launch files of ROS 2: what is read of them, and what is reported."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from tool0.lint.launch.model import Include, LaunchFile, Statement
from tool0.lint.launch.reader import read_launch
from tool0.lint.packages import PackageIndex

IMPORTS = """
from launch import LaunchDescription
from launch.actions import *
from launch.actions import (
    DeclareLaunchArgument, ExecuteProcess, GroupAction, IncludeLaunchDescription,
    OpaqueFunction, RegisterEventHandler, SetLaunchConfiguration, TimerAction)
from launch.conditions import IfCondition, UnlessCondition
from launch.event_handlers import OnProcessExit
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import (
    Command, FindExecutable, IfElseSubstitution, LaunchConfiguration,
    NotSubstitution, PathJoinSubstitution, PythonExpression)
from launch_ros.actions import Node, PushROSNamespace, SetParameter
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare
import launch_ros
import os
from ament_index_python.packages import get_package_share_directory
"""
SETUP = "def generate_launch_description():\n"

Reader = Callable[..., LaunchFile]


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package ``mine`` with a robot, parameters and a program."""
    for name, text in {
        "package.xml": "<package><name>mine</name></package>",
        "CMakeLists.txt": "project(mine)\nadd_executable(driver src/driver.cpp)",
        "config/c.yaml": "n:\n  ros__parameters:\n    joint: $(var prefix)elbow\n",
        "urdf/r.urdf.xacro": "<robot name='r'/>",
        "launch/empty.launch.py": f"{IMPORTS}{SETUP}    return LaunchDescription([])",
    }.items():
        file = tmp_path / "mine" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    return tmp_path / "mine"


@pytest.fixture
def read(package: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    """Return a function that reads a launch file with the actions given to it."""
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)

    def read(actions: str, before: str = "", **arguments: str) -> LaunchFile:
        body = textwrap.indent(f"{before}\nreturn LaunchDescription([{actions}])", "  ")
        file = package / "launch" / "main.launch.py"
        file.write_text(f"{IMPORTS}{SETUP}{body}\n", encoding="utf-8")
        return read_launch(file, arguments, PackageIndex({"mine": package}))

    return read


def rules(launch: LaunchFile) -> list[str]:
    return [finding.rule for finding in launch.findings]


def words(launch: LaunchFile) -> list[tuple[str, ...]]:
    return [node.words for node in launch.nodes()]


def declared(name: str, default: str) -> str:
    return f'DeclareLaunchArgument("{name}", default_value="{default}")'


def node(**keywords: str) -> str:
    given = ", ".join(f"{key}={value}" for key, value in keywords.items())
    return f'Node(package="mine", executable="driver", {given})'


def test_substitutions_have_the_values_of_the_arguments(read: Reader) -> None:
    launch = read(
        f"""{declared("side", "left")}, {declared("is_fast", "true")},
        {
            node(
                name='[LaunchConfiguration("side"), "_arm"]',
                namespace='"robots"',
                arguments='''["-d",
                    PathJoinSubstitution([FindPackageShare("mine"), "x"]),
                    PythonExpression(["2 if '", LaunchConfiguration("side"),
                                      "' == 'left' else 3"]),
                    IfElseSubstitution(NotSubstitution(LaunchConfiguration("is_fast")),
                                       "slow", "fast"),
                    os.path.join(get_package_share_directory("mine"), "y"),
                    FindExecutable(name="xacro")]''',
            )
        }""",
        side="right",
    )
    (found,) = launch.nodes()
    mine = launch.file.parents[1]
    assert rules(launch) == []
    assert found.full_name == "/robots/right_arm"
    assert found.words == ("-d", f"{mine}/x", "3", "fast", f"{mine}/y", "xacro")
    assert found.args is not None
    assert found.args.uses == ("side", "is_fast")


def test_python_around_the_actions_is_followed(read: Reader) -> None:
    launch = read(
        "*nodes, *[n for n in extra if n is not None]",
        """
nodes, names = [], {"a": 1, "b": 2}
def make(name, *, count=0):
    if count > 1:
        return Node(package="mine", executable="driver", arguments=[f"{name}{count}"])
    return Node(package="mine", executable="driver", arguments=[name.upper()])
for key, count in names.items():
    nodes.append(make(key, count=count))
extra = [make("c")] + [None]
""",
    )
    assert words(launch) == [("A",), ("b2",), ("C",)]
    assert launch.notes == ()


def test_a_branch_that_depends_on_the_machine_is_uncertain(read: Reader) -> None:
    launch = read(
        f"{node()}, *more",
        f"""
more = []
if os.environ.get("X") == "1":
    more.append({node(arguments='["perhaps"]')})
else:
    name = "one"
""",
    )
    first, second = launch.nodes()
    assert (first.place.holds, second.place.holds) == (True, None)


def test_what_an_opaque_function_returns_is_read(read: Reader) -> None:
    launch = read(
        f"{declared('which', 'b')}, OpaqueFunction(function=setup)",
        f"""
def setup(context, *args, **kwargs):
    which = LaunchConfiguration("which").perform(context)
    names = ["a", context.launch_configurations["which"]]
    if which == "b":
        return [{node(arguments="names")}]
    return [{node(arguments='["no"]')}]
""",
    )
    assert words(launch) == [("a", "b")]
    assert rules(launch) == []


def test_what_cannot_be_known_is_a_note(read: Reader) -> None:
    launch = read(
        "OpaqueFunction(function=elsewhere), *load_everything()",
        "from somewhere import elsewhere, load_everything",
    )
    assert rules(launch) == []
    assert len(launch.notes) == 2
    assert all("not analysed" in note for note in launch.notes)


def test_conditions_switch_nodes(read: Reader) -> None:
    gui = 'LaunchConfiguration("gui")'
    launch = read(
        f"""{declared("gui", "false")},
        {node(arguments='["a"]', condition=f"IfCondition({gui})")},
        {node(arguments='["b"]', condition=f"UnlessCondition({gui})")}"""
    )
    assert words(launch) == [("b",)]
    wrong = read(
        f"{declared('gui', 'perhaps')}, {node(condition=f'IfCondition({gui})')}"
    )
    assert rules(wrong) == ["bad-if"]


def test_a_process_that_is_no_node_is_an_entry(read: Reader) -> None:
    launch = read(
        f"""{declared("who", "you")},
        ExecuteProcess(cmd=["echo", ["hello ", LaunchConfiguration("who")]])"""
    )
    (process,) = launch.walk()
    assert isinstance(process, Statement)
    assert [text.resolved for _, text in process.texts] == ["echo", "echo hello you"]


def test_an_action_that_is_switched_off_sets_nothing(read: Reader) -> None:
    never = 'condition=IfCondition("false")'
    launch = read(
        f"""{declared("x", "1")}, SetLaunchConfiguration("x", "2", {never}),
        SetParameter("a", 1, {never}), PushROSNamespace("n", {never}),
        {node(name='"b"', arguments='[LaunchConfiguration("x")]')}"""
    )
    (found,) = launch.nodes()
    assert (found.full_name, found.words, found.parameters) == ("/b", ("1",), ())


def test_events_and_timers_come_after_all_else(read: Reader) -> None:
    late = node(arguments='[LaunchConfiguration("late")]')
    launch = read(
        f"""RegisterEventHandler(OnProcessExit(on_exit=[{late}])),
        TimerAction(period=1.0, actions=[{node(arguments='["timer"]')}]),
        {declared("late", "x")}, {node(arguments='["now"]')}"""
    )
    assert words(launch) == [("now",), ("x",), ("timer",)]
    assert rules(launch) == []


def test_groups_have_a_scope(read: Reader) -> None:
    launch = read(
        f"""GroupAction([PushROSNamespace("left"), SetParameter("use_sim_time", True),
            SetLaunchConfiguration("x", "1"),
            {node(name='"a"', arguments='[LaunchConfiguration("x")]')}]),
        {node(name='"a"', arguments='[LaunchConfiguration("x", default="2")]')}"""
    )
    first, second = launch.nodes()
    assert (first.full_name, second.full_name) == ("/left/a", "/a")
    assert words(launch) == [("1",), ("2",)]
    assert [p.name.resolved for p in first.parameters] == ["use_sim_time"]
    assert second.parameters == ()


def test_parameters_and_their_files_are_read(read: Reader) -> None:
    launch = read(
        f"""{declared("prefix", "left_")}, {
            node(
                name='"n"',
                parameters='''[
            {"a": {"b": 1}, "urdf": ParameterValue(Command(
                ["xacro ", path, " side:=", LaunchConfiguration("prefix")]))},
            ParameterFile(share / "config/c.yaml", allow_substs=True)]''',
            )
        }""",
        """
from pathlib import Path
share = Path(get_package_share_directory("mine"))
path = str(share / "urdf" / "r.urdf.xacro")
""",
    )
    a, urdf = launch.parameters()
    assert (a.full_name, a.content.resolved) == ("/n/a.b", "1")
    assert (urdf.source, urdf.words[0], urdf.words[2]) == (
        "command",
        "xacro",
        "side:=left_",
    )
    (file,) = launch.rosparams()
    assert file.yaml is not None
    assert "joint: left_elbow" in (file.yaml.resolved or "")


def test_an_include_gets_its_arguments(read: Reader, package: Path) -> None:
    (package / "launch" / "part.launch.py").write_text(
        f"""{IMPORTS}{SETUP}
    return LaunchDescription([
        DeclareLaunchArgument("kind", choices=["a", "b"]),
        {declared("color", "red")},
        {node(arguments='[LaunchConfiguration("kind"), LaunchConfiguration("color")]')}
    ])""",
        encoding="utf-8",
    )

    def include(given: str) -> LaunchFile:
        return read(
            "IncludeLaunchDescription(PythonLaunchDescriptionSource([FindPackageShare("
            f'"mine"), "/launch/part.launch.py"]), launch_arguments={given})'
        )

    launch = include('{"kind": "b"}.items()')
    assert words(launch) == [("b", "red")]
    assert rules(launch) == []
    assert rules(include("[]")) == ["missing-argument"]
    assert rules(include('{"kind": "c"}.items()')) == ["bad-value"]
    (finding,) = include('{"kind": "a", "colour": "x"}.items()').findings
    assert (finding.rule, finding.severity) == ("unused-argument", "error")
    assert "did you mean 'color'?" in finding.message
    assert rules(include('{"kind": "a"}')) == ["bad-value"]  # a dict, not its items


def test_a_file_that_includes_itself_ends(read: Reader) -> None:
    launch = read(
        "IncludeLaunchDescription(PythonLaunchDescriptionSource(__file__))",
    )
    assert "recursive-include" in rules(launch)


@pytest.mark.parametrize(
    ("actions", "rule", "hint"),
    [
        (node(argments="[]"), "unknown-attribute", "did you mean 'arguments'?"),
        ('Node(package="mine")', "missing-attribute", "executable=…"),
        (node(arguments='"-d"'), "bad-value", "must be a list"),
        (node(arguments="[1]"), "bad-value", "write '1'"),
        (node(parameters='{"a": 1}'), "bad-value", "must be a list"),
        (node(remappings='["a", "b"]'), "bad-value", "pairs"),
        (node(output='"scren"'), "bad-value", "screen"),
        (node(name='"a/b"'), "bad-name", "namespace="),
        (node(arguments='[LaunchConfiguration("x")]'), "missing-argument", '"x"'),
        ('Node(package="mine", executable="drivr")', "missing-executable", "driver"),
        ('Node(package="mines", executable="driver")', "missing-package", "mine"),
        (node(parameters='["/no/such.yaml"]'), None, ""),
        (
            node(
                parameters='[PathJoinSubstitution([FindPackageShare("mine"), "config",'
                ' "d.yaml"])]'
            ),
            "missing-file",
            "c.yaml",
        ),
        (node(arguments='[FindPackageShare("mines")]'), "unresolved-find", "mine"),
        (
            node(arguments="[f\"{LaunchConfiguration('x')}/a\"]"),
            "bad-substitution",
            "PathJoinSubstitution",
        ),
        (
            'DeclareLaunchArgument("x", default_value=True), '
            + node(arguments='[LaunchConfiguration("x")]'),
            "bad-value",
            "write 'true'",
        ),
        (declared("x", "1"), "unused-argument", "remove it"),
        (
            f"{declared('x', '1')}, {declared('x', '2')}, "
            + node(arguments='[LaunchConfiguration("x")]'),
            "duplicate-argument",
            "remove one",
        ),
        (
            f"{node(name=repr('n'))}, {node(name=repr('n'))}",
            "duplicate-node",
            "another name",
        ),
        (
            'IncludeLaunchDescription(PythonLaunchDescriptionSource("/no.launch.py"))',
            "missing-file",
            "correct the path",
        ),
        (
            node(arguments='[PythonExpression(["1 +"])]'),
            "bad-eval",
            "quotation marks",
        ),
    ],
)
def test_a_mistake_is_reported(
    read: Reader, actions: str, rule: str | None, hint: str
) -> None:
    launch = read(actions)
    found = [f for f in launch.findings if f.rule == rule]
    assert rules(launch) == ([] if rule is None else [rule])
    assert all(hint in finding.text for finding in found)


def test_a_configuration_is_known_from_its_declaration_on(read: Reader) -> None:
    use = node(arguments='[LaunchConfiguration("x")]')
    assert rules(read(f"{use}, {declared('x', '1')}")) == ["missing-argument"]
    assert rules(read(f"{declared('x', '1')}, {use}")) == []


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("def generate_launch_description(:", "not-python"),
        ("x = 1", "not-launch"),
        ("\0", "not-python"),
        (
            f"from launch.actions import DeclareLaunchArgumnt\n{SETUP}  pass",
            "unknown-element",
        ),
    ],
)
def test_a_file_that_python_refuses_is_reported(
    package: Path, text: str, rule: str
) -> None:
    file = package / "launch" / "main.launch.py"
    file.write_text(text, encoding="utf-8")
    assert rules(read_launch(file, {}, PackageIndex({}))) == [rule]


def test_nothing_of_the_file_is_executed(package: Path) -> None:
    mark = package / "mark"
    file = package / "launch" / "main.launch.py"
    file.write_text(
        f"""{IMPORTS}
open({str(mark)!r}, "w").write("x")
os.system("touch {mark}")
__import__("os").mkdir({str(mark)!r})
{SETUP}    return LaunchDescription([ExecuteProcess(cmd=["touch", {str(mark)!r}])])
""",
        encoding="utf-8",
    )
    before = dict(os.environ)
    assert rules(read_launch(file, {}, PackageIndex({}))) == []
    assert not mark.exists()
    assert dict(os.environ) == before


@pytest.mark.parametrize(
    "body",
    [
        "while True: x = 1",
        "x = [0]\n  for i in x: x.append(i)",
        "x = 'a'\n  for i in range(100): x = x + x",
        "x = [1]\n  for i in range(100): x = x + x",
        "def f(): return f()\n  return f()",
        "x = " + "(" * 150 + ")" * 150,
        "x = 9 ** 9 ** 9",
        "x = 'a' * 10 ** 9",
        "return [[i, j] for i in range(9999) for j in range(9999)]",
    ],
)
def test_reading_ends_soon(package: Path, body: str) -> None:
    file = package / "launch" / "main.launch.py"
    file.write_text(f"{SETUP}  {body}\n", encoding="utf-8")
    launch = read_launch(file, {}, PackageIndex({}))
    assert set(rules(launch)) <= {"too-large"}


def test_included_files_of_other_kinds_are_named(read: Reader, package: Path) -> None:
    (package / "launch" / "x.launch.xml").write_text("<launch/>", encoding="utf-8")
    launch = read(
        "IncludeLaunchDescription(PathJoinSubstitution([FindPackageShare("
        '"mine"), "launch", "x.launch.xml"]))'
    )
    (include,) = launch.walk()
    assert isinstance(include, Include)
    assert "XML or YAML" in include.reason
    assert rules(launch) == []
