import os
import signal
import textwrap
import time
from pathlib import Path

import fresh_python
import pytest
from processes import Watch

from tool0.installation.doctor.examination import Report, examine
from tool0.installation.doctor.line import Line
from tool0.installation.doctor.probes import PROBES

pytestmark = pytest.mark.slow

PROBE_MODULE = """
import os, signal, subprocess, sys, time
from tool0.installation.doctor.line import Line

def fine(here):
    print("what a library prints is no answer")
    os.write(1, b"nor is this")
    return [Line(what="fine", state="ready", found="\\N{SNOWMAN}")]

def raises(here):
    raise RuntimeError("no such thing")

def crashes(here):
    os.kill(os.getpid(), signal.SIGSEGV)

def leaves(here):
    os._exit(7)

def hangs(here):
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    other = subprocess.Popen(["sleep", "1000"])
    with open(os.environ["PIDS"], "w") as told:
        print(os.getpid(), other.pid, file=told)
    time.sleep(1000)

def leaves_one_behind(here):
    other = subprocess.Popen(["sleep", "1000"])  # it holds our output open
    with open(os.environ["PIDS"], "w") as told:
        print(other.pid, file=told)
    return [Line(what="left", state="ready", found="")]
"""


@pytest.fixture(autouse=True)
def pids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make the probes importable; return where they tell whom they started."""
    (tmp_path / "odd_probes.py").write_text(PROBE_MODULE)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    told = tmp_path / "pids"
    monkeypatch.setenv("PIDS", str(told))
    return told


def look(*names: str, patience: float = 30.0) -> dict[str, Line]:
    report = examine(dict.fromkeys(names, "odd_probes"), patience=patience)
    return {line.what: line for line in report.lines}


def has_ended(pid: int) -> bool:
    try:
        return Watch([pid]).all_ended(timeout=10.0)
    except ProcessLookupError:
        return True


def test_a_probe_that_breaks_off_is_told_and_the_others_go_on() -> None:
    found = look("raises", "crashes", "leaves", "absent", "fine")
    assert [line.state for line in found.values()] == ["unknown"] * 4 + ["ready"]
    assert found["raises"].found == "its probe broke off: RuntimeError: no such thing"
    assert found["crashes"].found == "its probe broke off: SIGSEGV"
    assert found["leaves"].found == "its probe broke off: exit status 7"
    assert "no attribute 'absent'" in found["absent"].found
    assert found["fine"].found == "\N{SNOWMAN}"


def test_a_probe_that_hangs_is_told_and_ended(pids: Path) -> None:
    began = time.monotonic()
    found = look("hangs", "fine", patience=2.0)
    assert time.monotonic() - began < 10.0
    assert (found["hangs"].state, found["fine"].state) == ("unknown", "ready")
    assert found["hangs"].found == "its probe does not end"
    assert all(map(has_ended, map(int, pids.read_text().split())))


def test_whom_a_probe_leaves_behind_is_ended(pids: Path) -> None:
    assert look("leaves_one_behind", patience=10.0)["left"].state == "ready"
    assert has_ended(int(pids.read_text()))


def test_when_we_are_killed_every_probe_ends(pids: Path) -> None:
    os.mkfifo(pids)
    program = """
        from tool0.installation.doctor.examination import examine
        examine({"hangs": "odd_probes"}, patience=600.0)
    """
    with fresh_python.start(textwrap.dedent(program)) as doctor:
        watch = Watch(map(int, pids.read_text().split()))  # waits until they are told
        doctor.send_signal(signal.SIGKILL)
        assert watch.all_ended(timeout=20.0)


def test_an_interrupted_examination_ends_at_once(pids: Path) -> None:
    os.mkfifo(pids)
    program = """
        from tool0.installation.doctor.examination import examine
        examine({"hangs": "odd_probes"}, patience=600.0)
    """
    with fresh_python.start(textwrap.dedent(program)) as doctor:
        watch = Watch(map(int, pids.read_text().split()))
        doctor.send_signal(signal.SIGINT)
        _, said = doctor.communicate(timeout=20.0)
        assert said.rstrip().endswith("KeyboardInterrupt")
        assert watch.all_ended(timeout=20.0)


def test_modules_of_the_folder_one_stands_in_are_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    (folder / "json.py").write_text("raise RuntimeError('not this one')")
    (folder / "mujoco.py").write_text("raise RuntimeError('not this one')")
    monkeypatch.chdir(folder)
    found = examine({"mujoco": PROBES["mujoco"]})
    assert [line.state for line in found.lines] == ["ready"], found.lines


@pytest.mark.parametrize(
    ("python", "mujoco", "gazebo", "can_run"),
    [
        ("ready", "ready", "missing", True),
        ("missing", "ready", "ready", False),
        ("ready", "unknown", "ready", False),
    ],
)
def test_mujoco_is_what_has_to_run(
    python: str, mujoco: str, gazebo: str, can_run: bool
) -> None:
    states = {"python": python, "mujoco": mujoco, "gazebo": gazebo}
    lines = [
        Line(what=name, state=state, found="")  # type: ignore[arg-type]
        for name, state in states.items()
    ]
    report = Report(tuple(lines))
    assert report.can_run is can_run
    assert report.as_json()["can_run"] is can_run
    assert ("runs here" in report.rows()[-1]) is can_run


def test_a_remedy_has_a_line_of_its_own_to_copy() -> None:
    line = Line(what="rviz", state="missing", found="none", remedy="apt install rviz")
    assert ("", "", "-> apt install rviz") in Report((line,)).rows()
