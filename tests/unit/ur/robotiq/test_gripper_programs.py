"""URScript programs with the gripper: by the URCap's socket, and by rq_ functions."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from robotiq_rig import ServedGripper, serving_gripper

import tool0
from tool0.ur.messages import Message, MessageKind
from tool0.ur.programs import RuntimeState
from tool0.ur.urscript.program import compile_program

SOCKET = """
def by_socket():
  global gripper = "1"
  def set_variable(name, value):
    socket_set_var(name, value, gripper)
    ack = socket_read_byte_list(3, gripper)
    if ack != [3, 97, 99, 107]:
      textmsg("no ack: ", ack)
    end
  end
  def digits(request, n):
    socket_send_string(request, gripper)
    return socket_read_byte_list(n, gripper)
  end
  socket_open("127.0.0.1", 63352, gripper)
  set_variable("SID", 9)
  set_variable("ACT", 1)
  while digits("GET STA", 1) != [1, 51]:
    sync()
  end
  set_variable("SPE", 255)
  set_variable("POS", 255)
  textmsg("PRE ", digits("GET PRE", 3))
  set_variable("GTO", 1)
  while digits("GET OBJ", 1) == [1, 48]:
    sync()
  end
  textmsg("OBJ ", digits("GET OBJ", 1))
  textmsg("FLT ", digits("GET FLT", 2))
  textmsg("POS ", socket_get_var("POS", gripper))
end
"""
FUNCTIONS = """
def by_functions():
  rq_activate_and_wait()
  rq_set_speed(255)
  rq_move_and_wait(255)
  textmsg("closed ", rq_current_pos())
  textmsg("object ", rq_is_object_detected())
  rq_open_and_wait()
  textmsg("open ", rq_current_pos())
end
"""


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedGripper]:
    folder: Path = tmp_path_factory.mktemp("robotiq")
    with (
        tool0.bringup(initial_pose="ready", speed=4.0) as robot,
        serving_gripper(robot, folder) as served,
    ):
        yield served


def texts_of(served: ServedGripper, script: str) -> list[str]:
    """Run a program to its end; return its messages."""
    found: list[str] = []

    def take(message: Message) -> None:
        if message.kind is MessageKind.TEXT:
            found.append(message.text)

    async def run() -> None:
        programs = served.box.programs
        served.box.messages.listeners.add(take)
        await programs.start(compile_program(script, "gripper"), programs.n_stops)
        await served.box.until(lambda: programs.state is RuntimeState.STOPPED)
        served.box.messages.listeners.discard(take)

    served.do(run)
    return found


@pytest.mark.slow
def test_a_program_uses_the_socket_as_the_urcap_does(served: ServedGripper) -> None:
    assert texts_of(served, SOCKET) == [
        "PRE [3, 50, 53, 53]",
        "OBJ [1, 51]",
        "FLT [2, 48, 48]",
        "POS 230",
    ]


@pytest.mark.slow
def test_a_program_uses_the_functions_of_the_urcap(served: ServedGripper) -> None:
    assert texts_of(served, FUNCTIONS) == ["closed 230", "object False", "open 3"]
