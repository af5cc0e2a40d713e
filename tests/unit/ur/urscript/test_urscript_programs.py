"""Programs as students write them, on the control box of a simulated robot."""

from __future__ import annotations

import math
import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from served import serving, use_folder
from ur5_rig import BETWEEN_PADS, EDGE
from urscript_rig import PROGRAMS, BoxRig, Run, box_rig

import tool0
from tool0.description.scene import SceneObject
from tool0.description.shapes import Box
from tool0.description.transform import Pose
from tool0.protocol.control_box import SetIO

pytestmark = pytest.mark.slow

READY = (0.0, -1.2, 1.9, -2.2708, -1.5708, 0.0)  # [rad]
HOME = f"""
movej({list(READY)}, a=3, v=3)
set_tcp(p[0, 0, 0, 0, 0, 0])
rq_activate_and_wait()
"""
FAST = 4.0  # simulated seconds per wall second
CUBE = SceneObject(
    name="cube",
    geometry=Box(size=(EDGE, EDGE, EDGE)),
    pose=Pose(xyz=BETWEEN_PADS),
    mass=0.1,
)


def table(top: float) -> SceneObject:
    x, y, _ = BETWEEN_PADS
    return SceneObject(
        name="table",
        geometry=Box(size=(0.4, 0.6, 0.04)),
        pose=Pose(xyz=(x, y, top - 0.02)),
    )


@pytest.fixture(scope="module")
def robot() -> Iterator[tool0.Robot]:
    with tool0.bringup(initial_pose="ready", speed=FAST) as robot:
        yield robot


