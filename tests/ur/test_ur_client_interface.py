"""The primary, secondary and real-time interface, with plain sockets and urx."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from ur_packets import Packets, unpack
from ur_rig import UrRig, ur_rig
from waits import until

from tool0.protocol.control_box import SetIO, SetTcp, StopProtectively

HOME = (0.3, -1.6, 1.8, -1.7, -1.5, 0.2)
TCP = (0.01, 0.02, 0.1, 0.0, 0.0, 0.5)
SWAY = 0.02
"""Of the arm right after a motion [rad]."""
SPEED = 4.0
"""Of time."""
SLOW = 0.25
"""Of time, where no update may be left out for want of a processor."""
PRIMARY, SECONDARY, REALTIME, INTERPRETER = 30001, 30002, 30003, 30020


@pytest.fixture(scope="module")
def rig() -> Iterator[UrRig]:
    with ur_rig(speed=SPEED) as rig:
        yield rig


@pytest.fixture
def clients(rig):
    """Connects to ports, and leaves them at the end."""
    connections = []

    def connect(port: int) -> Packets:
        connections.append(rig.connect(port))
        return Packets(connections[-1])

    yield connect
    for connection in connections:
        connection.close()
    dashboard = rig.dashboard()
    dashboard.ask("stop")
    dashboard.close()


@pytest.fixture
def still(rig):
    """The robot while time does not pass, with pins, payload and a tool."""
    rig.robot.arm.control_box.set_payload(1.5, (0.0, 0.01, 0.05))
    call = rig.robot.channel.call
    call(SetIO(digital_outputs={0: True, 9: True}, digital_inputs={2: True}))
    call(SetTcp(pose=TCP))
    rig.robot.pause()
    yield rig.robot
    rig.robot.resume()
    rig.robot.arm.control_box.clear_payload()


def first(read: Callable[[], dict[str, Any]], is_it: Callable[[Any], bool]) -> Any:
    """Return the first packet of those that arrive that is wanted."""
    packet: dict[str, Any] = {}

    def has_come() -> bool:
        nonlocal packet
        packet = read()
        return is_it(packet)

    until(has_come, "a packet", period=0.0)
    return packet


def is_output_on(values: dict[str, Any], pin: int) -> bool:
    return bool(int(values["digital_outputs"]) & 1 << pin)


def matrix(pose) -> np.ndarray:
    """Return a pose with a rotation vector as a matrix."""
    angle = float(np.linalg.norm(pose[3:]))
    x, y, z = np.divide(pose[3:], angle or 1.0)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    T = np.eye(4)
    T[:3, :3] += np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    T[:3, 3] = pose[:3]
    return T


def true_tcp(robot) -> np.ndarray:
    """Return the pose of the TCP in UR's base frame."""
    return robot.pose("tool0", "base").matrix @ matrix(TCP)


def positions(robot) -> list[float]:
    return list(robot.arm.joints.values())


@pytest.mark.parametrize("port", [PRIMARY, SECONDARY, 30011, 30012])
def test_a_version_and_a_complete_state_come_first(clients, port):
    packets = clients(port)
    kind, version = next(packets.messages())
    assert kind == "version"
    assert (version["name"], version["major"], version["minor"]) == ("URControl", 5, 25)
    state = next(packets.states())
    assert {"kinematics", "configuration"} <= set(state)
    assert {"kinematics", "configuration"}.isdisjoint(next(packets.states()))


def test_sub_packages_have_the_sizes_of_a_ur5e(clients):
    state = next(clients(PRIMARY).states())
    sizes = {name[:-5]: size for name, size in state.items() if name.endswith("_size")}
    assert sizes == {  # of a state of UR's own simulator, 5.8
        "mode": 47,
        "cartesian": 101,
        "kinematics": 225,
        "masterboard": 75,
        "tool": 37,
        "configuration": 445,
        "force": 61,
        "additional": 9,
        "connection": 26,
        "tool_mode": 8,
    }


