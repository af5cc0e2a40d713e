"""What `tool0 workspace` writes is built, linted and launched by Debian's ROS 1.

Debian has no gazebo_ros, no controller_manager and no rqt_joint_trajectory_controller:
empty packages stand in, so that roslaunch finds them, and what it would run is read,
not run.  All else is the real thing: catkin, catkin_lint, roslaunch, check_urdf, RViz,
Gazebo's own converter.
"""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import yaml
from catkin_rig import Catkin, require_catkin, sourced
from in_rviz import black, blue, shown, variables, view
from promised import absent, require_engine, require_ros
from ros import TIMEOUT, Ros
from screen import Pixels, Screen, find_xvfb

from tool0.cli import OK, main
from tool0.control.default_controllers import controllers_yaml
from tool0.description.loading import assemble, named_poses
from tool0.description.urdf import read_model
from tool0.description.xml_source import parse_text
from tool0.installation.child_process import ChildProcess
from tool0.installation.gazebo.installation import find_installation
from tool0.installation.robot_packages import PACKAGES

DATA = Path(__file__).parents[1] / "data"
GAZEBO = ("tool0_gazebo", "bringup.launch")
VIEW = ("tool0_description", "view.launch")
CONTROLLERS = "tool0_gazebo/config/ur5_2f85_controllers.yaml"


def write(catkin: Catkin, *options: str) -> None:
    assert main(["workspace", str(catkin.folder), *options]) == OK


@pytest.fixture(scope="module")
def catkin(tmp_path_factory: pytest.TempPathFactory) -> Catkin:
    """Write a workspace, as a person does."""
    require_catkin()
    catkin = Catkin(tmp_path_factory.mktemp("catkin") / "workspace")
    write(catkin)
    return catkin


@pytest.fixture(scope="module")
def built(catkin: Catkin) -> Catkin:
    """Build and install it."""
    catkin.out("catkin_make", f"-DCMAKE_INSTALL_PREFIX={catkin.install}", "install")
    return catkin


@pytest.fixture(scope="module")
def parameters(catkin: Catkin) -> dict[str, object]:
    """The parameters that the bring-up sets without arguments."""
    return catkin.parameters(*GAZEBO)


@pytest.fixture(scope="module")
def quickly(catkin: Catkin) -> tuple[str, str, str]:
    """Return the bring-up without xacro, which takes a second: for nodes alone."""
    nothing = catkin.folder.parent / "nothing.launch.xml"
    nothing.write_text("<launch/>")
    return (*GAZEBO, f"robot_description_file:={nothing}")


@pytest.fixture(scope="module")
def urdf(parameters: dict[str, object]) -> str:
    return str(parameters["/robot_description"])


# --- catkin ---


def test_catkin_installs_every_file(built: Catkin) -> None:
    for name in PACKAGES:
        here, there = built.source / name, built.install / "share" / name
        for path in here.rglob("*"):
            if path.is_file() and path.name != "CMakeLists.txt" and path.name[0] != ".":
                copy = there / path.relative_to(here)
                if path.parent.name == "scripts":
                    copy = built.install / "lib" / name / path.name
                    assert os.access(copy, os.X_OK)
                assert copy.read_bytes() == path.read_bytes()


def test_what_was_installed_is_launched_from_there(built: Catkin) -> None:
    environment = sourced(built, built.install / "setup.bash")
    share = built.install / "share"
    assert str(share) in environment["ROS_PACKAGE_PATH"].split(":")
    path = f"{environment['ROS_PACKAGE_PATH']}:{built.stand_ins}"
    nodes = built.out("roslaunch", "--nodes", *GAZEBO, ROS_PACKAGE_PATH=path)
    assert "/spawn_gazebo_model" in nodes.split()


def test_catkin_lint_has_nothing_to_say(catkin: Catkin, tmp_path: Path) -> None:
    answer = catkin.run("catkin_lint", "-W2", "--strict", "src")
    assert answer.returncode == 0, answer.stderr
    assert "found 0 problems" in answer.stderr
    worse = tmp_path / "tool0_gazebo"
    shutil.copytree(catkin.source / "tool0_gazebo", worse)
    manifest = worse / "package.xml"
    rows = manifest.read_text().splitlines(keepends=True)
    manifest.write_text("".join(row for row in rows if ">rviz<" not in row))
    assert catkin.run("catkin_lint", "-W2", "--strict", worse).returncode != 0


