"""Launch files in a folder of their own, and what is read of them."""

from __future__ import annotations

import pickle
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tool0.description.packages import packages_around
from tool0.errors import SourceLocation
from tool0.lint.launch.load_context import MAX_BYTES
from tool0.lint.launch.model import Argument, Include, LaunchFile, Node
from tool0.lint.launch.reader import read_launch
from tool0.lint.launch_file import commented_rosparams
from tool0.lint.packages import PackageIndex

DATA = Path(__file__).parents[3] / "data" / "launch" / "src"
BRING_UP = DATA / "arm_gazebo" / "launch" / "arm_bringup.launch"
NODE = '<node pkg="p" type="t" name="{}"/>'

Reader = Callable[..., LaunchFile]


@pytest.fixture
def read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    """Return a function that reads a launch file of the elements given to it."""
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)

    def read(content: str, included: str = "", **arguments: str) -> LaunchFile:
        (tmp_path / "included.launch").write_text(f"<launch>{included}</launch>")
        file = tmp_path / "main.launch"
        file.write_text(f"<launch>\n{content}\n</launch>", encoding="utf-8")
        return read_launch(file, arguments)

    return read


def rules(launch: LaunchFile) -> list[str]:
    return [finding.rule for finding in launch.findings]


def argument(launch: LaunchFile, name: str) -> Argument:
    found = launch.argument(name)
    assert found is not None
    return found


def bring_up(**arguments: str) -> LaunchFile:
    packages = PackageIndex(packages_around(BRING_UP))
    return read_launch(BRING_UP, arguments, packages)


def test_a_bring_up_is_read_with_all_that_it_includes() -> None:
    launch = bring_up()
    assert launch.findings == ()
    assert [file.file.name for file in launch.files()] == [
        "arm_bringup.launch",
        "load_arm2.launch.xml",
        "load_arm.launch.xml",
        "control.launch.xml",
    ]
    nodes = [node.full_name for node in launch.nodes()]
    assert nodes == [
        "/robot_state_publisher",
        "/sim/server",
        "/spawn_model",
        "/spawner",
    ]
    (controllers, inline) = launch.rosparams()
    assert controllers.path == DATA / "arm_gazebo" / "config" / "controllers.yaml"
    assert controllers.namespace == "/"
    assert inline.yaml is not None
    assert inline.yaml.location.line == 10


def test_a_word_of_the_robot_s_command_is_what_xacro_gets() -> None:
    names = {parameter.full_name: parameter for parameter in bring_up().parameters()}
    words = names["/robot_description"].words
    assert words[1] == str(DATA / "arm_gazebo" / "urdf" / "arm.xacro")
    assert "model:=arm2" in words
    limits = DATA / "arm_description" / "config" / "limits.yaml"
    assert f"limits:={limits}" in words


def test_what_is_switched_off_is_kept() -> None:
    launch = bring_up()
    everything = launch.walk(active_only=False)
    every = [entry.name.resolved for entry in everything if isinstance(entry, Node)]
    active = [node.name.resolved for node in launch.nodes()]
    assert set(every) - set(active) == {"recorder"}


def test_where_values_come_from(read: Reader) -> None:
    launch = read(
        """<arg name="given" default="1"/>
        <arg name="offered" default="2"/>
        <arg name="fixed" value="$(arg given)$(arg offered)"/>
        <arg name="required"/>
        <include file="$(dirname)/included.launch" pass_all_args="true">
          <arg name="here" value="3"/>
        </include>""",
        '<arg name="given"/><arg name="here"/><arg name="own" default="4"/>',
        given="9",
    )
    found = {a.name: (a.origin, a.value and a.value.resolved) for a in launch.arguments}
    assert found == {
        "given": ("command line", "9"),
        "offered": ("default", "2"),
        "fixed": ("value", "92"),
        "required": ("missing", None),
    }
    (include,) = (entry for entry in launch.entries if isinstance(entry, Include))
    assert include.launch is not None
    inside = include.launch.arguments
    assert [(a.name, a.origin, a.value and a.value.location.line) for a in inside] == [
        ("given", "pass_all_args", 6),
        ("here", "include", 7),
        ("own", "default", 1),
    ]
    fixed = argument(launch, "fixed").value
    assert fixed is not None
    assert fixed.uses == ("given", "offered")


