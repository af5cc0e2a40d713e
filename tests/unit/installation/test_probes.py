"""What `tool0 doctor` finds on machines of all kinds."""

import os
from pathlib import Path

import pytest
from machine import add_gazebo_header, add_program, make_machine

from tool0.errors import RosUnavailableError
from tool0.installation.doctor import probes
from tool0.installation.doctor.probes import _LAUNCHED_PACKAGES, gazebo, ros1, ros2
from tool0.installation.doctor.report import ProbeResult
from tool0.installation.gazebo.installation import NAMED_BY
from tool0.installation.machine import Machine
from tool0.installation.ros1.packages import Ros1Status
from tool0.installation.ros2.installation import Ros2
from tool0.installation.ros2.status import Ros2Status

# --- GPUs ---


def gpu(root: Path) -> ProbeResult:
    (result,) = probes.gpu(make_machine(root))
    return result


def test_a_gpu_is_not_needed(tmp_path: Path) -> None:
    result = gpu(tmp_path)
    assert (result.state, result.remedy) == ("missing", "")


def test_nvidia_cards_are_read_without_running_a_program(tmp_path: Path) -> None:
    add_program(tmp_path / "bin/nvidia-smi", "exec sleep 1000")
    card = tmp_path / "proc/driver/nvidia/gpus/0000:01:00.0/information"
    card.parent.mkdir(parents=True)
    card.write_text("Model: \t\t NVIDIA H200\nIRQ:   \t\t 190\n")
    (tmp_path / "proc/driver/nvidia/version").write_text(
        "NVRM version: NVIDIA UNIX x86_64 Kernel Module  550.54.15  Tue Mar  5\n"
    )
    assert gpu(tmp_path).found == "NVIDIA H200, driver 550.54.15"


def test_nvidia_smi_is_run_where_there_are_no_files(tmp_path: Path) -> None:
    add_program(tmp_path / "bin/nvidia-smi", "echo 'NVIDIA H200, 550.54.15'")
    assert gpu(tmp_path).found == "NVIDIA H200, driver 550.54.15"
    add_program(tmp_path / "bin/nvidia-smi", "echo NVIDIA-SMI has failed; exit 9")
    assert gpu(tmp_path).state == "missing"


def test_a_driver_that_hangs_is_unknown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tool0.installation.doctor.probes.PROGRAM_TIMEOUT", 0.2)
    add_program(tmp_path / "bin/nvidia-smi", "exec /bin/sleep 1000")
    result = gpu(tmp_path)
    assert result.state == "unknown"
    assert "nvidia-smi" in result.found


def test_render_nodes_are_listed_with_their_vendor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for node, vendor in (("renderD128", "0x8086"), ("renderD129", "0x1af4")):
        (tmp_path / "dev/dri").mkdir(parents=True, exist_ok=True)
        (tmp_path / "dev/dri" / node).touch()
        file = tmp_path / "sys/class/drm" / node / "device/vendor"
        file.parent.mkdir(parents=True)
        file.write_text(f"{vendor}\n")
    result = gpu(tmp_path)
    assert (result.state, result.remedy) == ("ready", "")
    assert result.found.startswith("Intel (")
    assert ", a GPU (" in result.found
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may do anything
    assert "usermod -aG render" in gpu(tmp_path).remedy


