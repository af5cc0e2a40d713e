"""Built-in robots are expanded once; robots with other files are read each time."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import cast

from tool0.description.catalogue import shared_folder
from tool0.description.config import DescriptionConfig
from tool0.description.loading import assemble, load_description
from tool0.description.packages import BUNDLED, preferring
from tool0.description.robot import RobotDescription

MASS = "  forearm_mass: 2.846\n"


def forearm_mass(description: RobotDescription) -> float:
    links = {link.name: link for link in description.model.links}
    inertial = links["forearm_link"].inertial
    assert inertial is not None
    return inertial.mass


def test_a_built_in_robot_is_expanded_once_for_the_same_arguments() -> None:
    first, again = assemble("ur5e"), assemble("ur5e")
    assert again.model is first.model
    assert assemble("ur5e", base_xyz=(0.1, 0.0, 0.0)).model is not first.model


def test_a_change_of_one_description_does_not_change_the_next() -> None:
    first = assemble("ur5e")
    arguments = dict(first.arguments)
    cast(dict[str, str], first.arguments)["arm"] = "other"
    assert assemble("ur5e").arguments == arguments


def test_a_cell_leaves_the_links_of_its_robots_in_their_documents() -> None:
    config = DescriptionConfig(robots=["a=ur5", "b=ur5@1,0,0"])
    assert load_description(config).urdf == load_description(config).urdf


def test_your_own_arm_is_read_again_after_a_change(tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    shutil.copytree(shared_folder("arm") / "ur5e", folder)
    file = folder / "physical_parameters.yaml"
    before = file.read_text()
    assert MASS in before
    assert forearm_mass(assemble(str(folder))) == 2.846
    file.write_text(before.replace(MASS, "  forearm_mass: 2.5\n"))
    assert forearm_mass(assemble(str(folder))) == 2.5


def test_a_file_that_replaces_one_of_the_arm_is_read_again(tmp_path: Path) -> None:
    file = tmp_path / "masses.yaml"
    given = (shared_folder("arm") / "ur5e" / "physical_parameters.yaml").read_text()
    for mass in (2.0, 2.5):
        file.write_text(given.replace(MASS, f"  forearm_mass: {mass}\n"))
        assert forearm_mass(assemble("ur5e", physical_params=file)) == mass


def test_a_package_that_takes_precedence_is_read_each_time(tmp_path: Path) -> None:
    package = tmp_path / "tool0_description"
    shutil.copytree(BUNDLED / package.name, package)
    with preferring({package.name: package}):
        assert assemble("ur5e").model is not assemble("ur5e").model