def test_a_required_argument_is_no_fault_and_reading_goes_on(read: Reader) -> None:
    launch = read(
        '<arg name="a"/>\n<param name="p" value="$(arg a)"/>\n<param name="q" '
        'value="$(eval a + 1)"/>\n<group if="$(arg a)">' + NODE.format("n") + "</group>"
    )
    assert launch.findings == ()
    p, q = launch.parameters()
    assert p.content.resolved is None
    assert p.content.reason == q.content.reason == "argument 'a' has no value"
    (node,) = launch.nodes()
    assert node.place.holds is None


def test_alternatives_that_depend_on_an_unknown_do_not_collide(read: Reader) -> None:
    launch = read(
        '<arg name="a"/>'
        '<arg name="b" value="1" if="$(arg a)"/>'
        '<arg name="b" value="2" unless="$(arg a)"/>'
        f'<group if="$(arg a)">{NODE.format("n")}</group>'
        f'<group unless="$(arg a)">{NODE.format("n")}</group>'
        '<param name="b" value="$(arg b)"/>'
    )
    assert rules(launch) == []


FAULTS = {
    "unknown-element": '<nod pkg="p" type="t" name="n"/>',
    "unknown-attribute": '<node pkg="p" type="t" name="n" arg="-x"/>',
    "missing-attribute": '<node pkg="p" name="n"/>',
    "missing-file": '<rosparam file="$(dirname)/absent.yaml"/>',
    "missing-package": '<node pkg="tool0_gazzebo" type="t" name="n"/>',
    "missing-argument": '<param name="p" value="$(arg nothing)"/>',
    "unused-argument": '<arg name="a" default="1"/>',
    "duplicate-argument": (
        '<arg name="a" value="1"/><arg name="a" value="1"/>'
        '<param name="p" value="$(arg a)"/>'
    ),
    "constant-argument": '<arg name="x" value="1"/><env name="x" value="$(arg x)"/>',
    "bad-argument": (
        '<arg name="a" value="1" default="2"/><param name="p" value="$(arg a)"/>'
    ),
    "duplicate-node": NODE.format("n") + NODE.format("n"),
    "bad-if": '<param name="p" value="1" if="perhaps"/>',
    "bad-eval": '<param name="p" value="$(eval 1 +)"/>',
    "bad-substitution": '<param name="p" value="$(seek x)"/>',
    "unset-environment": '<param name="p" value="$(env NOT_SET_IN_TESTS)"/>',
    "unresolved-find": '<param name="p" value="$(find nowhere)"/>',
    "bad-param": '<param name="p"/>',
    "bad-value": '<rosparam command="lode"/>',
    "bad-name": NODE.format("a/b"),
    "bad-command": """<param name="p" command="cat 'x"/>""",
    "deprecated": "<master/>",
    "unreadable-file": '<rosparam file="$(dirname)/binary.yaml"/>',
    "recursive-include": '<include file="$(dirname)/main.launch"/>',
}


@pytest.mark.parametrize("rule", FAULTS)
def test_each_rule_finds_its_fault(read: Reader, tmp_path: Path, rule: str) -> None:
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x80")
    arguments = {"x": "2"} if rule == "constant-argument" else {}
    launch = read(FAULTS[rule], **arguments)
    assert set(rules(launch)) == {rule}
    assert launch.findings[0].location.file == tmp_path / "main.launch"
    assert launch.findings[0].message
    pickle.loads(pickle.dumps(launch))


