"""Grippers as folders: the built-in ones, and what is wrong in your own."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tool0.description.catalogue import find_part, grippers
from tool0.description.gripper_files import GRIPPER_FILES, check_gripper_files
from tool0.description.loading import assemble, named_poses, part_names
from tool0.description.model import ROBOTIQ, LinearOpening, RotaryOpening
from tool0.errors import DescriptionError, LimitsError, ModelError, Tool0Error

MASSES = {"2f85": 0.92086, "2f140": 1.025, "hande": 0.93995}
"""[kg]"""
LINKAGES = ("2f85", "2f140")
PAGE = Path(__file__).parents[3] / "docs/how-to/own-robot.md"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a copy of a built-in gripper's folder."""
    return Path(
        shutil.copytree(find_part("gripper", "hande").folder, tmp_path / "jaws")
    )


@pytest.mark.parametrize("name", grippers())
def test_the_built_in_grippers_are_complete(name: str) -> None:
    part = find_part("gripper", name)
    files = {what: part.folder / f"{what}.yaml" for what in GRIPPER_FILES}
    missing = {what for what, file in files.items() if not file.is_file()}
    assert missing == (set() if name in LINKAGES else {"linkage"})
    check_gripper_files(files)
    assert part.load("specifications")["unsourced"]


@pytest.mark.parametrize("name", grippers())
def test_limits_speeds_and_forces_agree(name: str) -> None:
    model = assemble(gripper=name).model
    (gripper,) = model.grippers
    joint = model.joint(gripper.joint)
    ends = [gripper.position(opening) for opening in (gripper.max_opening, 0.0)]
    assert joint.limits.lower <= ends[0] < ends[1] <= joint.limits.upper
    levers = [gripper.lever(position) for position in ends]
    fastest = gripper.speed[1] / min(levers)
    assert joint.limits.velocity == pytest.approx(fastest, rel=0.02)
    strongest = gripper.force[1] * max(levers)
    assert joint.limits.effort == pytest.approx(strongest, rel=0.01)
    base = joint.parent
    mass = sum(
        link.inertial.mass
        for link in map(model.link, model.links_from(base))
        if link.inertial
    )
    assert mass == pytest.approx(MASSES[name], abs=1e-4)


@pytest.mark.parametrize("name", grippers())
def test_poses_and_names_are_those_of_the_gripper(name: str) -> None:
    description = assemble(gripper=name)
    (gripper,) = description.model.grippers
    for pose, share in {"open": 1.0, "half": 0.5, "closed": 0.0}.items():
        ((joint, position),) = (
            item
            for item in named_poses(description)[pose].items()
            if item[0] == gripper.joint
        )
        wanted = share * gripper.max_opening
        assert gripper.opening(position) == pytest.approx(wanted, abs=1.1e-3)
        assert joint == gripper.joint
    base = description.model.joint(gripper.joint).parent
    joints = {j.name for j in description.model.movable_joints}
    beyond = set(description.model.links_from(base))
    names = part_names(description)
    assert beyond <= names.keys()
    assert joints <= names.keys()


@pytest.mark.parametrize("name", grippers())
def test_the_law_gives_the_distance_of_the_pads(name: str) -> None:
    from tool0.description.forward_kinematics import link_poses
    from tool0.description.grasp_frames import grasp_frame, pad_links

    model = assemble(gripper=name).model
    (gripper,) = model.grippers
    kind = LinearOpening if name == "hande" else RotaryOpening
    assert isinstance(gripper.law, kind)
    pads = pad_links(model, gripper)
    thick = model.link(pads[0]).collisions[0].geometry.size[1]  # type: ignore[union-attr]
    for share in (0.0, 0.3, 0.7, 1.0):
        opening = share * gripper.max_opening
        found = link_poses(model, {gripper.joint: gripper.position(opening)})
        left, right = (found[pad].matrix for pad in pads)
        apart = float((right[:3, 3] - left[:3, 3]) @ -left[:3, 1]) - thick
        assert apart == pytest.approx(opening, abs=1e-9)
        z = grasp_frame(model, gripper, opening, "tool0").rotation[2][2]
        assert z == pytest.approx(1.0)


def test_a_folder_of_your_own_is_a_gripper(folder: Path) -> None:
    file = folder / "joint_limits.yaml"
    file.write_text(file.read_text().replace("max_opening: 0.050", "max_opening: 0.04"))
    description = assemble(gripper=str(folder))
    (robot,) = description.robots
    assert robot.title == "ur5 + jaws"
    (gripper,) = description.model.grippers
    assert gripper.max_opening == 0.04
    assert named_poses(description) == named_poses(assemble(gripper="hande"))


def page_rows() -> Iterator[tuple[list[str], str]]:
    """Yield the files and the last cell of each row of the page's table."""
    section = PAGE.read_text(encoding="utf-8").partition("## A gripper\n")[2]
    for line in section.partition("\n## ")[0].splitlines():
        if line.startswith("| `"):
            files, _, condition = line.strip("|").split(" | ")
            yield re.findall(r"`([\w.]+)`", files), condition.strip()


def test_the_page_names_every_file_and_those_that_a_gripper_needs(
    folder: Path,
) -> None:
    built_in = {
        file.name
        for name in grippers()
        for file in find_part("gripper", name).folder.iterdir()
        if file.is_file()
    }
    assert {file for files, _ in page_rows() for file in files} == built_in
    for files, condition in page_rows():
        for file in files:
            if condition != "required":
                (folder / file).unlink(missing_ok=True)
                continue
            assert assemble(gripper=str(folder)).model.grippers
            hidden = (folder / file).rename(folder / "hidden")
            with pytest.raises(Tool0Error):
                assemble(gripper=str(folder))
            hidden.rename(folder / file)
    assert assemble(gripper=str(folder)).model.grippers


