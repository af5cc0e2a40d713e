import json
from pathlib import Path

import pytest

from tool0.cli import FAILED, OK, main
from tool0.cli.explain import HAS_ERRORS

DATA = Path(__file__).parents[2] / "data" / "launch" / "src"
BRING_UP = DATA / "arm_gazebo" / "launch" / "arm_bringup.launch"

Capture = pytest.CaptureFixture[str]

CONTENTS = """\
arm_gazebo/launch/arm_bringup.launch
├─ 12  include  arm_gazebo/launch/inc/load_arm2.launch.xml
│  └─ 6  include  arm_gazebo/launch/inc/load_arm.launch.xml
│     └─ 7  param  /robot_description
│        └─ 7  xacro  arm_gazebo/urdf/arm.xacro
│           ├─ 7  xacro arg  model = arm2
│           ├─ 7  xacro arg  limits = $(find arm_description)/config/limits.yaml
│           ├─ 7  xacro arg  kinematics = $(find arm_description)/config/kinematics.yaml
│           ├─ 7  xacro arg  interface = hardware_interface/EffortJointInterface
│           └─ 3  xacro      arm_gazebo/urdf/arm_macro.xacro
│              └─ 4  xacro  arm_description/urdf/inc/arm_macro.xacro
├─ 17  node     /robot_state_publisher  robot_state_publisher/robot_state_publisher
│  ├─ 19  param  publish_frequency = 50
│  └─ 20  param  tf_prefix = ''
"""
RATE = """
  rate = 50
  │ line 9, from the command line
  └─ line 19  value of param /robot_state_publisher/publish_frequency
"""


def test_the_tree_and_the_arguments(capsys: Capture) -> None:
    assert main(["explain", str(BRING_UP), "rate:=50"]) == OK
    shown = capsys.readouterr().out
    assert shown.startswith(CONTENTS)
    assert RATE in shown
    assert max(map(len, shown.splitlines())) <= 100
    assert "error" not in shown


def test_a_package_and_a_name_do_as_well(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(DATA))
    assert main(["explain", "arm_gazebo", "control.launch.xml"]) == OK
    shown = capsys.readouterr().out
    assert shown.startswith("arm_gazebo/launch/inc/control.launch.xml\n")
    words = " ".join(shown.split())  # where it wraps depends on the path
    assert "argument 'controller_file' has no value" in words


def test_json_holds_the_same(capsys: Capture) -> None:
    assert main(["explain", str(BRING_UP), "--json"]) == OK
    found = json.loads(capsys.readouterr().out)
    first = found["contents"]["items"][0]
    assert (first["kind"], first["line"]) == ("include", 12)
    assert found["arguments"][0]["items"][1]["name"] == "limits"
    assert found["findings"] == []


def test_errors_come_last_and_make_the_status(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "main.launch"
    file.write_text('<launch>\n<include file="$(dirname)/absent.launch"/>\n</launch>')
    assert main(["explain", str(file)]) == HAS_ERRORS
    contents, _, findings = capsys.readouterr().out.partition("\n1 error\n")
    assert "absent.launch" in contents
    assert "does not exist]" in " ".join(contents.split())
    assert findings.startswith(f"error: {file}:2:")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["absent.launch"], "there is no file 'absent.launch'"),
        (["x", "y", "z"], "got 3 names"),
        (["no_such_package", "x.launch"], "no_such_package"),
        (["tool0_gazebo", "x.launch"], "no file 'x.launch' in package"),
    ],
)
def test_what_cannot_be_found_is_said(
    words: list[str], message: str, capsys: Capture
) -> None:
    assert main(["explain", *words]) == FAILED
    assert message in capsys.readouterr().err