WHEREVER = {"unknown-element", "unknown-attribute", "missing-attribute"}
"""Told of elements that are switched off, too: no argument makes them right."""


@pytest.mark.parametrize("rule", [rule for rule in FAULTS if rule not in WHEREVER])
def test_nothing_is_wrong_with_what_is_switched_off(read: Reader, rule: str) -> None:
    launch = read(f'<group if="false">{FAULTS[rule]}</group>')
    assert set(rules(launch)) <= {"unused-argument"}


def test_a_typing_mistake_names_what_was_meant(read: Reader) -> None:
    (finding,) = read('<arg name="controler" default="1"/>', controller="2").findings[
        1:
    ]
    assert "'controler'" in finding.message
    (finding,) = read('<param nme="p" name="q" value="1"/>').findings
    assert (finding.severity, finding.key) == ("error", "nme")
    assert "'name'" in finding.message


def test_arguments_of_an_include_must_fit(read: Reader) -> None:
    launch = read(
        """<include file="$(dirname)/included.launch">
        <arg name="mor" value="1"/>
        <arg name="off" value="1" if="false"/>
        </include>""",
        '<arg name="more" default="1"/><arg name="less"/>'
        '<param name="p" value="$(arg more)$(arg less)"/>',
    )
    unused, missing = launch.findings
    assert (unused.rule, unused.location.line) == ("unused-argument", 3)
    assert "'more'" in unused.message
    assert (missing.rule, missing.location.line) == ("missing-argument", 2)
    assert "included.launch:1" in missing.message


