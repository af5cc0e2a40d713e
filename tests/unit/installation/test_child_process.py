"""Children end with their parent, however that ends, and their results come back."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import fresh_python
import pytest
from processes import Watch, children, has_ended

from tool0.errors import ConfigError, SourceLocation
from tool0.installation.child_process import (
    ChildLimitExceededError,
    ChildProcess,
    ChildProcessFailedError,
    call_in_child,
    last_lines,
    run_program,
)

pytestmark = pytest.mark.slow

TIMEOUT = 20.0
"""For what takes a moment on a busy machine [wall s]."""
PARENT_AND_CHILD = 'sleep 1000 & echo $$ $! > "$PIDS"; wait'
"""A shell script that writes the ids of itself and of a process that it starts."""
DEAF = f"trap '' INT TERM; {PARENT_AND_CHILD}"
USERS = {
    "program": f"child_process.ChildProcess(['sh', '-c', '''{DEAF}''']).wait()",
    "patient": "child_process.ChildProcess("
    f"['sh', '-c', '''{DEAF}'''], grace=0.1).wait()",
    "groups": "child_process.ChildProcess("  # as with roscore
    f"['sh', '-c', '''{DEAF.replace('sleep', 'setsid sleep')}'''], grace=0.1).wait()",
    "run": f"child_process.run_program(['sh', '-c', '''{DEAF}'''])",
    "work": "child_process.call_in_child("
    f"lambda: subprocess.run(['sh', '-c', '''{DEAF}''']), "
    "timeout=1000.0, memory=1 << 30)",
}


@pytest.fixture
def pids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a pipe that process ids are written to."""
    path = tmp_path / "pids"
    os.mkfifo(path)
    monkeypatch.setenv("PIDS", str(path))
    return path


def started(pids: Path) -> list[int]:
    """Wait until the processes are started."""
    return [int(text) for text in pids.read_text().split()]


@pytest.mark.parametrize("call", USERS.values(), ids=USERS.keys())
def test_a_child_and_its_children_end_with_a_killed_parent(
    call: str, pids: Path
) -> None:
    program = "import subprocess\nfrom tool0.installation import child_process\n"
    with fresh_python.start(program + call) as parent:
        watch = Watch([*started(pids), *children(parent.pid)])
        parent.send_signal(signal.SIGKILL)
        assert watch.all_ended(TIMEOUT)


def test_closing_ends_a_child_and_its_children_at_once(pids: Path) -> None:
    with ChildProcess(["sh", "-c", DEAF]) as child:
        processes = started(pids)
        assert processes[0] == child.pid
        watch = Watch(processes)
        assert child.exit_status is None
        with pytest.raises(subprocess.TimeoutExpired):
            child.wait(0.0)
    assert watch.all_ended(TIMEOUT)
    assert child.exit_status == -signal.SIGKILL
    child.close()


def test_a_child_with_grace_is_interrupted_first(tmp_path: Path) -> None:
    ready = tmp_path / "ready"
    os.mkfifo(ready)
    script = f"trap 'exit 5' INT; sleep 1000 & echo > {ready}; wait"
    child = ChildProcess(["sh", "-c", script], grace=TIMEOUT)
    ready.read_text()
    child.close()
    assert child.exit_status == 5


@pytest.mark.parametrize("end", [ChildProcess.wait, ChildProcess.close])
def test_a_child_whose_supervisor_was_killed_is_ended(
    pids: Path, end: Callable[[ChildProcess], object]
) -> None:
    # The supervisor is stopped as early as the program can do it:
    script = f"kill -STOP $PPID; {DEAF}"
    with ChildProcess(["sh", "-c", script], grace=TIMEOUT) as child:
        watch = Watch(started(pids))
        os.kill(child._process.pid, signal.SIGKILL)
        end(child)
        assert watch.all_ended(TIMEOUT)
        assert child.exit_status == -signal.SIGKILL


def test_what_a_child_leaves_behind_is_ended(pids: Path) -> None:
    with ChildProcess(["sh", "-c", 'sleep 1000 & echo $! > "$PIDS"']) as child:
        watch = Watch(started(pids))
        assert child.wait(TIMEOUT) == 0
        assert watch.all_ended(TIMEOUT)


