"""Launch files with all they load, packages, and edits of other people's files."""

from pathlib import Path

import pytest
from check_files import rules, write

from tool0.lint.check import check

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("at_once")]

PACKAGE = """
<package format="3">
  <name>{name}</name><version>1.0.0</version><description>d</description>
  <maintainer email="a@b.c">m</maintainer><license>MIT</license>
  {depends}
</package>
"""
LAUNCH = """
<launch>
  <arg name="controllers" default="arm"/>
  <param name="robot_description"
    command="$(find xacro)/xacro $(find mine)/urdf/r.urdf.xacro side:=left"/>
  <rosparam file="$(find mine)/config/c.yaml" command="load"/>
  <node name="spawn" pkg="controller_manager" type="spawner" args="$(arg controllers)"/>
</launch>
"""
ROBOT = """
<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="side" default=""/>
  <link name="world"/>
  <joint name="$(arg side)_joint" type="continuous">
    <parent link="world"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit effort="10" velocity="2"/>
  </joint>
  <link name="tip">
    <inertial><mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
  </link>
  <transmission name="t">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="$(arg side)_joint">
      <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>
    </joint>
    <actuator name="m"/>
  </transmission>
  <gazebo><plugin name="c" filename="libgazebo_ros_control.so"/></gazebo>
</robot>
"""
YAML = """
arm:
  type: effort_controllers/JointTrajectoryController
  joints: [left_joint]
  gains: {left_joint: {p: 1}}
other:
  type: effort_controllers/JointGroupEffortController
  joints: [left_joint]
"""
DEPENDS = "xacro controller_manager gazebo_ros_control"


def workspace(folder: Path, **changed: str) -> Path:
    """Write a package without a fault, but for what is changed."""
    depends = changed.pop("depends", DEPENDS).split()
    lines = "".join(f"<exec_depend>{name}</exec_depend>" for name in depends)
    texts = {"launch": LAUNCH, "robot": ROBOT, "yaml": YAML, **changed}
    return write(
        folder,
        {
            "mine/package.xml": PACKAGE.format(name="mine", depends=lines),
            "mine/launch/up.launch": texts["launch"],
            "mine/urdf/r.urdf.xacro": texts["robot"],
            "mine/config/c.yaml": texts["yaml"],
        },
    )


def test_a_good_workspace_is_clean(tmp_path: Path) -> None:
    report = check([workspace(tmp_path)])
    assert report.findings == ()
    assert len(report.files) == 4
    assert all("not on this machine" in note for note in report.notes)


SECOND = '<gazebo><plugin name="d" filename="libgazebo_ros_control.so"/></gazebo>'


@pytest.mark.parametrize(
    ("part", "old", "new", "expected"),
    [
        ("launch", '"arm"', '"arn"', "launch/up.launch:6 no-controller"),
        ("launch", '"arm"', '"arm other"', "launch/up.launch:6 two-controllers"),
        ("launch", "side:=left", "", "config/c.yaml:3 unknown-joint"),
        ("launch", "side:=", "sid:=", "urdf/r.urdf.xacro:None xacro-fails"),
        ("launch", "c.yaml", "d.yaml", "launch/up.launch:5 missing-file"),
        ("launch", 'type="sp', 'tpye="x" type="sp', "launch/up.launch:6 unknown-"),
        ("yaml", "joints: [left_j", "joints: [l_j", "config/c.yaml:3 unknown-joint"),
        ("yaml", "{p: 1}", "{d: 1}", "config/c.yaml:4 missing-gains"),
        ("robot", "ware_inter", "ware/inter", "urdf/r.urdf.xacro:15 interface-typo"),
        ("robot", "EffortJ", "PositionJ", "config/c.yaml:3 interface-mismatch"),
        ("robot", "</ro", SECOND + "</ro", "urdf/r.urdf.xacro:20 two-plugins"),
        ("depends", "xacro ", "", "package.xml:1 missing-dependency"),
    ],
)
def test_one_fault_is_named_where_it_stands(
    tmp_path: Path, part: str, *, old: str, new: str, expected: str
) -> None:
    whole = {"launch": LAUNCH, "robot": ROBOT, "yaml": YAML, "depends": DEPENDS}[part]
    assert old in whole
    found = rules(workspace(tmp_path, **{part: whole.replace(old, new, 1)}))
    lines = [f"{file}:{line} {rule}" for file, line, rule in found]
    assert any(line.startswith(f"mine/{expected}") for line in lines), lines


