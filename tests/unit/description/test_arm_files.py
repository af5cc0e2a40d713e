"""Your own arm as a folder: what is wrong in it is reported with file and line."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from tool0.description.arm_files import ARM_FILES, check_arm_files
from tool0.description.catalogue import arms, find_part
from tool0.description.forward_kinematics import link_pose
from tool0.description.loading import assemble, named_poses, part_names
from tool0.description.shapes import Cylinder, Mesh
from tool0.errors import DescriptionError, LimitsError, ModelError, Tool0Error

MODEL = "ur5e"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a copy of a built-in arm's folder."""
    return Path(shutil.copytree(find_part("arm", MODEL).folder, tmp_path / "my_arm"))


def edit(file: Path, old: str, new: str) -> int:
    """Replace the one place of ``old``; return its line, counted from 1."""
    before, found, after = file.read_text(encoding="utf-8").partition(old)
    assert found, f"no {old!r} in {file.name}"
    file.write_text(before + new + after, encoding="utf-8")
    return before.count("\n") + 1


@pytest.mark.parametrize("name", arms())
def test_the_built_in_arms_are_complete(name: str) -> None:
    arm = find_part("arm", name)
    files = {what: arm.file(f"{what}.yaml") for what in ARM_FILES}
    assert all(file.is_file() for file in files.values())
    check_arm_files(files)


def test_a_folder_of_your_own_is_an_arm(folder: Path) -> None:
    edit(folder / "default_kinematics.yaml", "x: -0.425", "x: -0.5")
    theirs, ours = assemble(MODEL), assemble(str(folder))
    (robot,) = ours.robots
    assert (robot.title, ours.model.name) == ("my_arm + 2f85", "my_arm_robot")
    x = [
        link_pose(item.model, {}, "forearm_link").position[0] for item in (theirs, ours)
    ]
    assert x[1] - x[0] == pytest.approx(0.075)
    assert named_poses(ours) == named_poses(theirs)
    assert part_names(ours) == part_names(theirs)


def test_meshes_lie_in_the_folder(folder: Path) -> None:
    """Without ``package://``, a path starts at the folder, as in a file given alone."""
    theirs = next(
        visual.geometry.path
        for visual in assemble().model.link("wrist_3_link").visuals
        if isinstance(visual.geometry, Mesh)
    )
    (folder / "meshes").mkdir()
    shutil.copy(theirs, folder / "meshes" / "mine.stl")
    looks = folder / "visual_parameters.yaml"
    looks.write_text(
        re.sub(r'mesh: "[^"]*"', "mesh: meshes/mine.stl", looks.read_text())
    )
    for description in (
        assemble(str(folder)),
        assemble(MODEL, visual_params=looks),
    ):
        paths = {
            shape.geometry.path
            for link in description.model.links
            for shape in link.visuals
            if isinstance(shape.geometry, Mesh)
        }
        assert folder / "meshes" / "mine.stl" in paths


