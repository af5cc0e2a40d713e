"""Where ROS 2's YAML has the parameters of a node."""

from __future__ import annotations

from pathlib import Path

import pytest
from raises_naming import raises_naming

from tool0.control.config import ControllerConfig
from tool0.control.ros2.lint import lint
from tool0.errors import ConfigError

FORWARD = "forward_command_controller/ForwardCommandController"
MANAGER = f"""
controller_manager:
  ros__parameters:
    update_rate: 250
    arm: {{type: {FORWARD}}}
"""
OWN = """
arm:
  ros__parameters: {joints: [hip], interface_name: position}
"""


def read(text: str) -> ControllerConfig:
    return ControllerConfig.from_text(text)


def values(text: str, name: str = "arm") -> object:
    """Return the parameters of a node as plain values."""
    config = read(text)
    found = config.dialect.parameters(config.tree.root, name)
    return None if found is None else found.plain()


@pytest.mark.parametrize(
    "text",
    [
        MANAGER + OWN,
        OWN + MANAGER,
        f"arm:\n  ros__parameters: {{type: {FORWARD}, joints: [hip],"
        " interface_name: position}",
        f"/**:\n  ros__parameters:\n    arm.type: {FORWARD}\n    joints: [hip]\n"
        "    interface_name: position\n",
    ],
)
def test_the_type_is_the_managers_or_the_controllers_own(text: str) -> None:
    config = read(text)
    assert config.dialect.name == "ros2"
    assert config.types["arm"] == FORWARD
    found = config.dialect.parameters(config.tree.root, "arm")
    assert found is not None
    assert found.children["interface_name"].scalar == "position"
    assert [item.scalar for item in found.children["joints"].items] == ["hip"]


@pytest.mark.parametrize(
    ("nodes", "gets"),
    [
        ("/robot/arm", True),
        ("/robot/*", True),
        ("/robot/**", True),
        ("/*/arm", True),
        ("/**/arm", True),
        ("/**", True),
        ("arm", True),
        ("/other/arm", False),
        ("/*", False),
        ("/robot/other", False),
        ("/robot/*/arm", False),
    ],
)
def test_a_name_may_have_a_namespace_and_wildcards(nodes: str, gets: bool) -> None:
    manager = MANAGER.replace("controller_manager:", "/robot/controller_manager:")
    assert read(manager).names == ("arm",)
    found = values(f"{manager}\n{nodes}:\n  ros__parameters: {{a: 1}}\n")
    assert found == ({"a": 1} if gets else None)


def test_a_namespace_is_a_level_of_the_text_too() -> None:
    text = "robot:\n" + "\n".join(f"  {line}" for line in (MANAGER + OWN).splitlines())
    assert read(text).names == ("arm",)
    assert values(text) == {"joints": ["hip"], "interface_name": "position"}


def test_dots_are_levels_and_what_is_later_overrides() -> None:
    text = MANAGER + (
        "/**:\n  ros__parameters: {a: {b: 1, c: 2}, use_sim_time: true}\n"
        "arm:\n  ros__parameters:\n    a.b: 3\n    a: {d.e: 4}\n    f.g: [x]\n"
    )
    assert values(text) == {
        "a": {"b": 3, "c": 2, "d": {"e": 4}},
        "use_sim_time": True,
        "f": {"g": ["x"]},
    }
    later = text + "\n/*:\n  ros__parameters: {a.b: 5}\n"
    assert values(later)["a"]["b"] == 5


def test_later_files_override_and_errors_name_file_and_line(tmp_path: Path) -> None:
    first, second = tmp_path / "a.yaml", tmp_path / "b.yaml"
    first.write_text(MANAGER + OWN)
    second.write_text("controller_manager:\n  ros__parameters:\n    update_rate: 0\n")
    config = ControllerConfig.from_files([first, second])
    with raises_naming(ConfigError, f"{second}:3", "update_rate", "above 0"):
        _ = config.control_period
    assert read(MANAGER).control_period == 1 / 250
    assert read(OWN).control_period is None


