"""Functions of XML-RPC servers, called by programs."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, cast
from xmlrpc.client import DateTime
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from urscript_rig import TimeBox, run_in_time, run_on


class Server(SimpleXMLRPCServer):
    """A server that refuses no connection: a second try would take a second or more."""

    request_queue_size = 128


@contextmanager
def serving(*functions: Callable[..., Any]) -> Iterator[str]:
    """Serve functions; yield the URL."""
    with Server(("127.0.0.1", 0), logRequests=False, allow_none=True) as server:
        for item in functions:
            server.register_function(item)
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}/RPC2"
        server.shutdown()
        thread.join()


def camera(url: str, *lines: str) -> str:
    return "\n".join((f'camera = rpc_factory("xmlrpc", "{url}")', *lines))


def test_values_come_back_as_they_were_sent() -> None:
    values = {
        "True": "True",
        "-7": "-7",
        "2.5": "2.5",
        '"text"': "text",
        "[1, 2, 3]": "[1, 2, 3]",
        "[[1, 2], [3, 4]]": "[[1, 2], [3, 4]]",
        "p[1, 2, 3, 0, 0.5, 0]": "p[1, 2, 3, 0, 0.5, 0]",
        'struct(a = 1, b = "x")': "struct(a = 1, b = x)",
    }

    def same(value: object) -> object:
        return value

    with serving(same) as url:
        run = run_in_time(
            camera(url, *(f"textmsg(camera.same({value}))" for value in values))
        )
    assert run.error is None
    assert run.texts == list(values.values())


def test_a_pose_is_a_struct_of_its_coordinates() -> None:
    taken: list[object] = []

    def look(pose: object, count: object) -> bool:
        taken.extend((pose, count))
        return False

    with serving(look) as url:
        run = run_in_time(
            camera(
                url,
                "if (! camera.look(p[1, 2, 3, 4, 5, 6], 2)):",
                '  textmsg("nothing")',
                "end",
                "camera.closeXMLRPCClientConnection()",
                "camera.look(p[0, 0, 0, 0, 0, 0], 1)",
            )
        )
    assert (run.error, run.texts) == (None, ["nothing"])
    pose = {"x": 1, "y": 2, "z": 3, "rx": 4, "ry": 5, "rz": 6}
    assert taken[:2] == [pose, 2]


def test_two_handles_reach_a_server_with_one_thread() -> None:
    with serving(pow) as url:
        run = run_in_time(
            f'a = rpc_factory("xmlrpc", "{url}")\n'
            f'b = rpc_factory("xmlrpc", "{url}")\n'
            "textmsg(a.pow(2, 3))\ntextmsg(b.pow(3, 2))\ntextmsg(a.pow(2, 4))"
        )
    assert run.texts == ["8", "9", "16"]


def test_a_call_has_the_result_of_a_method_that_lists_have() -> None:
    def length(a: int, b: int) -> int:
        return a + b

    with serving(length) as url:
        run = run_in_time(
            camera(url, "textmsg(camera.length(1, 2))", "textmsg([1, 2].length())")
        )
    assert run.texts == ["3", "2"]


@pytest.mark.parametrize(
    ("line", "error"),
    [
        ("camera.nothing()", "nothing: the server answers with an error: "),
        ("camera.fail()", "fail: the server answers with an error: "),
        ("x = camera.when()", "when: programs have no values such as XML-RPC's Dat"),
        ("x = camera.mixed()", "mixed: a list has elements of one kind, not "),
        ("x = camera.empty()", "there is no value to assign"),
        ("camera.when(camera)", "when: a remote server cannot be sent"),
        ("x = [1].append()", "append: 'append' takes 1 argument, not 0"),
        ("x = 1\nx.look()", "look: an integer has no methods; a list has"),
    ],
)
def test_a_call_that_fails_ends_the_program(line: str, error: str) -> None:
    def fail() -> None:
        raise ValueError("no picture")

    def when() -> DateTime:
        return DateTime(0)

    def mixed() -> list[object]:
        return [1, "a"]

    def empty() -> None:
        return None

    with serving(fail, when, mixed, empty) as url:
        run = run_in_time(camera(url, line))
    assert error in str(run.error)


@pytest.mark.parametrize(
    ("call", "error"),
    [
        ('"http://127.0.0.1:1/RPC2"', "no server answers at http://127.0.0.1:1/RPC2"),
        ('"http://10.0.0.1/RPC2"', "connect to this machine only, not to '10.0.0.1'"),
        ('"http://127.0.0.1@10.0.0.1/RPC2"', "this machine only, not to '10.0.0.1'"),
        ('"https://127.0.0.1/RPC2"', "is not like http://127.0.0.1:8080/RPC2"),
        ('"127.0.0.1:8080"', "is not like http://127.0.0.1:8080/RPC2"),
    ],
)
def test_a_server_that_cannot_be_reached_ends_the_program(
    call: str, error: str
) -> None:
    run = run_in_time(f'x = rpc_factory("xmlrpc", {call})')
    assert error in str(run.error)


def test_other_threads_go_on_while_a_server_works() -> None:
    has_message = threading.Event()

    def wait() -> bool:
        return has_message.wait(10.0)

    box = TimeBox()
    box.messages.listeners.add(lambda message: has_message.set())
    with serving(wait) as url:
        run = run_in_time(
            camera(
                url,
                "thread other():",
                "  sleep(0.1)",
                '  textmsg("meanwhile")',
                "end",
                "run other()",
                "textmsg(camera.wait())",
            ),
            box,
        )
    assert run.texts == ["meanwhile", "True"]


def test_a_program_that_is_stopped_calls_no_server_again() -> None:
    calls: list[int] = []
    is_called, may_end = threading.Event(), threading.Event()

    def work() -> bool:
        calls.append(1)
        is_called.set()
        return may_end.wait(10.0)

    async def stop(url: str) -> None:
        box = cast("Any", TimeBox())
        task = asyncio.create_task(run_on(box, camera(url, "camera.work()")))
        await asyncio.to_thread(is_called.wait, 10.0)
        task.cancel()
        await asyncio.wait([task], timeout=5.0)
        assert task.cancelled()

    with serving(work) as url:
        asyncio.run(stop(url))
        may_end.set()
    for thread in threading.enumerate():
        if thread.name == "urscript-rpc":
            thread.join(10.0)
    assert calls == [1]


def test_handles_that_are_closed_leave_room_for_others() -> None:
    with serving(pow) as url:
        run = run_in_time(
            f"""
            k = 0
            while k < 100:
              a = rpc_factory("xmlrpc", "{url}")
              a.closeXMLRPCClientConnection()
              k = k + 1
            end
            textmsg(a.pow(2, 2))
            while True:
              a = rpc_factory("xmlrpc", "{url}")
            end
            """
        )
    assert run.texts == ["4"]
    assert "64 handles are open; close some with close" in str(run.error)


def test_the_name_of_this_machine_is_its_address() -> None:
    with serving(pow) as url:
        run = run_in_time(
            camera(
                url.replace("127.0.0.1", "me@localhost"), "textmsg(camera.pow(2, 3))"
            )
        )
    assert (run.error, run.texts) == (None, ["8"])