def test_the_state_is_that_of_the_robot(clients, still):
    now = round(still.time * 1e9)
    states = clients(SECONDARY).states()
    state = first(states.__next__, lambda s: s["mode"]["timestamp"] == now)
    q = positions(still)
    assert [joint["q_actual"] for joint in state["joints"]] == pytest.approx(
        q, abs=1e-9
    )
    assert [joint["mode"] for joint in state["joints"]] == [253] * 6
    pose = [state["cartesian"][k] for k in ("X", "Y", "Z", "Rx", "Ry", "Rz")]
    np.testing.assert_allclose(matrix(pose), true_tcp(still), atol=1e-9)
    offset = [state["cartesian"][k] for k in ("x", "y", "z", "rx", "ry", "rz")]
    assert offset == pytest.approx(TCP)
    board = state["masterboard"]
    assert (board["inputs"], board["outputs"]) == (0b100, 0b10_0000_0001)
    assert (board["safety_mode"], board["reduced"]) == (1, 0)
    mode = state["mode"]
    assert mode["robot_mode"] == 7
    assert mode["power_on"]
    assert not mode["program_running"]
    assert not mode["protective_stopped"]


def test_the_kinematics_are_those_of_a_ur5e(clients):
    """Nominal parameters as UR publishes them."""
    kinematics = next(clients(PRIMARY).states())["kinematics"]
    assert kinematics["a"] == pytest.approx((0, -0.425, -0.3922, 0, 0, 0), abs=1e-6)
    assert kinematics["d"] == pytest.approx(
        (0.1625, 0, 0, 0.1333, 0.0997, 0.0996), abs=1e-6
    )
    assert kinematics["checksum"] == (0xFFFFFFFF,) * 6


def test_the_real_time_packet_is_that_of_the_robot(clients, still):
    packets = clients(REALTIME)
    values = first(packets.realtime, lambda v: v["time"] == still.time)
    assert values["q_actual"] == pytest.approx(positions(still), abs=1e-9)
    np.testing.assert_allclose(
        matrix(values["tool_vector"]), true_tcp(still), atol=1e-9
    )
    assert values["robot_mode"] == 7.0
    assert values["joint_modes"] == (253.0,) * 6
    assert values["safety_mode"] == values["safety_status"] == 1.0
    assert values["digital_inputs"] == 0b100
    assert values["digital_outputs"] == 0b10_0000_0001
    assert values["speed_scaling"] == 1.0
    assert values["payload_mass"] == 1.5
    assert values["payload_cog"] == (0.0, 0.01, 0.05)
    assert np.linalg.norm(values["accelerometer"]) == pytest.approx(9.81, abs=0.01)


def test_every_update_is_sent_in_real_time(rig, clients):
    rig.robot.set_speed(1.0)
    packets = clients(REALTIME)
    times = [packets.realtime()["time"] for _ in range(100)]
    rig.robot.set_speed(SPEED)
    periods = np.diff(times)
    assert (periods > 0.0).all()
    assert np.median(periods) == pytest.approx(0.002, abs=1e-9)


def test_the_state_comes_ten_times_a_second(rig, clients):
    rig.robot.set_speed(1.0)
    states = clients(PRIMARY).states()
    times = [next(states)["mode"]["timestamp"] for _ in range(12)]
    rig.robot.set_speed(SPEED)
    assert np.median(np.diff(times[1:])) == pytest.approx(0.1e9, rel=0.1)