# --- the robot ---


def test_the_robot_is_the_one_that_the_program_reads(urdf: str) -> None:
    """But for what stands in for the drive's rotor, which Gazebo does not have."""
    model = read_model(parse_text(urdf))
    stand_in = {"gripper_damping": 1.0, "gripper_knuckle_inertia": 0.006}
    assert model == assemble(**stand_in).model
    knuckle = model.link("left_outer_knuckle").inertial
    assert knuckle is not None
    assert knuckle.ixx == pytest.approx(0.006, rel=1e-3)
    assert assemble().model.joint("finger_joint").damping == 0.2


def test_check_urdf_accepts_it(catkin: Catkin, urdf: str, tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text(urdf)
    output = catkin.out("check_urdf", file)
    assert "Successfully Parsed XML" in output
    assert "root Link: world has 1 child" in output


def test_gazebo_converts_it(urdf: str, tmp_path: Path) -> None:
    require_engine("gazebo")
    installation = find_installation()
    programs = installation.server.parent
    gz = next(
        path
        for path in (programs / f"gz-{installation.version}", programs / "gz")
        if path.is_file()
    )
    environment = {**os.environ, **installation.environment, "HOME": str(tmp_path)}

    def ask(option: str, file: Path) -> str:
        answer = subprocess.run(
            [str(gz), "sdf", option, str(file)],
            env=environment,
            capture_output=True,
            text=True,
            timeout=60,
            check=True,
        )
        assert "Error" not in answer.stderr + answer.stdout
        assert "Warning" not in answer.stderr + answer.stdout
        return answer.stdout

    (tmp_path / "robot.urdf").write_text(urdf)
    (tmp_path / "robot.sdf").write_text(ask("-p", tmp_path / "robot.urdf"))
    assert "Check complete" in ask("-k", tmp_path / "robot.sdf")

    model = ET.parse(tmp_path / "robot.sdf").getroot().find("model")
    assert model is not None
    (plugin,) = model.iterfind(".//plugin")
    assert plugin.get("filename") == "libgazebo_ros_control.so"
    mimics = [joint.name for joint in assemble().model.joints if joint.mimic]
    gears = [joint.get("name") for joint in model.iterfind("joint[@type='gearbox']")]
    assert sorted(gears) == sorted(f"{name}_gearbox" for name in mimics)
    bodies = {link.get("name") for link in model.iterfind("link")}
    for joint in model.iterfind("joint"):
        ends = {joint.findtext("parent"), joint.findtext("child")}
        assert ends <= bodies | {"world"}
        reference = joint.findtext("gearbox_reference_body")
        assert reference is None or reference in bodies


def test_upstream_meshes_are_upstreams(tmp_path: Path) -> None:
    require_catkin()
    catkin = Catkin(tmp_path / "workspace")
    write(catkin, "--upstream-meshes")
    config = catkin.add_package("ur_description") / "config" / "ur5"
    config.mkdir(parents=True)
    looks = DATA / "description" / "ur5_noetic_visual_parameters.yaml"
    shutil.copy(looks, config / "visual_parameters.yaml")
    for package, file in (GAZEBO, VIEW):
        robot = ET.fromstring(catkin.parameters(package, file)["/robot_description"])
        for link in robot.iterfind("link"):
            seen = {mesh.get("filename") for mesh in link.iterfind("visual//mesh")}
            assert all("://tool0_" not in str(name) for name in seen)
        names = " ".join(
            m.get("filename", "") for m in robot.iterfind(".//visual//mesh")
        )
        assert "package://cube_description/" in names  # as that file has them
        assert "package://robotiq_2f_85_gripper_visualization/" in names
        assert not list(robot.iterfind(".//collision//mesh"))


@pytest.mark.parametrize(("arm", "gripper"), [("ur10e", "2f140"), ("ur3e", "none")])
def test_another_robot_is_the_default_where_it_was_chosen(
    tmp_path: Path, arm: str, gripper: str
) -> None:
    require_catkin()
    catkin = Catkin(tmp_path / "workspace")
    write(catkin, "--arm", arm, "--gripper", gripper)
    found = catkin.parameters(*GAZEBO)
    expected = assemble(arm, None if gripper == "none" else gripper)
    assert read_model(parse_text(str(found["/robot_description"]))) == expected.model
    program = yaml.safe_load(controllers_yaml(expected))
    controllers = {name.split("/")[1] for name in found if name.endswith("/type")}
    assert controllers == {name for name in program if "type" in program[name]}
    started = catkin.node_arguments("/ros_control_controller_spawner", *GAZEBO)
    assert ("gripper_controller" in started) is (gripper != "none")
    viewed = catkin.parameters(*VIEW)["/robot_description"]
    assert read_model(parse_text(str(viewed))) == expected.model


# --- the launch files ---


def test_every_launch_file_is_resolved(catkin: Catkin) -> None:
    controllers = catkin.source / CONTROLLERS
    files = sorted(catkin.source.glob("*/launch/**/*.launch*"))
    assert len(files) == 4
    for file in files:
        needed = [f"controller_config_file:={controllers}"] * file.match("control.*")
        catkin.out("roslaunch", "--nodes", file, *needed)
        for line in catkin.out("roslaunch", "--ros-args", file).splitlines():
            # every argument is explained
            assert (
                line.endswith("Arguments:")
                or len(line.partition("): ")[2]) > 9
                or (" (default" not in line and ": " in line)
            ), line


def test_without_arguments_it_is_the_tutorial(
    catkin: Catkin, quickly: tuple[str, str, str], parameters: dict[str, object]
) -> None:
    assert catkin.nodes(*GAZEBO) == {
        "/robot_state_publisher",
        "/spawn_gazebo_model",
        "/unpause_when_loaded",
        "/ros_control_controller_spawner",
        "/ros_control_stopped_spawner",
        "/gui_controller",
    }
    assert parameters["/gazebo_started/world_name"] == "worlds/empty.world"
    assert parameters["/gazebo_started/gui"] is True
    assert parameters["/robot_state_publisher/publish_frequency"] == 125
    assert parameters["/robot_state_publisher/tf_prefix"] == ""
    controllers = {name.split("/")[1] for name in parameters if name.endswith("/type")}
    assert controllers == {
        "joint_state_controller",
        "eff_joint_traj_controller",
        "gripper_controller",
        "joint_group_eff_controller",
    }
    spawn = catkin.node_arguments("/spawn_gazebo_model", *quickly).split()
    assert spawn[-1] == "__name:=spawn_gazebo_model"
    assert parameters["/gazebo_started/paused"] is True  # or the arm would fall
    unpause = catkin.node_arguments("/unpause_when_loaded", *quickly)
    assert " joint_state_controller eff_joint_traj_controller gripper_c" in unpause
    assert unpause.split().count("-J") == spawn.count("-J") == 6
    given = {
        spawn[i + 1]: float(spawn[i + 2]) for i, w in enumerate(spawn) if w == "-J"
    }
    home = named_poses(assemble())["home"]
    assert given == {name: q for name, q in home.items() if name != "finger_joint"}


def test_every_argument_for_gazebo_ends_where_it_should(
    catkin: Catkin, quickly: tuple[str, str, str]
) -> None:
    args = (
        *("gui:=false", "paused:=true", "gazebo_world:=my.world"),
        *("gazebo_model_name:=ur5", "spawn_z:=0.7", "initial_joint_positions:=-J a 1"),
        *("robot_description_param_name:=other", "rviz:=true"),
        *("controllers:=one two", "stopped_controllers:=three"),
        *("tf_prefix:=left", "tf_pub_rate:=50"),
    )
    found = catkin.parameters(*quickly, *args)
    assert found["/gazebo_started/world_name"] == "my.world"
    assert found["/gazebo_started/gui"] is False
    assert found["/robot_state_publisher/tf_prefix"] == "left"
    assert found["/robot_state_publisher/publish_frequency"] == 50
    nodes = catkin.nodes(*quickly, *args)
    assert "/rviz" in nodes
    assert "/unpause_when_loaded" not in nodes
    assert "/gui_controller" not in nodes  # by default with Gazebo's window
    assert "/gui_controller" in catkin.nodes(*quickly, "gui:=false", "rqt:=true")
    spawn = catkin.node_arguments("/spawn_gazebo_model", *quickly, *args)
    assert "-param other -model ur5 -z 0.7 -J a 1 __name" in " ".join(spawn.split())
    started = catkin.node_arguments("/ros_control_controller_spawner", *quickly, *args)
    assert "/spawner one two __name" in started
    stopped = catkin.node_arguments("/ros_control_stopped_spawner", *quickly, *args)
    assert "/spawner --stopped three __name" in stopped


def test_nothing_is_started_that_is_not_wanted(
    catkin: Catkin, quickly: tuple[str, str, str], tmp_path: Path
) -> None:
    """From a launch file: on its command line roslaunch overlooks empty values."""
    own = tmp_path / "own.launch"
    own.write_text(
        "<launch><include file='$(find tool0_gazebo)/launch/bringup.launch'>"
        "<arg name='start_gazebo' value='false'/>"
        f"<arg name='robot_description_file' value='{quickly[-1].partition(':=')[2]}'/>"
        "<arg name='stopped_controllers' value=''/>"
        "<arg name='initial_joint_positions' value=''/></include></launch>"
    )
    text = catkin.out("roslaunch", "--dump-params", own)
    assert "/gripper_controller/type" in text
    assert "gazebo_started" not in text
    assert "/ros_control_stopped_spawner" not in catkin.out("roslaunch", "--nodes", own)
    spawn = catkin.out("roslaunch", "--args", "/spawn_gazebo_model", own)
    assert "-J" not in spawn.split()


def test_the_grippers_controller_is_chosen(
    catkin: Catkin,
    quickly: tuple[str, str, str],
    parameters: dict[str, object],
    tmp_path: Path,
) -> None:
    kind = "/gripper_controller/type"
    assert parameters[kind] == "effort_controllers/JointTrajectoryController"
    action = catkin.parameters(*quickly, "gripper_action:=true")
    assert action[kind] == "effort_controllers/GripperActionController"
    own = tmp_path / "own.yaml"
    own.write_text("mine: {type: joint_state_controller/JointStateController}\n")
    found = catkin.parameters(*quickly, f"controller_config_file:={own}")
    assert "/mine/type" in found
    assert kind not in found


def test_the_robots_arguments_end_in_the_robot(catkin: Catkin, tmp_path: Path) -> None:
    """Each of the four parameter files, changed, changes the robot so."""
    config = catkin.source / "tool0_description" / "config" / "arms" / "ur5"
    changed = {
        "joint_limit_params": ("joint_limits.yaml", "150.0", "149.0"),
        "kinematics_params": ("default_kinematics.yaml", "0.089159", "0.1"),
        "physical_params": ("physical_parameters.yaml", "8.393", "8.0"),
        "visual_params": ("visual_parameters.yaml", "0.0745", "0.08"),
    }
    args = [
        "transmission_hw_interface:=hardware_interface/PositionJointInterface",
        *("safety_limits:=true", "safety_pos_margin:=0.2", "safety_k_position:=30"),
        "spawn_z:=0.7",
    ]
    for name, (file, old, new) in changed.items():
        text = (config / file).read_text()
        assert old in text
        (tmp_path / file).write_text(text.replace(old, new))
        args.append(f"{name}:={tmp_path / file}")
    robot = ET.fromstring(catkin.parameters(*GAZEBO, *args)["/robot_description"])

    def attribute(path: str, name: str) -> str | None:
        element = robot.find(path)
        assert element is not None
        return element.get(name)

    lift = "joint[@name='shoulder_lift_joint']"
    assert attribute(f"{lift}/limit", "effort") == "149.0"
    assert attribute("joint[@name='shoulder_pan_joint']/origin", "xyz") == "0 0 0.1"
    assert attribute("link[@name='upper_arm_link']//mass", "value") == "8.0"
    assert attribute("link[@name='pedestal']/visual//cylinder", "length") == "0.7"
    cylinder = "link[@name='base_link_inertia']/collision//cylinder"
    assert attribute(cylinder, "radius") == "0.08"
    interfaces = {element.text for element in robot.iter("hardwareInterface")}
    assert interfaces == {"hardware_interface/PositionJointInterface"}
    assert attribute(f"{lift}/safety_controller", "k_position") == "30"
    lower = float(str(attribute(f"{lift}/safety_controller", "soft_lower_limit")))
    assert lower == pytest.approx(float(str(attribute(f"{lift}/limit", "lower"))) + 0.2)


def test_a_description_of_ones_own_is_given_what_it_takes(
    catkin: Catkin, tmp_path: Path
) -> None:
    """Upstream's files take four arguments or eight, and ours passes more."""
    own = tmp_path / "load_mine.launch.xml"
    own.write_text(
        "<launch><arg name='kinematics_params'/>"
        "<param name='robot_description' value='mine: $(arg kinematics_params)'/>"
        "</launch>"
    )
    args = (f"robot_description_file:={own}", "kinematics_params:=k.yaml")
    assert catkin.parameters(*GAZEBO, *args)["/robot_description"] == "mine: k.yaml"


def test_the_controllers_are_those_of_the_program_but_for_the_gripper(
    catkin: Catkin,
) -> None:
    native = catkin.source / "tool0_gazebo" / "config"
    for is_action, other in (
        (False, "controllers.yaml"),
        (True, "controllers_gripper_action.yaml"),
    ):
        text = controllers_yaml(assemble(), gripper_action=is_action)
        program = yaml.safe_load(text)
        gazebo = yaml.safe_load((native / f"ur5_2f85_{other}").read_text())
        gripper, program_gripper = (
            each.pop("gripper_controller") for each in (gazebo, program)
        )
        gains = gripper["gains"]["finger_joint"]
        assert gazebo == program
        assert gripper["type"] == program_gripper["type"]
        # Gazebo's fingers have no rotor: see adr/0006.  A step of 1 ms bears no more.
        assert gains["d"] * 1e-3 / 5.0e-4 < 1.0


# --- RViz ---


@pytest.fixture
def screen() -> Iterator[Screen]:
    require_ros(rviz=True)
    if find_xvfb() is None:
        absent("ros1", "no Xvfb is installed")
    with Screen(1200, 800) as screen:
        yield screen


def test_the_view_shows_the_robot(
    catkin: Catkin, own_ros: Ros, screen: Screen, tmp_path: Path
) -> None:
    """Launched for real, but for the window of sliders: its Qt is not here."""

    def start() -> ChildProcess:
        return own_ros.spawn(  # without the simulated time of others
            *("roslaunch", *VIEW, "gui:=false"),
            **{k: catkin.environment[k] for k in ("PATH", "ROS_PACKAGE_PATH")},
            **variables(screen, tmp_path),
        )

    def shows_the_robot(pixels: Pixels) -> bool:
        world = view(pixels)
        return bool(blue(world).sum() > 400 and black(world).sum() > 600)

    launch, _ = shown(start, screen, shows_the_robot, TIMEOUT)
    launch.close()


# --- the gripper's controllers ---


@pytest.mark.parametrize("name", ["controllers_gripper_action", "controllers"])
def test_the_gripper_does_not_wind_up_against_what_it_holds(
    catkin: Catkin, name: str
) -> None:
    config = catkin.source / "tool0_gazebo" / "config"
    text = (config / f"ur5_2f85_{name}.yaml").read_text()
    gripper = yaml.safe_load(text)["gripper_controller"]
    gains = gripper["gains"]["finger_joint"]
    assert gains["i"] == 0
    if "goal_tolerance" in gripper:
        # The fingers' weight leaves 7 mrad, and ODE trembles where it holds something.
        assert gripper["goal_tolerance"] >= 0.01
        assert gripper["stall_velocity_threshold"] >= 0.1