@pytest.mark.parametrize(
    ("script", "status"),
    [("exit 3", 3), ("kill -SEGV $$", -signal.SIGSEGV), ("kill $$", -signal.SIGTERM)],
)
def test_the_exit_status_is_the_program_s(script: str, status: int) -> None:
    with ChildProcess(["sh", "-c", script]) as child:
        assert child.wait(TIMEOUT) == status


def test_a_program_that_cannot_be_started_says_so(tmp_path: Path) -> None:
    with ChildProcess([str(tmp_path / "absent")]) as child:
        assert child.wait(TIMEOUT) == 127
        assert child.pid == 0
        assert str(tmp_path / "absent") in child.last_output()


def test_the_environment_is_for_the_program_alone(tmp_path: Path) -> None:
    # A library that Python would have to load, or to complain about:
    environment = {"LD_PRELOAD": str(tmp_path / "none.so"), "A": "b", "PATH": "/bin"}
    command = [sys.executable, "-c", "import os; print(os.environ['A'], os.getcwd())"]
    with ChildProcess(command, environment=environment, folder=tmp_path) as child:
        assert child.completed(TIMEOUT).stdout == f"b {tmp_path.resolve()}\n"


def test_a_default_timeout_of_sockets_does_not_matter() -> None:
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(60.0)  # as rospy does
    try:
        with ChildProcess(["sh", "-c", "exit 3"]) as child:
            assert child.wait(TIMEOUT) == 3
        assert call(lambda: 4) == 4
    finally:
        socket.setdefaulttimeout(before)


# --- run_program ---


def test_output_and_status_are_returned(tmp_path: Path) -> None:
    calls: list[None] = []
    answer = run_program(
        ["sh", "-c", "pwd; echo $LC_ALL; echo oops >&2; sleep 0.3; exit 3"],
        folder=tmp_path,
        while_running=lambda: calls.append(None),
    )
    assert answer.stdout == f"{tmp_path.resolve()}\nC\n"
    assert (answer.stderr, answer.returncode) == ("oops\n", 3)
    assert calls


def test_a_program_that_takes_too_long_is_ended(pids: Path) -> None:
    reader = os.open(pids, os.O_RDONLY | os.O_NONBLOCK)  # or it waits to be read
    with pytest.raises(subprocess.TimeoutExpired):
        run_program(["sh", "-c", PARENT_AND_CHILD], timeout=1.0)
    processes = [int(pid) for pid in os.read(reader, 100).split()]
    os.close(reader)
    assert all(has_ended(pid, TIMEOUT) for pid in processes)


def test_the_last_lines_are_those_that_are_not_empty() -> None:
    assert last_lines("a\n\nb\nc\n\n", 2) == "  b\n  c"


# --- call_in_child ---


def call(work: Callable[[], object], *, timeout: float = TIMEOUT) -> object:
    return call_in_child(work, timeout=timeout, memory=64 << 20)


def test_the_result_comes_back() -> None:
    assert call(lambda: sorted([3, 1, 2])) == [1, 2, 3]
    assert call(lambda: len(call(lambda: bytes(1 << 20)))) == 1 << 20  # type: ignore[arg-type]


def test_an_error_comes_back_with_its_location() -> None:
    location = SourceLocation(Path("a.yaml"), 7)

    def refuse() -> None:
        raise ConfigError("bad", location)

    with pytest.raises(ConfigError) as error:
        call(refuse)
    assert error.value.location == location


def test_endless_work_is_ended() -> None:
    before = children(os.getpid())
    began = time.monotonic()
    with pytest.raises(ChildLimitExceededError) as error:
        call(lambda: pow(10, 10**10), timeout=0.2)  # no signal interrupts it
    assert "0.2 s" in str(error.value)
    assert time.monotonic() - began < TIMEOUT
    assert children(os.getpid()) == before


def test_work_that_takes_too_much_memory_is_ended() -> None:
    with pytest.raises(ChildLimitExceededError) as error:
        call(lambda: bytes(1 << 30))
    assert "64 MiB" in str(error.value)


def test_a_crash_is_reported_with_its_signal() -> None:
    with pytest.raises(ChildProcessFailedError) as error:
        call(os.abort)
    assert "SIGABRT" in str(error.value)


def test_an_error_that_cannot_be_pickled_is_reported_by_its_text() -> None:
    def fail() -> None:
        class LocalError(Exception):
            pass

        raise LocalError("quite")

    with pytest.raises(ChildProcessFailedError) as error:
        call(fail)
    assert "LocalError: quite" in str(error.value)
