import json
import os
import re
import subprocess
import sys
import venv
from importlib.metadata import distribution, version
from pathlib import Path

import pytest

import tool0
from tool0.cli import FAILED, OK, main, probes
from tool0.cli.probes import PROBES

pytestmark = pytest.mark.slow

STATES = {"ready", "missing", "not supported", "unknown"}


def doctor(capfd: pytest.CaptureFixture[str]) -> tuple[int, dict[str, dict[str, str]]]:
    status = main(["doctor", "--json"])
    said = capfd.readouterr()
    assert said.err == ""
    report = json.loads(said.out)
    assert report["can_run"] is (status == OK)
    return status, {line["what"]: line for line in report["lines"]}


def test_this_machine_can_run_the_main_job(capfd: pytest.CaptureFixture[str]) -> None:
    status, lines = doctor(capfd)
    assert status == OK
    assert {line["state"] for line in lines.values()} <= STATES
    assert not [line for line in lines.values() if line["state"] == "unknown"]
    assert lines["mujoco"]["found"].startswith(version("mujoco"))
    assert sys.prefix in lines["python"]["found"]
    assert lines["ros2"]["state"] == "ready" or lines["ros2"]["remedy"]
    told_apart = {"workspace": "catkin"}
    assert {told_apart.get(probe.name, probe.name) for probe in PROBES} <= lines.keys()


def test_people_read_a_table_of_a_command_that_imports_nothing_heavy() -> None:
    program = (
        "import sys; from tool0.cli import main; status = main(['doctor']); "
        "sys.exit(status or bool({'mujoco', 'numpy', 'rospy'} & set(sys.modules)))"
    )
    text = subprocess.run(
        [sys.executable, "-c", program],
        check=True,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ,
    ).stdout
    assert text.startswith("machine ")
    assert re.fullmatch(r"tool0 bringup +ready +runs here", text.splitlines()[-1])


def test_an_empty_path_lacks_programs_and_no_physics(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "CMAKE_PREFIX_PATH", "TOOL0_GAZEBO"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    status, lines = doctor(capfd)
    assert status == OK
    assert lines["mujoco"]["state"] == "ready"
    assert lines["gazebo"]["state"] == "missing"
    assert lines["gazebo"]["remedy"] == "tool0 gazebo install --gui"
    if sys.platform == "linux":
        assert lines["browser"]["state"] == "missing"
        assert lines["catkin"]["state"] in ("missing", "not supported")


@pytest.mark.parametrize(
    ("program", "found"),
    [
        ("raise ImportError('no libx.so', name='mujoco')", "no libx.so"),
        ("import os; os.abort()", "its probe failed: SIGABRT"),
    ],
)
def test_a_broken_mujoco_affects_no_other_probe(
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    program: str,
    found: str,
) -> None:
    few = [probe for probe in PROBES if probe.name in ("mujoco", "python")]
    monkeypatch.setattr(probes, "PROBES", few)  # all of them take seconds
    (tmp_path / "mujoco.py").write_text(program)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    status, lines = doctor(capfd)
    assert status == 1
    assert lines["mujoco"]["found"] == found
    if "ImportError" in program:
        assert lines["mujoco"]["state"] == "missing"
        remedy = lines["mujoco"]["remedy"]
        assert remedy.startswith(f"{sys.executable} -m pip install ")
        assert "'mujoco>=" in remedy
    else:
        assert lines["mujoco"]["state"] == "unknown"
    assert lines["python"]["state"] == "ready"


def test_a_python_without_what_tool0_needs_is_told(tmp_path: Path) -> None:
    venv.create(tmp_path, with_pip=False)
    (folder,) = tmp_path.glob("[Ll]ib/python3*/site-packages")
    (folder / "tool0.pth").write_text(str(Path(tool0.__file__).parents[1]))
    (folder / "tool0.dist-info").mkdir()
    metadata = distribution("tool0").read_text("METADATA") or ""
    (folder / "tool0.dist-info" / "METADATA").write_text(metadata)
    python = str(tmp_path / "bin" / "python")
    done = subprocess.run(
        [python, "-m", "tool0", "doctor"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (1, "")
    report = " ".join(done.stdout.split())
    assert f"-> {python} -m pip install 'msgspec>=" in report
    assert "mujoco missing No module named" in report
    assert "panel missing No module named" in report
    assert "unknown" not in report
    assert report.endswith("does not run here: see python and mujoco above")


def test_a_wrong_option_is_a_mistake(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--jso"]) == FAILED
    assert "did you mean --json?" in capfd.readouterr().err