def test_a_package_is_a_warning_where_there_is_no_ros(
    read: Reader, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    faulty = '<param name="p" value="$(find gazebo_ros)"/>'
    assert [f.severity for f in read(faulty).findings] == ["warning"]
    near = '<param name="p" value="$(find tool0_gazebbo)"/>'
    assert [f.severity for f in read(near).findings] == ["error"]
    (tmp_path / "roslaunch").mkdir()
    (tmp_path / "roslaunch" / "package.xml").write_text("<package/>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    (finding,) = read(faulty).findings
    assert finding.severity == "error"
    assert "ros-noetic-gazebo-ros" in finding.remedy


@pytest.mark.parametrize(
    ("content", "rule"),
    [
        (b"", "not-xml"),
        (b"<launch>", "not-xml"),
        (b"<robot/>", "not-launch"),
        (b'<!DOCTYPE launch [<!ENTITY a "a">]><launch/>', "not-xml"),
        (b'<?xml version="1.0" encoding="no-such"?><launch/>', "not-xml"),
        (b'<?xml version="1.0" encoding="idna"?><launch/>', "not-xml"),
        (b"\xff\xfe\x00<launch/>", "not-xml"),
        (b" " * (MAX_BYTES + 1), "not-xml"),
        (b"<group>" * 600 + b"</group>" * 600, "not-xml"),
    ],
)
def test_what_is_no_launch_file_is_a_finding(
    read: Reader, tmp_path: Path, content: bytes, rule: str
) -> None:
    file = tmp_path / "other.launch"
    file.write_bytes(content)
    assert rules(read_launch(file)) == [rule]
    launch = read('<include file="$(dirname)/other.launch"/>')
    assert rules(launch) == [rule]
    assert launch.findings[0].location.file == file
    (include,) = (entry for entry in launch.entries if isinstance(entry, Include))
    assert include.reason


def test_a_robot_s_file_must_be_there(read: Reader) -> None:
    launch = read('<param name="p" command="$(find xacro)/xacro /absent.xacro a:=1"/>')
    assert [(f.rule, f.key) for f in launch.findings] == [
        ("missing-file", "/absent.xacro")
    ]


def test_a_node_s_package_must_be_there_where_ros_is(
    read: Reader, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = '<node pkg="rqt_joint_trajectory_controller" type="t" name="n"/>'
    assert rules(read(node)) == []
    (tmp_path / "roslaunch").mkdir()
    (tmp_path / "roslaunch" / "package.xml").write_text("<package/>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    (finding,) = read(node).findings
    assert finding.rule == "missing-package"
    assert "ros-noetic-rqt-joint-trajectory-controller" in finding.remedy


def test_packages_of_a_workspace_are_found_however_it_is_linked(tmp_path: Path) -> None:
    for name in ("one/deep/a", "b", "one/src/c", ".hidden/d", "a/inner"):
        (tmp_path / "src" / name).mkdir(parents=True)
    for name in ("one/deep/a", "b", "one/src/c", ".hidden/d"):
        (tmp_path / "src" / name / "package.xml").write_text("<package/>")
    (tmp_path / "src" / "one" / "loop").symlink_to(tmp_path / "src")
    found = packages_around(tmp_path / "src" / "one" / "src" / "c" / "x.launch")
    assert sorted(found) == ["a", "b", "c"]
    assert packages_around(tmp_path / "x.launch") == {}


def test_a_file_that_is_none_is_a_finding(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "absent", Path("/dev/zero"), Path("x" * 5000)):
        assert rules(read_launch(path)) == ["not-xml"]


HUGE = {
    "many includes": '<include file="$(dirname)/main.launch" ns="a"/>' * 3,
    "deep groups": "<group>" * 200 + NODE.format("n") + "</group>" * 200,
    "growing arguments": "".join(
        f'<arg name="a{n + 1}" default="$(arg a{n})$(arg a{n})"/>' for n in range(60)
    ).join(
        ('<arg name="a0" default="xxxxxxxx"/>', '<env name="e" value="$(arg a60)"/>')
    ),
    "a long text": f'<arg name="a" default="{"x" * 90_000}"/>'
    + '<param name="p" value="$(arg a)"/>' * 2000,
    "many elements": NODE.format("n") * 25_000,
    "many dollars": f'<param name="p" value="{"$(" * 200_000}"/>',
}


@pytest.mark.slow
@pytest.mark.parametrize("case", HUGE)
def test_nothing_takes_long(read: Reader, case: str) -> None:
    start = time.perf_counter()
    launch = read(HUGE[case])
    assert time.perf_counter() - start < 10.0
    assert launch.findings or any(
        text.resolved is None for entry in launch.walk() for _, text in entry.texts
    )


def test_a_file_may_include_itself_while_an_argument_counts(read: Reader) -> None:
    launch = read(
        """<arg name="count" default="3"/>
        <param name="p$(arg count)" value="1"/>
        <include file="$(dirname)/main.launch" if="$(eval count > 0)">
          <arg name="count" value="$(eval count - 1)"/>
        </include>"""
    )
    names = [parameter.full_name for parameter in launch.parameters()]
    assert (names, rules(launch)) == (["/p3", "/p2", "/p1", "/p0"], [])


def test_commented_rosparams_know_their_lines(tmp_path: Path) -> None:
    file = tmp_path / "commented.launch"
    file.write_text(
        "<launch>\n<!-- 加载 <rosparam file='a.yaml'/>\n  <node>\n   <param/></node>"
        ' -->\n<!-- see <rosparam> and\n<rosparam command="load" file="b.yaml"> -->'
        "\n</launch>\n<!-- <rosparam file='c'/> --> <",
        encoding="utf-8",
    )
    assert list(commented_rosparams(file)) == [
        (SourceLocation(file, 2), "a.yaml"),
        (SourceLocation(file, 6), "b.yaml"),
        (SourceLocation(file, 8), "c"),
    ]
    assert list(commented_rosparams(tmp_path / "absent")) == []


def test_the_yaml_of_a_long_tag_knows_its_line(read: Reader) -> None:
    launch = read('<rosparam\n  ns="a>b"\n  command="load">\nx: 1\n</rosparam>')
    (rosparam,) = launch.rosparams()
    assert rosparam.yaml is not None
    assert rosparam.yaml.location.line == 4