def test_a_gripper_speaks_the_protocol_that_its_folder_names(folder: Path) -> None:
    def protocol(gripper: str) -> str | None:
        return assemble(gripper=gripper).model.grippers[0].protocol

    assert {protocol(name) for name in grippers()} == {ROBOTIQ}
    assert protocol(str(folder)) == ROBOTIQ
    file = folder / "joint_limits.yaml"
    named = file.read_text(encoding="utf-8")
    for key in ("", "protocol: ", "protocol: null"):
        file.write_text(named.replace("protocol: robotiq", key), encoding="utf-8")
        assert protocol(str(folder)) is None


MISTAKES: dict[str, tuple[str, str, str, type[Tool0Error], str]] = {
    "a negative mass": (
        "physical_parameters", "mass: 0.03804", "mass: -0.03804",
        ModelError, "'finger' has mass -0.03804 kg",
    ),
    "an inertia that no body has": (
        "physical_parameters", "ixx: 1.5784e-05", "ixx: 1.5784e-03",
        ModelError, "physically impossible inertia of link 'finger'",
    ),
    "no inertia": (
        "physical_parameters", "ixx: 1.5784e-05", "ix: 1.5784e-05",
        DescriptionError, "unknown key 'inertia_parameters.finger.tensor.ix'",
    ),
    "no reduction": (
        "physical_parameters", "drive:\n  mechanical_", "drive:\n  ",
        DescriptionError,
        "'drive' has no key 'mechanical_reduction'; did you mean 'reduction'?",
    ),
    "a negative damping": (
        "physical_parameters", "damping: 45.0", "damping: -45.0",
        ModelError, "'drive.damping' must be zero or above, got -45.0",
    ),
    "limits the wrong way round": (
        "joint_limits", "min_position: 0.0", "min_position: 0.03",
        LimitsError, "joint 'hande_left_finger_joint': lower limit 0.03 is above",
    ),
    "forces the wrong way round": (
        "joint_limits", "min_force: 60.0", "min_force: 160.0",
        ModelError, "'grip.min_force' must be at most max_force, 130, got 160.0",
    ),
    "an unknown protocol": (
        "joint_limits", "protocol: robotiq", "protocol: robotik",
        DescriptionError, "unknown gripper protocol 'robotik'; tool0 has robotiq",
    ),
    "a protocol that is no name": (
        "joint_limits", "protocol: robotiq", "protocol: [robotiq]",
        DescriptionError, "'grip.protocol' must be the name of a protocol, got a list",
    ),
    "no stroke": (
        "joint_limits", "max_opening: 0.050", "max_openig: 0.050",
        DescriptionError,
        "unknown key 'grip.max_openig'; did you mean 'max_opening'?",
    ),
    "no number": (
        "joint_limits", "max_speed: 0.150", "max_speed: fast",
        DescriptionError, "'grip.max_speed' must be a number, got",
    ),
    "a flat pad": (
        "kinematics", "pad_size: [0.022, 0.006", "pad_size: [0.022, 0.0",
        ModelError, "'kinematics.pad_size' must be sizes above zero",
    ),
    "an unknown shape": (
        "visual_parameters", "{cylinder: {radius", "{cilinder: {radius",
        DescriptionError, "a shape begins with",
    ),
    "a pose that is no number": (
        "poses", "{hande_left_finger_joint: 0.0125}", "{hande_left_finger_joint: x}",
        DescriptionError, "'poses.half.hande_left_finger_joint' must be a number",
    ),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_is_reported_with_file_and_line(
    folder: Path, mistake: tuple[str, str, str, type[Tool0Error], str]
) -> None:
    name, old, new, kind, message = mistake
    file = folder / f"{name}.yaml"
    before, found, after = file.read_text(encoding="utf-8").partition(old)
    assert found
    file.write_text(before + new + after, encoding="utf-8")
    with pytest.raises(kind) as caught:
        assemble(gripper=str(folder))
    assert message in str(caught.value)
    assert f"{file}:{before.count(chr(10)) + 1}" in str(caught.value)


def test_a_key_that_the_macro_misses_is_reported_with_its_file(folder: Path) -> None:
    file = folder / "kinematics.yaml"
    file.write_text(file.read_text().replace("  pad: {", "  pads: {"))
    with pytest.raises(DescriptionError) as caught:
        assemble(gripper=str(folder))
    assert "has no key 'pad'; did you mean 'pads'?" in str(caught.value)
    assert f"{file}:" in str(caught.value)


def test_a_folder_without_a_macro_is_no_gripper(folder: Path) -> None:
    (folder / "macro.xacro").unlink()
    with pytest.raises(
        DescriptionError, match=r"jaws': there is no macro\.xacro; give a"
    ):
        assemble(gripper=str(folder))


@pytest.mark.parametrize(
    ("name", "nearest"), [("2f-140", "2f140"), ("hand-e", "hande"), ("2f_85", "2f85")]
)
def test_an_unknown_gripper_is_refused_with_the_nearest_name(
    name: str, nearest: str
) -> None:
    with pytest.raises(DescriptionError) as caught:
        assemble(gripper=name)
    assert f"unknown gripper '{name}'; did you mean '{nearest}'?" in str(caught.value)


def test_only_linkages_have_the_linkage_model() -> None:
    for name in LINKAGES:
        assert assemble(gripper=name, gripper_model="linkage").model.loops
    with pytest.raises(DescriptionError) as caught:
        assemble(gripper="hande", gripper_model="linkage")
    assert "'hande' are no linkages" in str(caught.value)
    assert "grippers with this model: 2f140, 2f85" in str(caught.value)
