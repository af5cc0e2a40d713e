import contextlib
import io
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from served import serving, use_folder

import tool0
from tool0.cli import FAILED, OK, main
from tool0.cli.bringup import _run as run_to_the_end
from tool0.cli.options import BringupOptions, RunOptions
from tool0.cli.stop_signal import StopSignal
from tool0.cli.text import StatusLine, finite, greeting
from tool0.protocol.address import Claim

pytestmark = pytest.mark.slow

FAST = "--headless --no-realtime --duration 0.1"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    return use_folder(monkeypatch, tmp_path)


def run(line: str) -> int:
    return main(["bringup", *line.split()])


@contextlib.contextmanager
def started(*prefix: str) -> Iterator["subprocess.Popen[str]"]:
    with subprocess.Popen(
        [*prefix, sys.executable, "-m", "tool0", "bringup", "--headless"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stdout is not None
        for line in program.stdout:
            if line.startswith("Ctrl-C"):
                break
        yield program
        program.kill()


@pytest.fixture
def running() -> Iterator["subprocess.Popen[str]"]:
    with started() as program:
        yield program


def test_json_summary_is_all_that_is_printed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(f"{FAST} --json") == OK
    summary = json.loads(capsys.readouterr().out)
    assert summary["engine"] == "mujoco"
    assert summary["sim_time"] == pytest.approx(0.1)
    assert summary["steps"] == 100
    assert {"name", "type", "state", "claimed"} == set(summary["controllers"][0])
    assert summary["joints"].keys() >= {"elbow_joint", "finger_joint"}


def test_the_commands_in_the_greeting_work(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with tool0.bringup(speed=20.0) as robot, serving(robot, "left"):
        text = greeting(robot, BringupOptions(run=RunOptions(name="left")))
        lines = [line for line in text.splitlines() if line.startswith("  tool0 ")]
        commands = [line.split()[1:] for line in lines]
        assert [line[0] for line in commands] == [
            "move",
            "grip",
            "state",
            "controllers",
        ]
        for line in commands:
            assert main(line) == OK, capsys.readouterr()


def test_the_greeting_names_robot_and_controllers(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(FAST) == OK
    out, error = capsys.readouterr()
    assert "ur5 + 2f85 is up in mujoco: 7 driven joints" in out
    assert "  eff_joint_traj_controller   running" in out
    assert "0.100 s simulated" in out
    assert "\r" not in out
    assert error == ""


def test_nothing_is_left_behind(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    assert run(f"{FAST} --no-summary") == OK
    assert "simulated" not in capsys.readouterr().out
    assert list(folder.iterdir()) == []
    after = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    assert before == after
    assert run(f"{FAST} --no-remote") == OK


@pytest.mark.parametrize("duration", ["0", "0.0004", "0.0015", "0.25"])
def test_any_duration_ends(duration: str, capsys: pytest.CaptureFixture[str]) -> None:
    line = f"--headless --no-realtime --json --duration {duration}"
    assert run(line) == OK
    time = json.loads(capsys.readouterr().out)["sim_time"]
    assert abs(time - float(duration)) <= 0.0005 + 1e-9


def test_a_long_control_period_is_simulated(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = "--controllers joint_state_controller --control-period 0.5 --duration 2"
    assert run(f"--headless --no-realtime --json {line}") == OK
    assert json.loads(capsys.readouterr().out)["sim_time"] == 2.0


def test_real_time_ends_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--headless --duration 0.05 --speed 2 --json") == OK
    assert json.loads(capsys.readouterr().out)["sim_time"] >= 0.05


def test_the_duration_counts_from_when_everything_is_up() -> None:
    options = BringupOptions(
        simulation=tool0.SimulationConfig(realtime=False),
        run=RunOptions(duration=0.2),
    )
    with tool0.bringup(simulation=options.simulation) as robot, StopSignal() as stop:
        robot.run(1.0)  # as while interfaces start
        run_to_the_end(robot, options, stop, StatusLine(io.StringIO()))
        assert robot.time == pytest.approx(1.2)
        assert robot.summary()["steps"] == 1200


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_it_with_its_summary(
    number: signal.Signals, running: "subprocess.Popen[str]", folder: Path
) -> None:
    assert (folder / "tool0.sock").exists()
    running.send_signal(number)
    out, error = running.communicate(timeout=30.0)
    assert "s simulated in" in out
    assert error == ""
    assert running.returncode == OK
    assert list(folder.iterdir()) == []


def test_under_nohup_it_outlives_its_terminal(folder: Path) -> None:
    with started("nohup") as program:
        program.send_signal(signal.SIGHUP)
        assert main(["move", "--joints", "elbow_joint=1.5", "--duration", "0.3"]) == OK
        program.terminate()
        out, _ = program.communicate(timeout=30.0)
    assert "s simulated in" in out
    assert program.returncode == OK


def test_another_process_drives_it(
    running: "subprocess.Popen[str]", capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["move", "--joints", "elbow_joint=1.4", "--duration", "0.3"]) == OK
    assert main(["grip", "--opening", "0.06"]) == OK
    capsys.readouterr()
    assert main(["state", "--json"]) == OK
    position = json.loads(capsys.readouterr().out)["position"]
    assert position["elbow_joint"] == pytest.approx(1.4, abs=0.03)


def test_a_name_in_use_is_refused_before_anything_starts(
    capsys: pytest.CaptureFixture[str],
) -> None:
    claim = Claim("tool0")
    assert run(FAST) == FAILED
    assert f"(pid {os.getpid()}); stop it or use --name" in capsys.readouterr().err
    assert run(f"{FAST} --name other") == OK
    claim.close()


def test_a_warning_about_a_file_names_the_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(
        "joint_state_controller:\n"
        "  type: joint_state_controller/JointStateController\n"
        "  publish_rate: 50\n"
        "  publish_rat: 50\n"
    )
    assert run(f"{FAST} --controllers-file {file} --json") == OK
    out, error = capsys.readouterr()
    (warning,) = json.loads(out)["warnings"]
    assert (warning["line"], Path(warning["file"])) == (4, file)
    assert error.startswith(f"tool0: warning: {file}:4: ")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("--arm ur55", "did you mean 'ur5'"),
        ("--arm UR5", "did you mean 'ur5'"),
        ("--arm ur6", "did you mean 'ur5'"),
        ("--robot nowhere.urdf", "nowhere.urdf"),
        ("--controllers-file nowhere.yaml", "nowhere.yaml"),
        ("--controllers eff_joint_trai_controller", "'eff_joint_traj_controller'"),
        ("--initial-pose elbow=1", "did you mean 'elbow_joint'"),
        ("--initial-pose nowhere", "nowhere"),
        ("--initial-pose elbow_joint=99", "99"),
        ("--duration -1", "--duration"),
        ("--name ../up", "'../up'"),
        ("--ros1 --ns 1st", "'1st'"),
        ("--world my.world", "'world'"),
    ],
)
def test_a_mistake_is_one_line_and_leaves_nothing(
    line: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(f"--headless --no-realtime {line}") == FAILED
    out, error = capsys.readouterr()
    assert out == ""
    assert error.startswith("tool0: error: ")
    assert error.count("\n") == 1
    assert message in error
    assert not folder.exists() or list(folder.iterdir()) == []


def test_without_a_gazebo_it_names_the_command(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delenv("TOOL0_GAZEBO", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert run(f"{FAST} --engine gazebo") == FAILED
    out, error = capsys.readouterr()
    assert out == ""
    assert error.count("\n") == 1
    assert "tool0 gazebo install" in error


def test_json_has_null_for_nan_and_infinity() -> None:
    value = {"a": [1.0, float("nan")], "b": (float("inf"), "x"), "c": 3}
    assert finite(value) == {"a": [1.0, None], "b": [None, "x"], "c": 3}
