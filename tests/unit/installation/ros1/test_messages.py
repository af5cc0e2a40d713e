"""Our message packages: made once, and known to ROS's commands."""

import os
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest
from fresh_python import run, start
from promised import absent, require_ros

pytestmark = pytest.mark.slow

IMPORT = (
    "from tool0.installation.ros1.messages import import_messages; import_messages()\n"
)
CACHE = "it's a $cache"
WHERE = "import control_msgs.msg; print(control_msgs.msg.__file__)\n"


@pytest.fixture(scope="module", autouse=True)
def none_installed() -> None:
    require_ros()
    program = "from tool0.installation.ros1.library import import_ros; import_ros()\n"
    program += "from tool0.installation.ros1 import messages\n"
    program += "print(messages.absent_packages() == messages.package_names())"
    if run(program) != "True\n":
        absent("ros1", "a ROS 1 that leaves all message packages to us is not here")


@pytest.fixture(autouse=True)
def bare_caches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / CACHE))
    monkeypatch.setenv("TMPDIR", str(tmp_path))


def refusal(**variables: str) -> str:
    """Return why the messages cannot be imported."""
    program = (
        "from tool0.errors import RosUnavailableError\n"
        "from tool0.installation.ros1.messages import import_messages\n"
        "try: import_messages()\n"
        "except RosUnavailableError as error: print(error)\n"
    )
    return run(program, **variables)


def made(cache: Path) -> list[Path]:
    return sorted(path for path in (cache / "tool0" / "ros1").iterdir())


@pytest.fixture
def noetic(tmp_path: Path) -> Path:
    """Return a folder with an installed control_msgs."""
    folder = tmp_path / "noetic"
    folder.mkdir()
    program = (
        "import sys; from pathlib import Path\n"
        "from tool0.installation.ros1 import messages\n"
        "from tool0.installation.ros1.library import import_ros; import_ros()\n"
        "messages.generate(('control_msgs',), Path(sys.argv[1]))\n"
    )
    run(program, str(folder))
    return folder


def test_a_second_start_finds_what_the_first_made(tmp_path: Path) -> None:
    first = run(IMPORT + WHERE)
    before = [(path, path.stat().st_ino) for path in made(tmp_path / CACHE)]
    assert run(IMPORT + WHERE) == first
    assert [(path, path.stat().st_ino) for path in made(tmp_path / CACHE)] == before