MISTAKES: dict[str, tuple[str, str, str, type[Tool0Error], str]] = {
    "a negative mass": (
        "physical_parameters", "forearm_mass: 2.846", "forearm_mass: -2.846",
        ModelError, "'forearm_link' has mass -2.846 kg",
    ),
    "no mass": (
        "physical_parameters", "wrist_1_mass: 1.37", "wrist_mass: 1.37",
        DescriptionError,
        "'inertia_parameters' has no key 'wrist_1_mass'; did you mean 'wrist_mass'?",
    ),
    "an impossible inertia": (
        "physical_parameters", "izz: 0.00666", "izz: 0.3",
        ModelError, "triangle inequality",
    ),
    "a moment without a number": (
        "physical_parameters", "izz: 0.00666", "izz: heavy",
        DescriptionError, "'inertia_parameters.tensor.shoulder.izz' must be a number",
    ),
    "a missing link": (
        "default_kinematics", "  wrist_2:", "  wrist2:",
        DescriptionError, "unknown key 'kinematics.wrist2'; did you mean 'wrist_2'?",
    ),
    "a missing coordinate": (
        "default_kinematics", "x: -0.425, ", "",
        DescriptionError, "'kinematics.forearm' has no key 'x'",
    ),
    "text for a number": (
        "default_kinematics", "x: -0.425", "x: long",
        DescriptionError, "'kinematics.forearm.x' must be a number, got 'long'",
    ),
    "not a number": (
        "default_kinematics", "x: -0.425", "x: .nan",
        DescriptionError, "'kinematics.forearm.x' must be a finite number",
    ),
    "a missing joint": (
        "joint_limits", "  wrist_1:", "  wrist_4:",
        DescriptionError, "unknown key 'joint_limits.wrist_4'",
    ),
    "an unknown key": (
        "joint_limits", "max_velocity:", "max_velocty:",
        DescriptionError, "did you mean 'max_velocity'?",
    ),
    "limits in the wrong order": (
        "joint_limits", "min_position: !degrees -360", "min_position: !degrees 400",
        LimitsError, "'shoulder_pan_joint': lower limit",
    ),
    "no speed": (
        "joint_limits", "max_velocity: !degrees 180.0", "max_velocity: 0",
        LimitsError, "need velocity > 0",
    ),
    "an angle in words": (
        "joint_limits", "!degrees 180.0", "!degrees half_a_turn",
        DescriptionError, "half_a_turn",
    ),
    "a shape without size": (
        "visual_parameters", "radius: 0.0745", "radius: 0",
        ModelError, "cylinder.radius' must be above zero",
    ),
    "an unknown shape": (
        "visual_parameters", "{cylinder: {", "{cylindr: {",
        DescriptionError, "did you mean 'cylinder'?",
    ),
    "an unknown joint in a pose": (
        "poses", "elbow_joint: ", "elbow: ",
        DescriptionError, "unknown key 'poses.home.elbow'; did you mean 'elbow_joint'?",
    ),
    "a payload below zero": (
        "specifications", "payload: 5.0", "payload: -5.0",
        ModelError, "'specifications.payload' must be above zero, got -5.0",
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_reported_with_its_line(mistake: str, folder: Path) -> None:
    name, old, new, kind, message = MISTAKES[mistake]
    file = folder / f"{name}.yaml"
    if not file.exists():
        shutil.copy(find_part("arm", MODEL).file(file.name), file)
    line = edit(file, old, new)
    if "has no key" in message:  # the line of the mapping that lacks it
        mapping = message.split("'")[1].rpartition(".")[2]
        line = 1 + file.read_text().partition(f"{mapping}:")[0].count("\n")
    with pytest.raises(kind) as caught:
        assemble(str(folder))
    assert str(caught.value).startswith(f"{file}:{line}: ")
    assert message in str(caught.value)


def test_a_mistake_in_a_file_given_alone_is_reported_too(folder: Path) -> None:
    line = edit(folder / "default_kinematics.yaml", "x: -0.425", "x: long")
    with pytest.raises(DescriptionError) as caught:
        assemble(MODEL, kinematics_params=folder / "default_kinematics.yaml")
    assert f"default_kinematics.yaml:{line}: " in str(caught.value)


def test_numbers_that_yaml_takes_for_text_are_numbers(folder: Path) -> None:
    edit(folder / "default_kinematics.yaml", "y: -0.0997, z: 0", "y: -0.0997, z: 2e-05")
    origin = assemble(str(folder)).model.joint("wrist_2_joint").origin
    assert origin.xyz[2] == 2e-5


@pytest.mark.parametrize("file", ["default_kinematics.yaml", "visual_parameters.yaml"])
def test_a_missing_file_is_named(file: str, folder: Path) -> None:
    (folder / file).unlink()
    with pytest.raises(DescriptionError) as caught:
        assemble(str(folder))
    assert file in str(caught.value)
    assert str(folder) in str(caught.value)


@pytest.mark.parametrize("name", arms())
def test_the_pedestal_is_as_wide_as_the_base(name: str) -> None:
    model = assemble(name, gripper=None).model
    base = model.link("base_link_inertia").collisions[0].geometry
    column = model.link("pedestal").collisions[0].geometry
    assert isinstance(base, Cylinder)
    assert isinstance(column, Cylinder)
    assert column.radius == base.radius