def test_substitutions_of_launch_files_are_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PART", "knee")
    monkeypatch.delenv("NOTHING", raising=False)
    file = tmp_path / "a.yaml"
    file.write_text(
        "arm:\n  ros__parameters:\n    joints: [$(var tf_prefix)hip]  # $(var b)\n"
        "    # $(var c)\n    rate: $(var rate 5)\n"
        "    $(env PART).p: '$(env NOTHING x)'\n"
        "    path: $(find-pkg-share tool0_description)/a\n"
    )
    variables = {"tf_prefix": "left_"}
    config = ControllerConfig.from_files(file, variables)
    (arm,) = config.parameters().values()
    parameters = arm["ros__parameters"]
    assert parameters.pop("path").endswith("tool0_description/a")
    assert parameters == {"joints": ["left_hip"], "rate": 5, "knee.p": "x"}


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        ("$(var tf_prefx)", ("'tf_prefx'", "did you mean 'tf_prefix'")),
        ("$(env NOTHING)", ("'NOTHING' is not set",)),
        ("$(find-pkg-share no_such_package)", ("no_such_package",)),
    ],
)
def test_an_unknown_substitution_is_an_error_with_its_line(
    tmp_path: Path, written: str, shown: tuple[str, ...]
) -> None:
    file = tmp_path / "a.yaml"
    file.write_text(f"arm:\n  ros__parameters:\n    joint: {written}hip\n")
    with raises_naming(ConfigError, f"{file}:3", written, *shown):
        ControllerConfig.from_files(file, {"tf_prefix": ""})


def test_a_yaml_for_ros_1_has_no_substitutions(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("arm: {joint: $(var nothing)hip}\n")
    config = ControllerConfig.from_files(file)
    assert config.parameters() == {"arm": {"joint": "$(var nothing)hip"}}


def test_a_rate_is_an_integer() -> None:
    with raises_naming(ConfigError, ":4", "a whole number, got 250.5"):
        _ = read(MANAGER.replace("250", "250.5")).control_period


# ---- the linter ----------------------------------------------------------------------


def findings(text: str) -> list[tuple[int | None, str, str, str]]:
    return [
        (f.location.line, f.rule, f.severity, f.remedy)
        for f in lint(read(text).tree, ["hip", "knee"])
    ]


GRIPPER = """\
controller_manager:
  ros__parameters:
    hand: {type: parallel_gripper_action_controller/GripperActionController}
hand:
  ros__parameters:
    joint: hip
    goal_tolerance: 0.01
    allow_stalling: true
"""


def test_a_good_file_has_no_findings() -> None:
    assert findings(MANAGER + OWN) == findings(GRIPPER) == []


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("0.01", "1", (7, "wrong-type", "error", "write 1.0")),
        ("tolerance", "tolerence", (7, "unread-key", "error", "did you mean 'g")),
        (
            "allow_stalling: t",
            "gains.hip.p: 1.0 #",
            (8, "misplaced-key", "warning", ""),
        ),
        ("allow_stalling: t", "colour: red #", (8, "unread-key", "warning", "remove")),
        ("\nhand:", "\nhamd:", (4, "no-controller", "error", "did you mean 'hand'")),
        ("\nhand:", "\n/a/hand:", (4, "no-controller", "error", "namespace")),
        ("    hand:", "    update_rat: 5\n    hand:", (3, "unread-key", "error", "'")),
    ],
)
def test_what_no_node_reads_is_reported_where_it_stands(
    old: str, new: str, expected: tuple[int, str, str, str]
) -> None:
    assert old in GRIPPER
    (found,) = findings(GRIPPER.replace(old, new, 1))
    assert found[:3] == expected[:3]
    assert expected[3] in found[3]


def test_common_parameters_and_wildcards_are_no_fault() -> None:
    text = "/**:\n  ros__parameters: {use_sim_time: true, update_rate: 100}\n"
    assert findings(text + GRIPPER) == []
