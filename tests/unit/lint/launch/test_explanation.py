"""The chains of a person's launch files, from where a value is written to its use."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tool0.description.packages import packages_around
from tool0.lint.launch.argument_flow import argument_flow
from tool0.lint.launch.explanation import Item, contents
from tool0.lint.launch.reader import read_launch
from tool0.lint.launch.xacro_files import xacro_robots
from tool0.lint.packages import PackageIndex

DATA = Path(__file__).parents[3] / "data" / "launch" / "src"
BRING_UP = DATA / "arm_gazebo" / "launch" / "arm_bringup.launch"


def explained(file: Path, **arguments: str) -> tuple[Item, tuple[Item, ...]]:
    """Return the contents of a file, and the ways of its arguments."""
    packages = PackageIndex(packages_around(file))
    launch = read_launch(file, arguments, packages)
    robots = xacro_robots(launch, packages)
    return contents(launch, robots), argument_flow(launch, robots)


def ways(item: Item, before: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield each way from an item to an end, with file and line at every step."""
    place = f"{Path(str(item.location.file)).name}:{item.location.line}"
    here = (*before, f"{place} {item.name}")
    if not item.items:
        yield here
    for inner in item.items:
        yield from ways(inner, here)


def test_a_value_is_followed_into_xacro() -> None:
    root, *_ = explained(BRING_UP)[1]
    (limits,) = [item for item in root.items if item.name == "limits"]
    assert limits.value == str(DATA / "arm_description" / "config" / "limits.yaml")
    assert list(ways(limits)) == [
        (
            "arm_bringup.launch:5 limits",
            "arm_bringup.launch:13 argument limits of load_arm2.launch.xml",
            "load_arm2.launch.xml:6 argument limits of load_arm.launch.xml",
            "load_arm.launch.xml:7 xacro argument limits of arm.xacro",
            "arm.xacro:8 limits_file of <xacro:arm_gazebo>",
        )
    ]


def test_a_value_may_end_in_several_places() -> None:
    root, *_ = explained(BRING_UP)[1]
    (gui,) = [item for item in root.items if item.name == "gui"]
    assert [way[-1] for way in ways(gui)] == [
        "control.launch.xml:17 value of param /sim/headless",
        "control.launch.xml:18 args of node /sim/server",
    ]


def test_in_included_files_only_what_begins_there_is_listed() -> None:
    files = explained(BRING_UP)[1]
    listed = {Path(f.name).name: [item.name for item in f.items] for f in files[1:]}
    assert listed == {
        "load_arm2.launch.xml": ["interface"],
        "load_arm.launch.xml": ["model"],
        "control.launch.xml": ["spawn_z", "recorded"],
    }


def test_xacro_files_are_followed_with_what_they_are_given() -> None:
    tree, _ = explained(BRING_UP)
    (robot,) = tree.items[0].items[0].items[0].items
    assert robot.kind == "xacro"
    given = {i.name: i.value for i in robot.items if i.kind == "xacro arg"}
    assert given["model"] == "arm2"
    (macro,) = [item for item in robot.items if item.kind == "xacro"]
    (described,) = macro.items
    expected = DATA / "arm_description" / "urdf" / "inc" / "arm_macro.xacro"
    assert described.name == str(expected)


def test_conditions_and_eval_use_arguments_too(tmp_path: Path) -> None:
    file = tmp_path / "main.launch"
    file.write_text(
        """<launch>
        <arg name="a" default="1"/>
        <arg name="b" default="$(eval a + 1)"/>
        <group if="$(arg a)">
          <node name="n" pkg="p" type="t" args="$(arg b)"/>
          <param name="p" value="1"/>
        </group>
        <rosparam subst_value="true">{x: $(arg b)}</rosparam>
        <node name="m" pkg="p" type="t" unless="$(arg a)"/>
        </launch>"""
    )
    (root,) = explained(file)[1]
    found = [way[1:] for item in root.items for way in ways(item)]
    assert found == [
        ("main.launch:3 argument b", "main.launch:5 args of node /n"),
        ("main.launch:3 argument b", "main.launch:8 yaml of rosparam load"),
        ("main.launch:4 if of the group",),
        ("main.launch:9 unless of node /m",),
        ("main.launch:5 args of node /n",),
        ("main.launch:8 yaml of rosparam load",),
    ]


def test_a_choice_between_values_is_followed(tmp_path: Path) -> None:
    file = tmp_path / "main.launch"
    file.write_text(
        """<launch>
        <arg name="paused" default="true"/>
        <arg name="word" value="" unless="$(arg paused)"/>
        <arg name="word" value="-u" if="$(arg paused)"/>
        <node name="n" pkg="p" type="t" args="$(arg word)"/>
        </launch>"""
    )
    (root,) = explained(file)[1]
    assert [way[1:] for way in ways(root.items[0])] == [
        ("main.launch:3 unless of argument word",),
        ("main.launch:4 if of argument word", "main.launch:5 args of node /n"),
    ]


def test_what_is_unresolved_says_why(tmp_path: Path) -> None:
    file = tmp_path / "main.launch"
    file.write_text(
        """<launch>
        <arg name="a"/>
        <param name="robot_description" command="xacro $(arg a)"/>
        <include file="$(find nowhere_at_all)/x.launch"/>
        <param name="description" command="$(find xacro)/xacro $(dirname)/no.xacro"/>
        </launch>"""
    )
    robot, include, other = explained(file)[0].items
    assert robot.note == "argument 'a' has no value"
    assert include.note == "package 'nowhere_at_all' is not found"
    assert other.items[0].note == "is no file"
