"""Python launch files with all they load: robots, YAML, spawners, simulations."""

from pathlib import Path

import pytest
from check_files import rules, write

from tool0.lint.check import check

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("at_once")]

FILES = {
    "package.xml": """
        <package format="3">
          <name>mine</name><version>1.0.0</version><description>d</description>
          <maintainer email="a@b.c">m</maintainer><license>MIT</license>
          <exec_depend>xacro</exec_depend><exec_depend>ros_gz_sim</exec_depend>
        </package>
        """,
    "description/urdf/r.urdf.xacro": """
        <robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
          <xacro:arg name="controllers" default=""/>
          <xacro:include filename="$(find mine)/urdf/joint.xacro"/>
          <gazebo>
            <plugin filename="gz_ros2_control-system" name="a::B">
              <parameters>$(arg controllers)</parameters>
            </plugin>
          </gazebo>
        </robot>
        """,
    "description/urdf/joint.xacro": """
        <robot xmlns:xacro="http://www.ros.org/wiki/xacro">
          <link name="world"/>
          <link name="arm"><inertial><mass value="1"/><inertia
            ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
          <joint name="elbow" type="revolute">
            <parent link="world"/><child link="arm"/><axis xyz="0 0 1"/>
            <limit lower="-1" upper="1" effort="10" velocity="1"/>
          </joint>
          <ros2_control name="r" type="system">
            <hardware><plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>
            <joint name="elbow">
              <command_interface name="position"/><state_interface name="position"/>
              <state_interface name="velocity"/>
            </joint>
          </ros2_control>
        </robot>
        """,
    "config/c.yaml": """
        controller_manager:
          ros__parameters:
            update_rate: 500
            states: {type: joint_state_broadcaster/JointStateBroadcaster}
            arm: {type: joint_trajectory_controller/JointTrajectoryController}
            forward: {type: forward_command_controller/ForwardCommandController}
        arm:
          ros__parameters:
            joints: [elbow]
            command_interfaces: [position]
            state_interfaces: [position, velocity]
        forward:
          ros__parameters:
            joints: [elbow]
            interface_name: position
        """,
    "launch/gz.launch.py": """
        from launch import LaunchDescription
        from launch.actions import IncludeLaunchDescription
        from launch.launch_description_sources import PythonLaunchDescriptionSource
        from launch.substitutions import Command, PathJoinSubstitution
        from launch_ros.actions import Node
        from launch_ros.substitutions import FindPackageShare


        def share(*parts):
            return PathJoinSubstitution([FindPackageShare("mine"), *parts])


        def spawner(*names):
            return Node(
                package="controller_manager",
                executable="spawner",
                arguments=[*names, "-c", "/controller_manager"],
            )


        def generate_launch_description():
            robot = Command([
                "xacro ", share("urdf", "r.urdf.xacro"),
                " controllers:=", share("config", "c.yaml"),
            ])
            return LaunchDescription([
                Node(package="ros_gz_sim", executable="create"),
                Node(
                    package="robot_state_publisher",
                    executable="robot_state_publisher",
                    parameters=[{"robot_description": robot, "use_sim_time": True}],
                ),
                spawner("states", "arm"),
            ])
        """,
}
LAUNCH, CONFIG = "launch/gz.launch.py", "config/c.yaml"


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    return write(tmp_path / "src" / "mine", FILES)


def replaced(folder: Path, name: str, old: str, new: str) -> None:
    path = folder / name
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")


def test_a_package_without_faults_has_no_findings(workspace: Path) -> None:
    report = check([workspace])
    assert report.findings == ()
    assert LAUNCH in {str(path.relative_to(workspace)) for path in report.files}


@pytest.mark.parametrize(
    ("file", "old", "new", "expected"),
    [
        (LAUNCH, '"states", "arm"', '"states", "amr"', ("no-controller", 17)),
        (LAUNCH, '"states", "arm"', '"arm", "forward"', ("two-controllers", 17)),
        (LAUNCH, '"use_sim_time": True', '"a": 1', ("no-sim-time", 28)),
        (LAUNCH, "executable=", "executible=", ("unknown-attribute", 16)),
        (LAUNCH, '"r.urdf.xacro"', '"q.urdf.xacro"', ("missing-file", 22)),
        (CONFIG, "joints: [elbow]", "joints: [elbov]", ("unknown-joint", 9)),
        (
            CONFIG,
            "command_interfaces: [position]",
            "command_interfaces: [velocity]",
            ("interface-mismatch", 9),
        ),
    ],
)
def test_one_fault_is_named_where_it_stands(
    workspace: Path, file: str, old: str, new: str, expected: tuple[str, int | None]
) -> None:
    replaced(workspace, file, old, new)
    found = rules(workspace)
    assert expected in [(rule, line) for _, line, rule in found], found


def test_a_spawner_s_own_file_defines_controllers(workspace: Path) -> None:
    write(
        workspace,
        {
            "config/own.yaml": """
                own:
                  ros__parameters:
                    type: forward_command_controller/ForwardCommandController
                    joints: [elbow]
                    interface_name: position
                """
        },
    )
    replaced(
        workspace,
        LAUNCH,
        'spawner("states", "arm")',
        'spawner("own", "--inactive", "--param-file", share("config", "own.yaml"))',
    )
    assert rules(workspace) == []


def test_a_launch_file_is_checked_wherever_one_stands(
    workspace: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replaced(workspace, LAUNCH, '"states", "arm"', '"states", "amr"')
    monkeypatch.chdir(workspace.parent)
    assert [f.rule for f in check([Path("mine")]).findings] == ["no-controller"]


def test_xml_of_ros_2_is_named_as_not_read(workspace: Path) -> None:
    text = '<launch><node pkg="xacro" exec="b"/></launch>'
    write(workspace, {"launch/x.launch.xml": text})
    report = check([workspace])
    assert report.findings == ()
    assert any("XML are not read" in note for note in report.notes)


def test_an_argument_without_a_value_is_a_note(workspace: Path) -> None:
    replaced(
        workspace,
        LAUNCH,
        "LaunchDescription([\n",
        'LaunchDescription([DeclareLaunchArgument("ip"),\n'
        'Node(package="a", executable="b", arguments=[LaunchConfiguration("ip")]),\n',
    )
    replaced(
        workspace,
        LAUNCH,
        "import IncludeLaunchDescription",
        "import IncludeLaunchDescription, DeclareLaunchArgument",
    )
    replaced(
        workspace, LAUNCH, "import Command,", "import Command, LaunchConfiguration,"
    )
    report = check([workspace])
    assert report.findings == ()
    assert any("what depends on ip was not checked" in note for note in report.notes)


def test_groups_of_joints_are_no_robot(workspace: Path) -> None:
    text = '<robot name="r"><group name="arm"><joint name="elbow"/></group></robot>'
    write(workspace, {"config/r.srdf.xacro": text})
    assert rules(workspace) == []