def test_what_is_made_is_compiled_where_it_is_read_from(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    program = "from control_msgs.msg import _JointTolerance as module\n"
    program += "from pathlib import Path; print(Path(module.__cached__).is_file())\n"
    program += "code = module.JointTolerance.serialize.__code__\n"
    program += "print(code.co_filename == module.__file__)"
    assert run(IMPORT + program) == "True\nTrue\n"


def test_several_at_once_make_one(tmp_path: Path) -> None:
    with ExitStack() as stack:
        processes = [stack.enter_context(start(IMPORT + WHERE)) for _ in range(3)]
        answers = [process.communicate(timeout=60) for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0], answers
    assert len({out for out, _ in answers}) == 1
    folder, lock = made(tmp_path / CACHE)
    assert (folder.is_dir(), lock.name) == (True, "lock")
    assert not list(folder.glob(".*"))


def test_importing_twice_changes_nothing() -> None:
    again = "import sys; before = list(sys.path)\n" + IMPORT + "print(sys.path==before)"
    assert run(IMPORT + again) == "True\n"


@pytest.mark.parametrize("depth", [0, 2])
def test_a_cache_that_cannot_be_written_is_done_without(
    tmp_path: Path, depth: int
) -> None:
    obstacle = tmp_path.joinpath(CACHE, *("tool0", "ros1")[:depth])
    obstacle.parent.mkdir(parents=True, exist_ok=True)
    obstacle.touch()
    where = Path(run(IMPORT + WHERE).strip())
    assert where.is_relative_to(tmp_path)
    assert not where.exists()  # it ended with the process


def test_no_place_to_write_is_an_error_that_says_so(tmp_path: Path) -> None:
    (tmp_path / CACHE).touch()
    program = "import tempfile; tempfile.tempdir = '/dev/null'\n"
    program += "from tool0.errors import RosUnavailableError\n"
    program += f"try:\n {IMPORT}except RosUnavailableError as error: print(error)"
    assert "XDG_CACHE_HOME" in run(program)


def test_an_installed_package_is_used(noetic: Path, tmp_path: Path) -> None:
    where = run(IMPORT + WHERE, PYTHONPATH=str(noetic))
    assert Path(where.strip()).is_relative_to(noetic)
    folder = next(path for path in made(tmp_path / CACHE) if path.is_dir())
    names = {path.name for path in folder.iterdir()}
    assert names == {"controller_manager_msgs", "gazebo_msgs"}


def test_what_tool0_made_does_not_count_as_installed(tmp_path: Path) -> None:
    old = tmp_path / CACHE / "tool0" / "ros1" / "old"
    (old / "control_msgs").mkdir(parents=True)
    (old / "control_msgs" / "__init__.py").touch()
    where = Path(run(IMPORT + WHERE, PYTHONPATH=str(old)).strip())
    assert not where.is_relative_to(old)


def test_a_mere_folder_of_that_name_is_no_package(tmp_path: Path) -> None:
    (tmp_path / "src" / "control_msgs").mkdir(parents=True)
    where = Path(run(IMPORT + WHERE, PYTHONPATH=str(tmp_path / "src")).strip())
    assert where.is_relative_to(tmp_path / CACHE)


def test_an_installed_package_without_a_type_is_refused(noetic: Path) -> None:
    init = noetic / "control_msgs" / "msg" / "__init__.py"
    text = init.read_text(encoding="utf-8")
    init.write_text(text.replace("from ._JointTolerance import *\n", ""))
    said = refusal(PYTHONPATH=str(noetic))
    assert "control_msgs" in said
    assert "JointTolerance is not in it" in said


def test_an_installed_package_without_a_field_is_refused(noetic: Path) -> None:
    module = noetic / "control_msgs" / "msg" / "_JointTolerance.py"
    text = module.read_text(encoding="utf-8")
    old = "__slots__ = ['name','position','velocity','acceleration']"
    assert old in text
    module.write_text(text.replace(old, "__slots__ = ['name']"), encoding="utf-8")
    said = refusal(PYTHONPATH=str(noetic))
    assert "JointTolerance has no field position" in said
    assert str(noetic) in said


def test_a_package_of_ros_2_is_refused(tmp_path: Path) -> None:
    package = tmp_path / "jazzy" / "control_msgs"
    (package / "msg").mkdir(parents=True)
    (package / "__init__.py").touch()
    classes = "class FollowJointTrajectoryGoal: ...\n"
    (package / "msg" / "__init__.py").write_text(classes, encoding="utf-8")
    said = refusal(PYTHONPATH=str(package.parent))
    assert "FollowJointTrajectoryGoal is not of ROS 1" in said


# --- `tool0 ros1 env` ---

FORGOTTEN = ("PYTHONPATH", "ROS_PACKAGE_PATH")
EVALUATE = f'eval "$({sys.executable} -m tool0 ros1 env)" && '


def shell(script: str, **variables: str) -> str:
    bare = {k: v for k, v in os.environ.items() if k not in FORGOTTEN}
    answer = subprocess.run(
        ["sh", "-c", script],
        env=bare | variables,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


def test_a_person_can_ask_rosmsg_and_rossrv_for_our_types() -> None:
    script = "rosmsg md5 control_msgs/FollowJointTrajectoryAction && "
    script += "rossrv md5 controller_manager_msgs/SwitchController && "
    script += "rosmsg show -r control_msgs/JointTolerance && "
    script += "rossrv show gazebo_msgs/GetJointProperties"
    lines = shell(EVALUATE + script).splitlines()
    assert "bc4f9b743838566551c0390c65f1a248" in lines
    assert "b29a7abc673b2c54c14b54e50f8d06a5" in lines
    assert "float64 acceleration" in lines
    assert "uint8 REVOLUTE=0" in lines


def test_what_the_variables_held_stays_before() -> None:
    held = {"PYTHONPATH": "/a b:/c", "ROS_PACKAGE_PATH": "/d"}
    script = EVALUATE + 'printf "%s\\n" "$PYTHONPATH" "$ROS_PACKAGE_PATH"'
    python, ros = shell(script, **held).splitlines()
    assert python.startswith("/a b:/c:/")
    assert ros.startswith("/d:/")
    folder = Path(python.rpartition(":")[2])
    assert (folder / "control_msgs" / "package.xml").is_file()
    assert ros.rpartition(":")[2] == str(folder)


def test_saying_it_twice_is_saying_it_once() -> None:
    say = 'printf "%s\\n" "$PYTHONPATH" "$ROS_PACKAGE_PATH"'
    assert shell(EVALUATE + EVALUATE + say) == shell(EVALUATE + say)


def test_it_says_why_it_cannot(tmp_path: Path) -> None:
    (tmp_path / CACHE).touch()
    answer = subprocess.run(
        [sys.executable, "-m", "tool0", "ros1", "env"],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert (answer.returncode, answer.stdout) == (2, "")
    assert "cannot write the cache" in answer.stderr
