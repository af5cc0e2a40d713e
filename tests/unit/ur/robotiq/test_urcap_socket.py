"""The URCap's socket, as robotiq_gripper.py, ur_rtde and URScript speak to it."""

from __future__ import annotations

import random
import socket
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from robotiq_rig import LONG, ServedGripper, serving_gripper
from waits import until

import tool0
from tool0.devices.robotiq_registers import Activation
from tool0.ur.listening import MAX_CLIENTS
from tool0.ur.robotiq.urcap import MAX_LINE, PORT, answer


class Client:
    """What robotiq_gripper.py does: one request, one answer, of one ``recv``."""

    def __init__(self, host: str) -> None:
        self.socket = socket.create_connection((host, PORT), timeout=LONG)

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def ask(self, text: str) -> str:
        self.socket.sendall(text.encode())
        return self.socket.recv(1024).decode()

    def get(self, name: str) -> int:
        echo, value = self.ask(f"GET {name}\n").split()
        assert echo == name
        return int(value)

    def set(self, **variables: int) -> bool:
        pairs = "".join(f" {name} {value}" for name, value in variables.items())
        return self.ask(f"SET{pairs}\n") == "ack"

    def wait_for(self, name: str, *values: int) -> int:
        found = -1

        def has_it() -> bool:
            nonlocal found
            found = self.get(name)
            return found in values

        until(has_it, lambda: f"{name} in {values}, last {found}", period=0.0)
        return found

    def activate(self) -> None:
        def is_reset() -> bool:
            if self.get("ACT") == self.get("STA") == 0:
                return True
            assert self.set(ACT=0)
            assert self.set(ATR=0)
            return False

        until(is_reset, "the gripper is reset", period=0.0)
        assert self.set(ACT=1)
        self.wait_for("STA", 3)
        assert self.get("ACT") == 1

    def move_and_wait(self, position: int, speed: int, force: int) -> tuple[int, int]:
        assert self.set(POS=position, SPE=speed, FOR=force, GTO=1)
        self.wait_for("PRE", position)
        met = self.wait_for("OBJ", 1, 2, 3)
        return self.get("POS"), met


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedGripper]:
    folder: Path = tmp_path_factory.mktemp("robotiq")
    with (
        tool0.bringup(initial_pose="ready", speed=4.0) as robot,
        serving_gripper(robot, folder) as served,
    ):
        yield served


@pytest.fixture
def client(served: ServedGripper) -> Iterator[Client]:
    with Client(served.host) as client:
        yield client


@pytest.mark.slow
def test_a_client_activates_and_moves_it(client: Client) -> None:
    client.activate()
    assert client.move_and_wait(255, 255, 1) == (230, 3)
    assert client.move_and_wait(0, 255, 1) == (3, 3)
    position, met = client.move_and_wait(100, 255, 255)
    assert position == pytest.approx(100, abs=1)
    assert met == 3
    assert [client.get(name) for name in ("SPE", "FOR", "GTO", "FLT")] == [
        *(255, 255, 1, 0)
    ]


def test_clients_share_the_gripper(client: Client, served: ServedGripper) -> None:
    with Client(served.host) as other:
        assert client.set(SPE=17)
        assert other.get("SPE") == 17


def test_variables_without_a_newline_are_answered_by_their_value(
    client: Client,
) -> None:
    assert client.set(POS=7, FOR=255)
    answers = [client.ask(f"GET {name}") for name in ("PRE", "FOR", "FLT", "OBJ")]
    assert [len(text) for text in answers] == [3, 3, 2, 1]
    assert answers[:3] == ["007", "255", "00"]
    assert client.get("PRE") == 7


@pytest.mark.slow
def test_an_emergency_release_is_that_of_ur_rtde(client: Client) -> None:
    client.activate()
    assert client.set(GTO=0)
    opens = 0
    assert all(client.set(**{name: n}) for name, n in (("ARD", opens), ("ATR", 1)))
    client.wait_for("FLT", 0x0F)
    assert client.get("POS") == 3
    assert client.get("STA") == 0
    client.activate()
    assert client.get("FLT") == 0