# --- Gazebo ---


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Name a root that has no Gazebo, on a machine without a compiler."""
    monkeypatch.setenv(NAMED_BY, str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.delenv("CXX", raising=False)
    add_program(tmp_path / "bin/apt-get")
    return tmp_path


def test_what_gazebo_lacks_has_a_remedy(root: Path) -> None:
    examined = Machine(system="linux")
    (result,) = gazebo(examined)
    assert (result.state, result.remedy) == ("missing", "tool0 gazebo install --gui")
    add_gazebo_header(root, "11.10.2")
    add_program(root / "bin/gzserver")
    (result,) = gazebo(examined)
    assert (result.state, result.remedy) == ("missing", "sudo apt install g++")
    add_program(root / "bin/g++")
    engine, window = gazebo(examined)
    assert engine.state == "ready"
    assert engine.found.startswith("11.10.2, the system's, ")
    assert window.remedy == "tool0 gazebo install --gui --private"
    add_program(root / "bin/gzclient")
    _, window = gazebo(examined)
    assert (window.state, window.found) == ("ready", str(root / "bin/gzclient"))
    (result,) = gazebo(Machine(system="darwin"))
    assert result.state == "not supported"


# --- ROS ---

NEEDED = {"rospy": ("rospy", "rosgraph"), "messages": ("genpy", "genmsg", "std_msgs")}
ROS1 = "tool0.installation.ros1"
ROS2 = "tool0.installation.ros2"
REMEDY = "tool0 ros1 install --rviz"


def with_ros1(patch: pytest.MonkeyPatch, status: Ros1Status) -> list[ProbeResult]:
    patch.setattr(f"{ROS1}.packages.ros1_status", lambda: status)
    return ros1(Machine(environ={"PATH": ""}))


def with_ros2(
    monkeypatch: pytest.MonkeyPatch, found: Ros2 | None, **missing: str
) -> ProbeResult:
    remedies = (REMEDY,) if missing or found is None else ()
    status = Ros2Status(
        ros2=found,
        rclpy="9.1.2",
        rmw="rmw_fastrtps_cpp",
        missing=missing,
        remedies=remedies,
    )
    monkeypatch.setattr(f"{ROS2}.status.ros2_status", lambda: status)
    (result,) = ros2(Machine())
    return result


def test_ros_2_is_found_or_can_be_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    found = Ros2(
        kind="system",
        distro="jazzy",
        prefix=Path("/opt/ros/jazzy"),
        python=Path("/usr/bin/python3.12"),
        environment={},
    )
    result = with_ros2(monkeypatch, found)
    assert (result.state, result.remedy) == ("ready", "")
    assert "jazzy, the system's, rclpy 9.1.2, rmw_fastrtps_cpp" in result.found
    result = with_ros2(monkeypatch, found, control_msgs="no such module")
    assert (result.state, result.remedy) == ("missing", REMEDY)
    assert "without control_msgs" in result.found
    result = with_ros2(monkeypatch, found, ur_msgs="no such module")
    assert (result.state, result.remedy) == ("ready", REMEDY)
    monkeypatch.setattr(f"{ROS2}.install.why_not_installable", lambda: None)
    result = with_ros2(monkeypatch, None)
    assert (result.state, result.remedy) == ("missing", "tool0 ros2 install")
    monkeypatch.setattr(f"{ROS2}.install.why_not_installable", lambda: "the reason")
    result = with_ros2(monkeypatch, None)
    assert (result.state, result.remedy) == ("not supported", "")
    assert "the reason" in result.found


def test_ros_1_is_installed_where_it_is_packaged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(f"{ROS1}.install.plan_install", lambda rviz: None)
    (result,) = with_ros1(monkeypatch, Ros1Status(master="", missing=NEEDED))
    assert (result.what, result.state) == ("ros1", "missing")
    assert "rospy, rosgraph, genpy, genmsg, …" in result.found
    assert result.remedy == REMEDY


def test_where_ros_1_cannot_be_installed_the_reason_is_reported(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def plan(rviz: bool) -> None:
        raise RosUnavailableError("the reason")

    monkeypatch.setattr(f"{ROS1}.install.plan_install", plan)
    status = Ros1Status(master="", missing=NEEDED)
    monkeypatch.setattr(f"{ROS1}.packages.ros1_status", lambda: status)
    for release, state in ((BOOKWORM, "missing"), (NOBLE, "not supported")):
        (result,) = ros1(make_machine(tmp_path, release=release))
        assert (result.state, result.found) == (state, "the reason")


def test_what_ros_1_can_run_without_has_results_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    status = Ros1Status(
        rospy=Path("/r/rospy"),
        version="1.15",
        source="the distribution's",
        master="http://localhost:11311",
        missing={"tf2": ("tf2_ros",), "rviz": ("rviz",)},
        remedies=(REMEDY,),
    )
    main, tools, rviz = with_ros1(monkeypatch, status)
    assert main.state == "ready"
    assert "1.15, the distribution's" in main.found
    assert "--roscore" in main.found
    assert (tools.state, tools.found, tools.remedy) == ("missing", "tf2", REMEDY)
    assert (rviz.state, rviz.remedy) == ("missing", REMEDY)
    status = Ros1Status(rospy=Path("/r"), master="http://x:1", is_master_up=True)
    results = with_ros1(monkeypatch, status)
    assert [result.state for result in results] == ["ready"] * 3
    assert "http://x:1 answers" in results[0].found


# --- the workspace ---

BOOKWORM = "PRETTY_NAME='Debian 12'\nVERSION_CODENAME=bookworm\n"
FOCAL = "PRETTY_NAME='Ubuntu 20.04'\nVERSION_CODENAME=focal\n"
NOBLE = "PRETTY_NAME='Ubuntu 24.04'\nVERSION_CODENAME=noble\n"


def look(root: Path, release: str, *programs: str) -> tuple[ProbeResult, ProbeResult]:
    examined = make_machine(root, "apt-get", *programs, release=release)
    catkin, native = probes.workspace(examined)
    return catkin, native


def add_packages(prefix: Path, *names: str) -> None:
    for name in names:
        manifest = prefix / "share" / name / "package.xml"
        manifest.parent.mkdir(parents=True)
        manifest.touch()


@pytest.mark.parametrize(
    ("release", "programs", "state", "remedy"),
    [
        (BOOKWORM, (), "missing", "sudo apt install catkin cmake make"),
        (BOOKWORM, ("make",), "missing", "sudo apt install catkin cmake"),
        (NOBLE, ("catkin_make", "make"), "missing", "sudo apt install cmake"),
        (NOBLE, ("cmake", "make"), "not supported", ""),
        (NOBLE, ("catkin_make", "cmake", "make"), "ready", ""),
    ],
)
def test_the_build_tools_are_installed_where_they_are_packaged(
    tmp_path: Path, release: str, programs: tuple[str, ...], state: str, remedy: str
) -> None:
    catkin, _ = look(tmp_path, release, *programs)
    assert (catkin.state, catkin.remedy) == (state, remedy)


def test_a_noetic_is_to_be_sourced(tmp_path: Path) -> None:
    setup = tmp_path / "opt/ros/noetic/setup.bash"
    setup.parent.mkdir(parents=True)
    setup.touch()
    catkin, _ = look(tmp_path, FOCAL, "cmake", "make")
    assert catkin.remedy == f"source {setup}"


def test_what_a_noetic_lacks_is_installed_by_its_names(tmp_path: Path) -> None:
    noetic = tmp_path / "opt/ros/noetic"
    missing = {"gazebo_ros_control", "rqt_joint_trajectory_controller"}
    add_packages(noetic, *(set(_LAUNCHED_PACKAGES) - missing))
    _, native = look(tmp_path, FOCAL)
    assert native.state == "missing"
    assert native.remedy == (
        "sudo apt install ros-noetic-gazebo-ros-control "
        "ros-noetic-rqt-joint-trajectory-controller"
    )
    add_packages(noetic, *missing)
    _, native = look(tmp_path, FOCAL)
    assert native.state == "ready"
    assert native.found.startswith(str(noetic))


@pytest.mark.parametrize(
    ("release", "state", "remedy"),
    [
        (FOCAL, "missing", "sudo apt install ros-noetic-desktop-full"),
        (BOOKWORM, "not supported", ""),
    ],
)
def test_noetic_is_for_ubuntu_20_04_alone(
    tmp_path: Path, release: str, state: str, remedy: str
) -> None:
    _, native = look(tmp_path, release)
    assert (native.state, native.remedy) == (state, remedy)
