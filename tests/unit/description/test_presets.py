import itertools
from pathlib import Path

import pytest
import yaml

from tool0.description.catalogue import (
    arms,
    assemble,
    default_controllers,
    grippers,
    load_robot,
    named_poses,
    part_names,
)

FILES = ("controllers.yaml", "controllers_gripper_action.yaml")


def joints_named_in(text: str) -> set[str]:
    return {
        token.value
        for token in yaml.scan(text)
        if isinstance(token, yaml.ScalarToken) and token.value.endswith("_joint")
    }


@pytest.mark.parametrize("prefix", ["", "left_"])
def test_poses_place_driven_joints_within_their_limits(prefix: str) -> None:
    description = assemble(prefix=prefix)
    driven = set(description.model.transmission_by_joint)
    poses = named_poses(description)
    assert poses.keys() >= {"home", "ready", "up", "zero", "open", "half", "closed"}
    assert poses["home"].keys() == driven
    for pose in poses.values():
        for name, position in pose.items():
            assert name in driven
            assert description.model.joint(name).limits.clamp(position) == position


def test_gripper_poses_open_close_and_halve() -> None:
    description = assemble()
    (gripper,) = description.model.grippers
    opening = {
        name: gripper.opening(pose["finger_joint"])
        for name, pose in named_poses(description).items()
        if "finger_joint" in pose
    }
    assert opening["open"] >= gripper.max_opening
    assert opening["half"] == pytest.approx(gripper.max_opening / 2, abs=1e-6)
    assert opening["closed"] == pytest.approx(0, abs=1e-6)


def test_a_bare_arm_has_no_poses_of_a_gripper() -> None:
    poses = named_poses(assemble(gripper=None))
    assert "open" not in poses
    assert "finger_joint" not in poses["home"]


@pytest.mark.parametrize("file", FILES)
def test_controllers_name_the_driven_joints(file: str) -> None:
    description = assemble()
    text, location = default_controllers(description, file)
    assert location.file is not None
    assert location.file.name == file
    assert joints_named_in(text) == set(description.model.transmission_by_joint)
    assert list(yaml.safe_load(text)) == [
        "joint_state_controller",
        "eff_joint_traj_controller",
        "gripper_controller",
        "joint_group_eff_controller",
    ]


def test_a_bare_arm_has_only_the_arms_controllers() -> None:
    text, _ = default_controllers(assemble(gripper=None))
    assert "gripper_controller" not in yaml.safe_load(text)
    assert "finger_joint" not in joints_named_in(text)


@pytest.mark.parametrize("file", FILES)
def test_a_prefix_reaches_every_joint_and_moves_no_line(file: str) -> None:
    plain, _ = default_controllers(assemble(), file)
    text, _ = default_controllers(assemble(prefix="left_"), file)
    expected = {f"left_{name}" for name in joints_named_in(plain)}
    assert joints_named_in(text) == expected
    assert text.replace("left_", "") == plain


ROBOTS = [
    *itertools.product(arms(), [*grippers(), None], ["mimic"]),
    (arms()[0], grippers()[0], "linkage"),
]


@pytest.mark.parametrize("prefix", ["", "left_"])
@pytest.mark.parametrize(("arm", "gripper", "gripper_model"), ROBOTS)
def test_what_moves_or_is_seen_has_a_name_for_people(
    arm: str, gripper: str | None, gripper_model: str, prefix: str
) -> None:
    description = assemble(arm, gripper, prefix=prefix, gripper_model=gripper_model)
    model, names = description.model, part_names(description)
    seen = {link.name for link in model.links if link.visuals}
    assert names.keys() >= seen | {joint.name for joint in model.movable_joints}
    assert names.keys() <= model.link_by_name.keys() | model.joint_by_name.keys()
    for language in ("en", "zh"):
        called = [getattr(name, language) for name in names.values()]
        assert all(text.strip() for text in called)
        assert len(called) == len(set(called))


def test_the_arm_is_called_as_in_the_table_of_the_post() -> None:
    names = {part: name.zh for part, name in part_names(assemble()).items()}
    assert names["base_link"] == "底座"
    assert names["shoulder_pan_joint"] == "肩连杆与底座的关节"
    assert names["upper_arm_link"] == "上臂"
    assert names["wrist_3_joint"] == "腕关节3"
    assert names["tool0"].startswith("末端")


def test_a_robot_of_one_s_own_has_no_names_for_people(tmp_path: Path) -> None:
    path = tmp_path / "own.urdf"
    path.write_text(assemble(gripper=None).urdf)
    assert part_names(load_robot(path)) == {}