def test_two_stopped_controllers_may_share_a_joint(tmp_path: Path) -> None:
    load = '<node name="s" pkg="controller_manager" type="spawner" args="{}other"/>'
    both = LAUNCH.replace("</launch>", load.format("--stopped ") + "</launch>")
    assert rules(workspace(tmp_path / "stopped", launch=both)) == []
    both = LAUNCH.replace("</launch>", load.format("") + "</launch>")
    found = rules(workspace(tmp_path / "started", launch=both))
    assert [rule for _, _, rule in found] == ["two-controllers"]


def test_a_package_that_is_misspelt_is_an_error_and_one_that_is_away_is_not(
    tmp_path: Path,
) -> None:
    include = '<include file="$(find {})/launch/a.launch"/></launch>'
    away = workspace(
        tmp_path / "away",
        launch=LAUNCH.replace("</launch>", include.format("far_away")),
        depends=f"{DEPENDS} far_away",
    )
    report = check([away])
    assert report.n_errors == 0
    assert any("'far_away' is not on this machine" in note for note in report.notes)
    launch = LAUNCH.replace("</launch>", include.format("tool0_descripton"))
    typo = rules(workspace(tmp_path / "typo", launch=launch))
    assert ("mine/launch/up.launch", 7, "unresolved-find") in typo


def test_files_that_others_include_are_judged_with_what_they_get(
    tmp_path: Path,
) -> None:
    write(
        tmp_path,
        {
            "all.launch": '<launch><include file="$(dirname)/one.launch">'
            '<arg name="needed" value="1"/></include></launch>',
            "one.launch": '<launch><arg name="needed"/>'
            '<param name="a" value="$(arg needed)"/></launch>',
        },
    )
    assert rules(tmp_path) == []


def test_a_bad_package_file_is_told(tmp_path: Path) -> None:
    write(tmp_path, {"a/package.xml": "<package><name>a</name></package>"})
    assert [rule for _, _, rule in rules(tmp_path)] == ["bad-package"] * 4
    write(tmp_path, {"a/package.xml": "<package><name>a</package>"})
    assert [rule for _, _, rule in rules(tmp_path)] == ["bad-xml"]


def test_a_file_that_others_include_is_no_robot_by_itself(tmp_path: Path) -> None:
    opening = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    files = {
        "top.xacro": opening
        + '<link name="base"/><xacro:include filename="part.xacro"/></robot>',
        "part.xacro": opening + '<link name="tip"/><joint name="j" type="fixed">'
        '<parent link="base"/><child link="tip"/></joint></robot>',
    }
    assert rules(write(tmp_path, files)) == []
    (tmp_path / "top.xacro").unlink()
    assert {rule for _, _, rule in rules(tmp_path)} == {"no-root", "unknown-link"}


def test_what_only_tool0_refuses_is_said_once_and_is_no_error(tmp_path: Path) -> None:
    text = """
    <robot name="r">
      <link name="base"/>
      <gazebo reference="bsae"><selfCollide>true</selfCollide></gazebo>
    </robot>
    """
    report = check([write(tmp_path, {"r.urdf": text})])
    assert [(item.rule, item.severity) for item in report.findings] == [
        ("unknown-reference", "warning")
    ]


@pytest.mark.parametrize(
    ("depends", "others", "is_missing"),
    [
        ("arm", "xacro", False),  # with the arm comes xacro
        ("arm", "", True),
        ("arm far_away", "", True),
    ],
)
def test_a_missing_dependency_may_come_with_another(
    tmp_path: Path, depends: str, others: str, is_missing: bool
) -> None:
    def lines(names: str) -> str:
        return "".join(f"<depend>{name}</depend>" for name in names.split())

    write(
        tmp_path,
        {
            "arm/package.xml": PACKAGE.format(name="arm", depends=lines(others)),
            "mine/package.xml": PACKAGE.format(name="mine", depends=lines(depends)),
            "mine/up.launch": '<launch><node pkg="xacro" type="x" name="n"/></launch>',
        },
    )
    (tmp_path / "xacro").mkdir()
    found = [f for f in check([tmp_path]).findings if f.rule == "missing-dependency"]
    expected = [("xacro", "warning")] if is_missing else []
    assert [(item.key, item.severity) for item in found] == expected