@pytest.mark.parametrize(
    "refused",
    [
        *("SET", "SET POS", "SET POS x", "SET POS 256", "SET POS -1", "SET POS 1.5"),
        *("SET OBJ 1", "SET ZZZ 1", "SET POS 1 SPE", "set POS 1", "GET", "GET A B"),
        *("RUN", "\x00\x01", "SET POS ²", "SET POS 1 ZZZ 2"),
    ],
)
def test_what_it_does_not_know_changes_nothing(client: Client, refused: str) -> None:
    before = [client.get(name) for name in ("ACT", "GTO", "PRE", "SPE")]
    assert client.ask(refused + "\n").startswith("?")
    assert [client.get(name) for name in ("ACT", "GTO", "PRE", "SPE")] == before


def test_unknown_variables_have_no_value(client: Client) -> None:
    assert client.ask("GET ZZZ\n") == "ZZZ ?\n"
    assert client.ask("GET SID\n") == "SID [9]\n"
    assert client.set(SID=9)


def test_commands_arrive_in_any_pieces(client: Client) -> None:
    for text in ("S", "ET SP", "E 3", "3\nGET SPE", "\nGET FO", "R\n\n"):
        client.socket.sendall(text.encode())
    wanted, received = b"ackSPE 33\nFOR ", b""
    while len(received) <= len(wanted) or not received.endswith(b"\n"):
        received += client.socket.recv(1024)
    assert received.startswith(wanted)


def test_several_variables_come_at_once(client: Client) -> None:
    text = client.ask("GET PRE\nGET SPE\r\nGET SID\n")
    assert [line.split()[0] for line in text.splitlines()] == ["PRE", "SPE", "SID"]


def test_endless_lines_and_too_many_clients_are_dropped(
    served: ServedGripper,
) -> None:
    with Client(served.host) as client:
        client.socket.sendall(b"X" * (MAX_LINE + 1))
        received = b""
        while data := client.socket.recv(1024):
            received += data
        assert received in {b"", b"?"}
    clients = [Client(served.host) for _ in range(MAX_CLIENTS)]
    assert all(client.get("POS") >= 0 for client in clients)
    with Client(served.host) as one_more:
        assert one_more.ask("") == ""
    for client in clients:
        client.socket.close()


@pytest.mark.slow
def test_garbage_harms_nobody(served: ServedGripper) -> None:
    chance = random.Random(3)
    words = [b"GET", b"SET", b"POS", b"ACT", b" ", b"\n", b"255", b"-9", b"\xff\x00"]

    def send() -> None:
        with Client(served.host) as client:
            threading.Thread(target=swallow, args=(client.socket,), daemon=True).start()
            for _ in range(200):
                packet = b"".join(chance.choices(words, k=chance.randrange(1, 12)))
                client.socket.sendall(packet)

    def swallow(connection: socket.socket) -> None:
        while True:
            try:
                if not connection.recv(4096):
                    return
            except OSError:
                return

    for _ in range(3):
        send()
    with Client(served.host) as client:
        client.activate()


def test_no_line_is_too_strange_to_be_parsed(served: ServedGripper) -> None:
    chance = random.Random(4)
    words = ["GET", "SET", "POS", "ACT", "SID", "1", "999999", "é", "\t", "None", "²"]

    def parse() -> int:
        done = 0
        for _ in range(10_000):
            line = " ".join(chance.choices(words, k=chance.randrange(6)))
            text = answer(served.gripper, line, is_short=chance.random() < 0.5)
            done += isinstance(text, str)
        return done

    assert served.do(parse) == 10_000
    activation = served.gripper.status.activation
    assert activation in set(Activation)


def test_without_power_it_answers_with_a_question_mark(
    served: ServedGripper, client: Client
) -> None:
    box = served.robot.arm.control_box
    box.power_off()
    served.wait_for_update(lambda: not served.gripper.is_powered)
    assert client.ask("GET POS\n") == "POS ?\n"
    assert client.ask("GET POS") == "?"
    assert client.ask("SET POS 1\n") == "?"
    box.release_brakes()
    box.play()
    served.wait_for_update(lambda: served.gripper.is_powered)
    assert client.get("STA") == 0