@pytest.fixture(scope="module")
def rig(
    robot: tool0.Robot, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[BoxRig]:
    with pytest.MonkeyPatch.context() as patch:
        use_folder(patch, tmp_path_factory.mktemp("run"))
        with serving(robot), box_rig() as rig:
            yield rig


@pytest.fixture
def at_home(rig: BoxRig) -> None:
    """Move the arm to a known pose."""
    assert rig.run(HOME).errors == []


def source(name: str, **words: object) -> str:
    text = (PROGRAMS / f"{name}.script").read_text()
    for word, value in words.items():
        text = text.replace(word, str(value))
    return text


def ran(rig: BoxRig, name: str, **words: object) -> Run:
    run = rig.run(source(name, **words))
    assert run.errors == []
    return run


@contextmanager
def answering(answer: Callable[[socket.socket], None]) -> Iterator[int]:
    """Serve one client in a thread; yield the port."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            client, _ = server.accept()
            with client:
                answer(client)

        thread = threading.Thread(target=serve)
        thread.start()
        yield server.getsockname()[1]
        thread.join(timeout=20.0)
        assert not thread.is_alive()


# ---- computing ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "texts"),
    [
        ("csv_strings", ["bolt M6[12.5, -3]", "length 7", "6M tlob"]),
        (
            "sorting",
            [
                "[0.07, 0.12, 0.2, 0.31, 0.55]",
                "[0.31, 0.12, 0.55, 0.07, 0.2]",
                "mean 0.25",
            ],
        ),
        (
            "state_machine",
            [
                "state1: wait",
                "state2: work",
                "again3: rework",
                "state2: work",
                "state1: done",
            ],
        ),
        (
            "tool_and_payload",
            [
                "p[0, 0.05, 0.1, 0, 0, 0]",
                "offset True",
                "1.5[0, 0, 0.06]",
                "0.9[0, 0, 0.06]",
                "1.2[0, 0, 0.05]",
                "[0, 0.05, 0.1]",
            ],
        ),
        (
            "analog",
            [
                "out 0.75",
                "tool True",
                "configurable True",
                "same pin True",
                "volts 0",
            ],
        ),
    ],
)
def test_a_program_without_motion(rig: BoxRig, name: str, texts: list[str]) -> None:
    assert ran(rig, name).texts == texts


def test_kinematics_agree_and_an_unreachable_pose_ends_the_program(
    rig: BoxRig,
) -> None:
    run = rig.run(source("kinematics"))
    assert run.texts == [
        "same joints True",
        "tool True",
        "reachable False",
        "reachable True",
        "identity True",
    ]
    (error,) = run.errors
    assert error.startswith("21:7: get_inverse_kin: no inverse kinematics solution")


# ---- motion -------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("at_home")
def test_palletizing(rig: BoxRig) -> None:
    places = [f"{row}/{column}True" for row in (0, 1) for column in (0, 1, 2)]
    assert ran(rig, "palletizing").texts == [*places, "placed 6", "back True"]


@pytest.mark.usefixtures("at_home")
def test_spiral_search(rig: BoxRig) -> None:
    points, radius, back = ran(rig, "spiral").texts[-3:]
    assert (points, back) == ("points 16", "back True")
    assert 25 <= int(radius.split()[-1]) <= 40  # 2 mm a turn, two turns [0.1 mm]


@pytest.mark.usefixtures("at_home")
def test_circle_of_two_arcs(rig: BoxRig) -> None:
    run = ran(rig, "circle")
    assert run.texts == ["half True", "closed True"]
    half = math.pi * 0.03 / 0.2 + 0.2 / 1.2  # [s]
    passed = run.time_of("closed True") - run.time_of("half True")
    assert half - 0.002 < passed < half + 1.0


@pytest.mark.slow
@pytest.mark.usefixtures("at_home")
def test_blends_return_early_and_save_time(rig: BoxRig) -> None:
    run = ran(rig, "blends")
    first = run.time_of("first corner") - run.time_of("start")
    edge = 0.06 / 0.2 + 0.2 / 1.2  # [s]
    assert edge - 0.002 < first < edge + 0.5
    blended = run.time_of("first corner", 1) - run.time_of("square")
    assert blended < edge - 0.05
    assert run.time_of("square") - run.time_of("start") > 4 * edge - 0.01


@pytest.mark.usefixtures("at_home")
def test_servo_follows_a_sine(rig: BoxRig) -> None:
    run = ran(rig, "servo_sine")
    assert run.texts == ["turned", "back True"]
    assert run.time_of("back True") > 1.0


@pytest.mark.slow
@pytest.mark.usefixtures("at_home")
def test_speeds_ramps_and_rest(rig: BoxRig) -> None:
    run = ran(rig, "jog")
    assert run.texts[0] == "speed [0, 0, 0, 0, 0, 0.5]"
    turned = int(run.texts[1].split()[-1])
    # 0.125 while speeding up, 0.15 at 0.5 rad/s, 0.125 while slowing down, with the
    # delays of four times real time
    assert 300 <= turned < 600
    assert run.texts[2:] == ["steady False", "steady True"]


@pytest.mark.usefixtures("at_home")
def test_a_lamp_blinks_while_the_arm_moves(rig: BoxRig) -> None:
    run = ran(rig, "blink")
    (text,) = run.texts
    moving = 2 * 2 * math.sqrt(0.2 / 1.0)  # [s], two triangular profiles
    assert 8 <= int(text.split()[-1]) <= 10 * run.duration + 1
    assert run.duration > moving
    assert not rig.box.state.digital_outputs[3]


def test_a_program_of_polyscope(rig: BoxRig) -> None:
    run = ran(rig, "polyscope")
    (popup,) = [item for item in run.messages if item.title]
    assert (popup.text, popup.title) == ("finished", "Message")
    assert rig.box.state.payload.mass == 0.9


# ---- others -------------------------------------------------------------------------


def test_handshake_by_digital_signals(rig: BoxRig, robot: tool0.Robot) -> None:
    seen: list[tuple[bool, bool]] = []
    box = rig.box

    def plc() -> None:
        ready, working = box.state.digital_outputs[:2]
        if not seen or seen[-1] != (ready, working):
            seen.append((ready, working))
        if ready and not box.state.digital_inputs[0]:
            box.send(SetIO(arm=box.arm, digital_inputs={0: True, 1: True}))

    box.when_updated.add(plc)
    try:
        run = ran(rig, "io_handshake")
    finally:
        box.when_updated.discard(plc)
    assert run.texts == ["ready", "part True", "done after starts: 1"]
    states = [(True, False), (False, False), (False, True), (False, False)]
    assert [state for state in seen if state in states][-4:] == states
    box.send(SetIO(arm=box.arm, digital_inputs={0: False, 1: False}))


def test_a_client_commands_by_registers(rig: BoxRig) -> None:
    box = rig.box
    answers: list[int] = []

    def client() -> None:
        registers = box.registers
        answer = registers.outputs.integers[25]
        if registers.outputs.bits[64] and len(answers) < 3:
            if answer == 100 * (len(answers) + 1):
                answers.append(answer)
            registers.inputs.integers[24] = min(len(answers) + 1, 3)

    box.registers.inputs.doubles[24] = 1.25
    box.when_updated.add(client)
    try:
        run = ran(rig, "client_registers")
    finally:
        box.when_updated.discard(client)
    assert run.texts == ["command 1", "command 2", "command 3"]
    assert answers[:2] == [100, 200]
    assert box.registers.outputs.doubles[24] == 2.5
    assert not box.registers.outputs.bits[64]


@pytest.mark.usefixtures("at_home")
def test_poses_from_a_socket(rig: BoxRig) -> None:
    received: list[str] = []

    def camera(client: socket.socket) -> None:
        with client.makefile("rw") as stream:
            for offset in ("0.02, 0, -0.01", "0.0,0.0,0.0"):
                received.append(stream.readline())
                stream.write(f"noise( {offset} )")
                stream.flush()
                received.append(stream.readline())
            received.append(stream.readline())
            client.recv(1)

    with answering(camera) as port:
        run = ran(rig, "socket_pose", PORT=port)
    assert received == ["offset?\n", "at 0\n", "offset?\n", "at 1\n", "bye\n"]
    assert run.texts == ["back True", "0nan", "False"]


def test_protocols_of_a_socket(rig: BoxRig) -> None:
    received: list[bytes] = []

    def server(client: socket.socket) -> None:
        stream = client.makefile("rb")
        received.append(stream.readline())
        client.sendall(b"SPEED 1500\n")
        received.append(stream.readline())
        received.append(stream.read(4))
        client.sendall(struct.pack(">ii", 100, -2000))
        client.sendall(bytes([1, 2, 255]) + b"a line\r\n")
        client.sendall(b"..>hello<...>wor")
        client.sendall(b"ld<last\nrest")
        stream.read()

    with answering(server) as port:
        run = ran(rig, "socket_protocols", PORT=port)
    assert received == [b"GET SPEED\n", b"SET COUNT 7\n", struct.pack(">i", -2)]
    assert run.texts == [
        "speed 1500",
        "[2, 100, -2000]",
        "[3, 1, 2, 255]",
        "a line",
        "helloworld",
        "last",
        "|",
    ]


@pytest.mark.slow
@pytest.mark.usefixtures("at_home")
def test_down_until_contact(rig: BoxRig, robot: tool0.Robot) -> None:
    robot.scene.add(table(BETWEEN_PADS[2] - 0.045))
    try:
        run = ran(rig, "until_contact")
    finally:
        robot.scene.remove("table")
    contact, down, wrench = run.texts
    assert contact == "contact True"
    assert 5 < int(down.split()[-1]) < 60
    assert wrench == "pushes up True"


@pytest.mark.slow
@pytest.mark.usefixtures("at_home")
def test_force_mode_presses_on_a_table(rig: BoxRig, robot: tool0.Robot) -> None:
    robot.scene.add(table(BETWEEN_PADS[2] - 0.045))
    try:
        run = ran(rig, "force_mode")
    finally:
        robot.scene.remove("table")
    force, sliding, after = run.texts
    assert int(force.split()[-1]) == pytest.approx(20, abs=1)
    assert sliding == "while sliding True"
    assert int(after.split()[-1]) == pytest.approx(20, abs=1)


@pytest.mark.slow
@pytest.mark.usefixtures("at_home")
def test_pick_and_place(rig: BoxRig, robot: tool0.Robot) -> None:
    robot.scene.add(table(BETWEEN_PADS[2] - EDGE / 2))
    robot.scene.add(CUBE)
    try:
        run = ran(rig, "pick_loop")
        assert run.texts == [
            "picked in cycle 0",
            "held True",
            "picked in cycle 1",
            "held True",
            "cycles 2",
        ]
        x, y, z = robot.scene["cube"].pose.xyz
        assert (x, y, z) == pytest.approx(BETWEEN_PADS, abs=0.01)
    finally:
        robot.scene.remove("cube")
        robot.scene.remove("table")


# ---- the interpreter mode -----------------------------------------------------------


def test_a_move_is_aborted(rig: BoxRig, at_home: None) -> None:
    box = rig.box
    replies: list[str] = []

    async def abort_when_it_moves() -> None:
        await box.until(lambda: max(map(abs, box.qd)) > 0.05)
        assert box.interpreter is not None
        box.interpreter.submit("abort", replies.append)

    task = rig.start(abort_when_it_moves())
    run = rig.run("movej([1.5, -1.2, 1.9, -2.2708, -1.5708, 0.0], v=0.2)\nstopj(2)")
    task.result(20.0)
    assert (run.errors, replies) == ([], ["ack: 0: abort"])
    assert rig.box.q[0] < 1.0


def test_forces_of_a_client_replace_those_of_the_wrist(
    rig: BoxRig, at_home: None
) -> None:
    box = rig.box
    box.rtde_sensor.read((0.0, 0.0, 20.0, 0.0, 0.0, 0.0))
    run = rig.run(
        """
        textmsg(force() < 5)
        ft_rtde_input_enable(True, 0.5, [0, 0, 0.05])
        f = get_tcp_force()
        textmsg(norm([f[0], f[1], f[2]]))
        textmsg(force())
        zero_ftsensor()
        textmsg(force())
        ft_rtde_input_enable(False)
        textmsg(force() < 5)
        """
    )
    assert (run.errors, run.texts) == ([], ["True", "20", "20", "0", "True"])


def test_the_target_of_a_move_is_told(rig: BoxRig, at_home: None) -> None:
    run = rig.run(
        """
        goal = pose_trans(get_target_tcp_pose(), p[0, 0, 0.05, 0, 0, 0])
        movel(goal)
        textmsg(pose_dist(goal, get_target_waypoint()) < 0.001)
        textmsg(pose_dist(tool_pose(), get_actual_tcp_pose()) < 0.001)
        """
    )
    assert (run.errors, run.texts) == ([], ["True", "True"])


def test_a_screw_driver_pushes_along_its_axis(rig: BoxRig, at_home: None) -> None:
    run = rig.run(
        """
        start = get_actual_tcp_pose()
        screw_driving(10, 0.05)
        sleep(1)
        end_screw_driving()
        way = pose_trans(pose_inv(start), get_actual_tcp_pose())
        textmsg(way[2] > 0.01)
        textmsg(way[2] < 0.06)
        textmsg(norm([way[0], way[1]]) < 0.005)
        """
    )
    assert (run.errors, run.texts) == ([], ["True"] * 3)