def test_a_program_runs_and_is_announced(rig, clients):
    packets = clients(PRIMARY)
    messages = packets.messages()
    next(messages)  # the version
    script = (
        'def hello():\n  textmsg("hello ", 7)\n  popup("done?", "Question")\n'
        f"  movej({list(HOME)}, a=3, v=2)\nend\n"
    )
    for piece in (script[:20], script[20:]):
        packets.connection.sendall(piece.encode())
    kind, started = next(messages)
    assert (kind, started["title"], started["text"]) == (
        "key",
        "PROGRAM_XXX_STARTED",
        "hello",
    )
    assert next(messages)[1]["text"] == "hello 7"
    kind, popup = next(messages)
    assert (kind, popup["title"], popup["text"]) == ("popup", "Question", "done?")
    assert next(messages)[1]["title"] == "PROGRAM_XXX_STOPPED"
    assert positions(rig.robot) == pytest.approx(HOME, abs=SWAY)


def test_an_error_has_its_place_and_nothing_moves(rig, clients):
    primary, secondary = clients(PRIMARY), clients(SECONDARY)
    messages = primary.messages()
    next(messages)
    before = positions(rig.robot)
    secondary.connection.sendall(b"def bad():\n  movej([0,0,0,0,0,0])\n  jump()\nend\n")
    kind, said = next(messages)
    assert (kind, said["text"]) == ("text", "unknown function 'jump'")
    kind, error = next(messages)
    assert (kind, error["line"]) == ("exception", 3)
    assert error["text"] == "compile_error_name_not_found:jump:"
    assert positions(rig.robot) == pytest.approx(before, abs=SWAY)


def test_lines_replace_each_other_and_secondary_programs_do_not(rig, clients):
    packets = clients(REALTIME)
    box = rig.robot.arm.control_box
    packets.connection.sendall(b"def loop():\n  while True:\n    sync()\n  end\nend\n")
    first(packets.realtime, lambda v: v["program_state"] == 2.0)
    packets.connection.sendall(b"sec lamp():\n  set_digital_out(5, True)\nend\n")
    first(packets.realtime, lambda v: is_output_on(v, 5))
    assert packets.realtime()["program_state"] == 2.0
    assert box.state.taken_by == "loop"
    packets.connection.sendall(b"set_digital_out(6, True)\n")
    first(packets.realtime, lambda v: is_output_on(v, 6))
    first(packets.realtime, lambda v: v["program_state"] == 1.0)


def test_read_only_ports_take_no_programs(rig, clients):
    clients(30013).connection.sendall(b"set_digital_out(7, True)\n")
    packets = clients(REALTIME)
    packets.connection.sendall(b"set_digital_out(4, True)\n")
    first(packets.realtime, lambda v: is_output_on(v, 4))
    assert not is_output_on(packets.realtime(), 7)


def test_commands_of_ur_client_library(rig, clients):
    """It powers the arm and unlocks stops by lines that are no URScript."""
    packets = clients(PRIMARY)
    states = packets.states()

    def send_until(line: str, **expected: object) -> None:
        packets.connection.sendall(f"{line}\n".encode())
        first(states.__next__, lambda s: expected.items() <= s["mode"].items())

    send_until("power off", robot_mode=3)
    send_until("power on", robot_mode=5)
    send_until("set robotmode run", robot_mode=7)
    send_until("def f():\n  while True:\n    sync()\n  end\nend", program_running=True)
    send_until("stop program", program_running=False)


def test_safety_modes_are_announced(rig, clients):
    packets = clients(PRIMARY)
    messages = packets.messages()
    next(messages)
    rig.robot.channel.call(StopProtectively(reason="a test"))
    kind, safety = next(messages)
    assert (kind, safety["mode"]) == ("safety", 3)
    kind, error = next(messages)
    assert (kind, error["code"]) == ("error", 209)
    assert next(packets.states())["mode"]["protective_stopped"]
    dashboard = rig.dashboard()
    dashboard.until("safetymode", "Safetymode: PROTECTIVE_STOP")
    dashboard.until("unlock protective stop", "Protective stop releasing")
    dashboard.close()
    assert next(messages)[1]["mode"] == 1