@pytest.mark.parametrize(
    ("exported", "in_cmake"),
    [
        ('<export><controller_interface plugin="${prefix}/p.xml"/></export>', ""),
        ("", "pluginlib_export_plugin_description_file(controller_interface p.xml)"),
    ],
)
@pytest.mark.parametrize("where", ["workspace", "path"])
def test_what_a_package_exports_is_a_known_type(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    *,
    exported: str,
    in_cmake: str,
    where: str,
) -> None:
    """pluginlib finds it by package.xml in ROS 1, by CMakeLists.txt in ROS 2."""
    plugins = """
        <class_libraries><library path="lib/libown">
          <class name="own_controllers/Twister"
                 type="own::Twister" base_class_type="controller_interface::X"/>
          <class type="own::NoName"
                 base_class_type="controller_interface::X"></class>
          <!-- <class name="own_controllers/Removed" type="x"/> -->
        </library></class_libraries>
    """
    package = PACKAGE.format(name="own_controllers", depends=exported)
    yaml = """
        a: {type: own_controllers/Twister}
        b: {type: "own::NoName"}
        c: {type: own_controllers/Removed}
        d: {type: effort_controllers/JointEffortController, joint: elbow_joint}
    """
    own = tmp_path / where
    write(
        own / "own_controllers",
        {"package.xml": package, "CMakeLists.txt": in_cmake, "p.xml": plugins},
    )
    write(tmp_path / "workspace", {"config/c.yaml": yaml})
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "path"))
    report = check([tmp_path / "workspace"])
    (finding,) = (f for f in report.findings if f.rule == "unknown-type")
    assert (finding.key, finding.severity) == ("c/type", "warning")


def test_a_xacro_that_needs_an_argument_is_not_judged_without(tmp_path: Path) -> None:
    """xacro evaluates the attributes of <robot> before it meets the default."""
    text = """
        <robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="$(arg name)">
          <xacro:arg name="name" default="ur"/><link name="a"/></robot>
    """
    report = check([write(tmp_path, {"r.srdf.xacro": text})])
    assert report.findings == ()
    assert any("nothing here gives it name" in note for note in report.notes)


@pytest.mark.parametrize(
    ("value", "found"), [("[a, b]", set()), ("[a, b", {"not-yaml"})]
)
def test_one_parameter_may_be_any_yaml(
    tmp_path: Path, value: str, found: set[str]
) -> None:
    launch = LAUNCH.replace(
        "</launch>", f'<rosparam param="source_list">{value}</rosparam></launch>'
    )
    folder = workspace(tmp_path, launch=launch)
    assert {finding.rule for finding in check([folder]).findings} == found


def test_faults_of_strangers_files_that_are_none(tmp_path: Path) -> None:
    """Parts of robots, files of OpenCV, required arguments, packages of others."""
    xmlns = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    write(
        tmp_path,
        {
            "ur_description/package.xml": PACKAGE.format(
                name="ur_description", depends="<depend>pr2_description</depend>"
            ),
            "ur_description/colors.xacro": f'<robot {xmlns}><material name="a">'
            '<color rgba="1 0 0 1"/></material></robot>',
            "ur_description/camera.yaml": "%YAML:1.0\nmatrix: !!opencv-matrix\n",
            "ur_description/show.launch": '<launch><arg name="cfg"/>'
            '<param name="p" value="$(arg cfg)"/>'
            '<param name="f" textfile="$(find pr2_description)/a.txt"/></launch>',
        },
    )
    report = check([tmp_path])
    assert report.findings == ()
    assert any("the argument 'cfg' has no default" in note for note in report.notes)
    assert any("'pr2_description' is not on this machine" in n for n in report.notes)
