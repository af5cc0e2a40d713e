import os
import signal
from pathlib import Path

import fresh_python
import odd_probes
import pytest
from odd_probes import OddProbe, crashes, fine, hangs, leaves, leaves_one_behind, raises
from processes import Watch, has_ended

from tool0.cli.probes import mujoco
from tool0.installation.doctor.report import (
    DoctorReport,
    Probe,
    ProbeResult,
    ProbeState,
    examine,
)

pytestmark = pytest.mark.slow

LONG = 60.0  # [wall s]; only a failing test waits so long


@pytest.fixture(autouse=True)
def pids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make the probes importable; return where they write whom they started."""
    folder = str(Path(odd_probes.__file__).parent)
    monkeypatch.setenv("PYTHONPATH", folder, prepend=os.pathsep)
    told = tmp_path / "pids"
    monkeypatch.setenv("PIDS", str(told))
    return told


def look(*functions: OddProbe, timeout: float = LONG) -> dict[str, ProbeResult]:
    report = examine([Probe(one) for one in functions], timeout=timeout)
    return {line.what: line for line in report.lines}


def test_a_probe_that_fails_is_unknown_and_the_others_run() -> None:
    found = look(raises, crashes, leaves, fine)
    assert [line.state for line in found.values()] == ["unknown"] * 3 + ["ready"]
    assert "RuntimeError: no such thing" in found["raises"].found
    assert "SIGSEGV" in found["crashes"].found
    assert "exit status 7" in found["leaves"].found
    assert found["fine"].found == "\N{SNOWMAN}"


def test_a_probe_that_hangs_is_unknown_and_ended(pids: Path) -> None:
    for timeout in (2.0, 10.0, 60.0):  # a busy machine needs more to start them
        found = look(hangs, fine, timeout=timeout)
        if found["fine"].state == "ready" and pids.exists():
            break
    assert (found["hangs"].state, found["fine"].state) == ("unknown", "ready")
    assert all(has_ended(int(pid), LONG) for pid in pids.read_text().split())


def test_a_process_that_a_probe_leaves_behind_is_ended(pids: Path) -> None:
    assert look(leaves_one_behind)["left"].state == "ready"
    assert has_ended(int(pids.read_text()), LONG)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_every_probe_ends_with_the_doctor(pids: Path, number: signal.Signals) -> None:
    os.mkfifo(pids)
    program = (
        "from odd_probes import hangs\n"
        "from tool0.installation.doctor.report import Probe, examine\n"
        "examine([Probe(hangs)], timeout=600.0)"
    )
    with fresh_python.start(program) as doctor:
        watch = Watch(map(int, pids.read_text().split()))  # waits until they start
        doctor.send_signal(number)
        _, errors = doctor.communicate(timeout=LONG)
        assert watch.all_ended(timeout=LONG)
    assert errors.rstrip().endswith("KeyboardInterrupt") is (number == signal.SIGINT)


def test_modules_of_the_folder_one_stands_in_are_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "here"
    folder.mkdir()
    (folder / "json.py").write_text("raise RuntimeError('not this one')")
    (folder / "mujoco.py").write_text("raise RuntimeError('not this one')")
    monkeypatch.chdir(folder)
    found = examine([Probe(mujoco)])
    assert [line.state for line in found.lines] == ["ready"], found.lines


@pytest.mark.parametrize(
    ("states", "can_run"),
    [
        (("ready", "ready", "missing"), True),
        (("missing", "ready", "ready"), False),
        (("ready", "unknown", "ready"), False),
    ],
)
def test_mujoco_is_what_has_to_run(
    states: tuple[ProbeState, ...], can_run: bool
) -> None:
    names = ("python", "mujoco", "gazebo")
    lines = [ProbeResult(*row, "") for row in zip(names, states, strict=True)]
    report = DoctorReport(tuple(lines), needed=("python", "mujoco"))
    assert report.can_run is can_run
    assert report.as_json()["can_run"] is can_run
    assert ("runs here" in report.rows()[-1]) is can_run


def test_a_remedy_has_a_line_of_its_own_to_copy() -> None:
    line = ProbeResult("rviz", "missing", "none", "apt install rviz")
    assert ("", "", "-> apt install rviz") in DoctorReport((line,), needed=()).rows()
