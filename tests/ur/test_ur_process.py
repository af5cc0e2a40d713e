"""The process of the UR interface: its start, its addresses, its death, its end."""

from __future__ import annotations

import os
import signal
import socket
from contextlib import closing
from pathlib import Path

import pytest
from processes import Watch, descendants, has_ended, listening, process_of
from ros import Bringup
from ur_address import free_host
from waits import until

import tool0
from tool0.ur.process import MODULE

DASHBOARD = 29999


def asked(host: str, question: str, port: int = DASHBOARD) -> str:
    """Return what the dashboard server answers."""
    with socket.create_connection((host, port), timeout=10.0) as connection:
        lines = connection.makefile("rw", newline="\n")
        assert lines.readline().startswith("Connected: ")
        lines.write(f"{question}\n")
        lines.flush()
        return lines.readline().strip()


def is_open(host: str, port: int = DASHBOARD) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex((host, port)) == 0


def test_it_starts_again_after_its_death_and_ends_with_a_bringup_that_is_killed() -> (
    None
):
    host = free_host()
    with closing(Bringup(os.environ, "--ur", "--ur-host", host)) as bringup:
        bringup.wait()
        (line,) = (line for line in bringup.lines if line.lstrip().startswith("UR:"))
        assert f"UR: {host}: RTDE, dashboard server, URScript; gripper: " in line
        first = process_of(MODULE, bringup.process.pid)
        assert first is not None
        octets = socket.inet_aton(host)[::-1].hex().upper()
        assert set(listening(first)["tcp"]) == {octets}
        assert asked(host, "robotmode") == "Robotmode: RUNNING"
        os.kill(first, signal.SIGKILL)
        bringup.wait_for("the UR interface ended with status -9; it starts again")
        until(lambda: is_open(host), "the dashboard server again")
        second = process_of(MODULE, bringup.process.pid)
        assert second not in (None, first)
        assert asked(host, "robotmode") == "Robotmode: RUNNING"
        watch = Watch(descendants(bringup.process.pid))
        bringup.process.kill()
        assert watch.all_ended(10.0)
        assert not is_open(host)


def test_a_port_in_use_ends_the_bringup_with_its_name() -> None:
    host = free_host()
    with socket.create_server((host, DASHBOARD)):
        with closing(Bringup(os.environ, "--ur", "--ur-host", host)) as bringup:
            assert bringup.wait_for_end() == 2
        assert f"cannot listen on {host}:{DASHBOARD}" in bringup.text
        assert "Address already in use" in bringup.text
        assert "Traceback" not in bringup.text


def test_each_robot_of_a_cell_has_an_address_and_a_shift_of_the_ports() -> None:
    host = free_host()
    options = tool0.UrOptions(host=host, port_base=1000)
    robots = ("left=ur5e+2f85@0,0.5,0", "right=ur3e@0,-0.5,0")
    with (
        tool0.bringup(description=tool0.DescriptionConfig(robots=robots)) as cell,
        tool0.UrController(cell, options) as controller,
    ):
        arms = controller.wait()
        assert list(arms) == ["left", "right"]
        left, right = arms.values()
        assert left.address == host
        last = socket.inet_aton(host)[3]
        assert socket.inet_aton(right.address)[3] == last + 1
        assert right.modbus_port is None
        assert left.modbus_port in (1502, 2502)
        assert left.serial_port is not None
        assert Path(left.serial_port).is_char_device()
        models = [
            asked(arm.address, "get robot model", DASHBOARD + 1000)
            for arm in (left, right)
        ]
        assert models == ["UR5", "UR3"]
        assert not is_open(host)
        pid = controller.pid
        assert pid is not None
    assert has_ended(pid, 0.0)
    assert not is_open(host, DASHBOARD + 1000)


def test_without_arms_there_is_no_box(tmp_path: Path) -> None:
    robot = tmp_path / "slide.urdf"
    robot.write_text(SLIDE)
    with (
        tool0.bringup(robot=robot) as bare,
        tool0.UrController(bare, tool0.UrOptions(host=free_host())) as controller,
        pytest.raises(tool0.TransportError, match="no arm"),
    ):
        controller.wait()


SLIDE = """
<robot name="slide">
  <link name="world"/>
  <link name="cart">
    <inertial>
      <mass value="1.0"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="rail" type="prismatic">
    <parent link="world"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="10"/>
  </joint>
  <transmission name="rail">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="rail">
      <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>
    </joint>
    <actuator name="rail_motor"><mechanicalReduction>1</mechanicalReduction></actuator>
  </transmission>
</robot>
"""