def test_too_long_programs_end_the_connection(clients):
    messages = clients(PRIMARY).messages()
    next(messages)
    sender = clients(30003).connection

    def send() -> None:
        with contextlib.suppress(OSError):  # it is hung up on
            while True:
                sender.sendall(b"x" * 4096)

    thread = threading.Thread(target=send)
    thread.start()
    kind, error = next(messages)
    thread.join()
    assert kind == "error"
    assert "a line has more than 65536 bytes" in error["text"]


def test_a_cb3_has_its_layout_and_rate():
    with ur_rig(arm="ur5", gripper=None, speed=SLOW) as rig:
        connection = rig.connect(PRIMARY)
        packets = Packets(connection)
        _, version = next(packets.messages())
        assert (version["major"], version["minor"], version["bugfix"]) == (3, 15, 8)
        state = next(packets.states())
        assert (state["masterboard_size"], state["additional_size"]) == (75, 7)
        connection.close()
        connection = rig.connect(REALTIME)
        packets = Packets(connection)
        times = [packets.realtime()["time"] for _ in range(20)]
        assert np.median(np.diff(times)) == pytest.approx(0.008, abs=1e-9)
        connection.close()


def runs_a_program(robot) -> None:
    """Wait until urx knows of a program, and then of its end."""

    def is_running() -> bool:
        robot.secmon.wait(5.0)
        return robot.is_program_running()

    until(is_running, "a program", period=0.0)
    until(lambda: not is_running(), "its end", period=0.0)


@pytest.mark.filterwarnings("ignore:notifyAll:DeprecationWarning")
def test_urx_reads_and_moves_the_arm(rig):
    """As it is published, urx takes an arm with 3.5 or later for one that is off."""
    from urx.urrobot import URRobot

    robot = URRobot(rig.host)
    try:
        assert robot.getj() == pytest.approx(positions(rig.robot), abs=1e-3)
        target = np.array(HOME) + 0.2
        robot.movej(list(target), acc=3.0, vel=2.0, wait=False)
        runs_a_program(robot)
        assert robot.getj(wait=True) == pytest.approx(target, abs=SWAY)
        pose = robot.getl(wait=True)
        pose[2] += 0.05
        robot.movel(pose, acc=1.0, vel=0.5, wait=False)
        runs_a_program(robot)
        assert robot.getl(wait=True)[:3] == pytest.approx(pose[:3], abs=SWAY)
        box = rig.robot.arm.control_box  # urx reads outputs of older packets
        robot.set_digital_out(3, True)
        until(lambda: box.state.digital_outputs[3], "output 3 is on")
        robot.set_digital_out(3, False)
        until(lambda: not box.state.digital_outputs[3], "output 3 is off")
    finally:
        robot.close()


def test_the_reader_of_these_tests_reads_a_value():
    assert unpack("a:d b:2i", b"\x3f\xf0" + bytes(6) + b"\0\0\0\1\0\0\0\2") == (
        {"a": 1.0, "b": (1, 2)},
        b"",
    )


def test_statements_of_the_interpreter_mode_move_the_arm(rig: UrRig) -> None:
    with (
        contextlib.closing(rig.connect(SECONDARY)) as sender,
        contextlib.closing(rig.connect(INTERPRETER)) as client,
        client.makefile("r") as replies,
    ):
        sender.sendall(b"def f():\n  interpreter_mode(False)\nend\n")

        def ask(line: str) -> str:
            client.sendall(f"{line}\n".encode())
            return replies.readline().strip()

        until(lambda: ask("x = 0.2").startswith("ack"), "the interpreter mode")
        line = f"goal = {list(HOME)} goal[5] = x + 0.1 movej(goal, a=3, v=3)"
        assert ask(line).startswith("ack: ")
        ask("end_interpreter()")
        ended = "state: 0: statelastexecuted"
        until(lambda: ask("statelastexecuted") == ended, "the end of the program")
    position = rig.robot.joint_state.position
    assert position["wrist_3_joint"] == pytest.approx(0.3, abs=SWAY)
