import json
import shutil
from pathlib import Path

import pytest

from tool0.cli import FAILED, OK, main
from tool0.cli.describe import table, tree
from tool0.cli.text import columns
from tool0.description.catalogue import find_part
from tool0.description.model import (
    Interface,
    Joint,
    JointLimits,
    JointType,
    Link,
    Mimic,
    RobotModel,
    Transmission,
)

MODEL = RobotModel(
    name="branching",
    root="world",
    links=tuple(Link(name=name) for name in ("world", "left", "tip", "right")),
    joints=(
        Joint(
            name="slide",
            type=JointType.PRISMATIC,
            parent="world",
            child="left",
            limits=JointLimits(lower=-0.5, upper=1.0, velocity=2.0, effort=30.0),
        ),
        Joint(name="glue", type=JointType.FIXED, parent="left", child="tip"),
        Joint(
            name="follow",
            type=JointType.CONTINUOUS,
            parent="world",
            child="right",
            mimic=Mimic(joint="slide", multiplier=-2.0, offset=0.25),
        ),
    ),
    transmissions=(
        Transmission(name="drive", joint="slide", interfaces=(Interface.EFFORT,)),
    ),
)


def test_tree_branches() -> None:
    assert tree(MODEL).splitlines() == [
        "world",
        "├─ slide    prismatic   ─> left",
        "│  └─ glue  fixed       ─> tip",
        "└─ follow   continuous  ─> right",
    ]


def test_table_holds_the_movable_joints() -> None:
    rows = [line.split() for line in table(MODEL).splitlines()[2:]]
    assert rows == [
        [
            "slide",
            "prismatic",
            "1",
            "0",
            "0",
            "-0.5",
            "1",
            "2",
            "30",
            "EffortJointInterface",
        ],
        [
            "follow",
            "continuous",
            "1",
            "0",
            "0",
            "-inf",
            "inf",
            "inf",
            "inf",
            "-2",
            "·",
            "slide",
            "+0.25",
        ],
    ]


def test_columns_are_aligned_and_end_without_blanks() -> None:
    text = columns([("a", "bbb"), ("aaaa", "b"), ("", "")])
    assert text == "a     bbb\naaaa  b\n\n"
    assert columns([]) == ""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "start"),
    [
        ("tree", "world\n"),
        ("table", "joint "),
        ("urdf", "<?xml"),
        ("mjcf", "<mujoco"),
        ("controllers", "# Controllers of ur5 + 2f85"),
        ("sources", "ur5\n  payload      5.0\n"),
    ],
)
def test_every_form_is_written(
    form: str, start: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["describe", form]) == OK
    printed = capsys.readouterr().out
    assert printed.startswith(start)
    file = tmp_path / "robot"
    assert main(["describe", form, "--output", str(file)]) == OK
    assert file.read_text(encoding="utf-8") == printed


def test_what_it_writes_as_urdf_it_can_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "robot.urdf"
    assert main(["describe", "urdf", "--output", str(file)]) == OK
    assert main(["describe", "table"]) == OK
    built_in = capsys.readouterr().out
    assert main(["describe", "table", "--robot", str(file)]) == OK
    assert capsys.readouterr().out == built_in


def test_sources_tell_what_has_no_published_source(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["describe", "sources", "--arm", "ur18", "--gripper", "none"]) == OK
    text = capsys.readouterr().out
    head, _, unsourced = text.partition("  without a published source:\n")
    assert [line.split() for line in head.splitlines()] == [
        ["ur18"], ["payload", "18.0"], ["reach", "0.95"], ["update_rate", "500"],
        ["dh_source", "-"],
    ]  # fmt: skip
    assert "physical_parameters.base_mass  " in unsourced
    own = tmp_path / "mine"
    shutil.copytree(find_part("arm", "ur18").folder, own)
    (own / "specifications.yaml").unlink()
    assert main(["describe", "sources", "--arm", str(own), "--gripper", "none"]) == OK
    assert capsys.readouterr().out == f"mine: no specifications.yaml in {own}\n"
    urdf = tmp_path / "robot.urdf"
    urdf.write_text('<robot name="r"><link name="a"/></robot>')
    assert main(["describe", "sources", "--robot", str(urdf)]) == OK
    assert capsys.readouterr().out.startswith("robot.urdf: your own file")


def test_prefix_and_bare_arm(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["describe", "tree", "--prefix", "left_", "--gripper", "none"]) == OK
    text = capsys.readouterr().out
    assert "left_elbow_joint" in text
    assert "finger" not in text


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("tree --arm ur55", "'ur5'"),
        ("tree --gripper 2f58", "'2f85'"),
        ("tree --robot nowhere.urdf", "nowhere.urdf"),
        ("tree --robot x.urdf --args novalue", "'novalue'"),
        ("tree --robot x.urdf --safety-limits", "safety_limits"),
        ("tree --output /nowhere/at/all", "/nowhere/at/all"),
    ],
)
def test_a_mistake_is_one_line(
    line: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["describe", *line.split()]) == FAILED
    error = capsys.readouterr().err
    assert error.startswith("tool0: error: ")
    assert error.count("\n") == 1
    assert message in error


def test_joints_and_sources_are_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["describe", "table", "--json"]) == OK
    found = json.loads(capsys.readouterr().out)
    joints = {joint["name"]: joint for joint in found["joints"]}
    assert found["root"] == "world"
    assert joints["elbow_joint"]["upper"] == pytest.approx(3.14159, abs=1e-4)
    assert joints["elbow_joint"]["driven"] == ["EffortJointInterface"]
    mimics = [joint["mimic"] for joint in found["joints"] if joint["mimic"]]
    assert {mimic["joint"] for mimic in mimics} == {"finger_joint"}
    assert main(["describe", "sources", "--json"]) == OK
    assert json.loads(capsys.readouterr().out).keys() == {"ur5", "2f85"}
    assert main(["describe", "urdf", "--json"]) == FAILED
    assert "--json is for tree, table and sources" in capsys.readouterr().err
