import shutil
import struct
from pathlib import Path

import make_meshes
import numpy as np
import pytest
import yaml
from arm_shapes import ARMS
from meshes.arm import STYLES, arm_shape
from meshes.arm_parameters import ArmParameters, read_parameters
from meshes.files import HEADER, PACKAGE, stl
from meshes.model import ModelShape
from meshes.solid import rounded, turned

from tool0.description.catalogue import find_part

pytestmark = pytest.mark.slow

BUNDLED = make_meshes.PACKAGE
SHAPES = {shape.name: shape for shape in make_meshes.model_shapes()}


def files_below(folder: Path) -> dict[str, bytes]:
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def corners(shape: ModelShape, link: str) -> np.ndarray:
    solids = [solid for part in shape.links[link].visual.values() for solid in part]
    return np.concatenate([solid.corners for solid in solids])


def test_the_script_reproduces_every_bundled_byte_and_nothing_else_lies_there(
    tmp_path: Path,
) -> None:
    make_meshes.main(["--output", str(tmp_path)])
    assert files_below(tmp_path / "meshes") == files_below(BUNDLED / "meshes")
    for name, shape in SHAPES.items():
        file = Path("config", shape.kind, name, "visual_parameters.yaml")
        assert (tmp_path / file).read_text() == (BUNDLED / file).read_text()


def test_your_own_arm_gets_its_meshes_in_its_folder(tmp_path: Path) -> None:
    folder = tmp_path / "my_arm"
    shutil.copytree(BUNDLED / "config" / "arms" / "ur5e", folder)
    make_meshes.main([str(folder)])
    looks = yaml.safe_load((folder / "visual_parameters.yaml").read_text())
    meshes = {
        item["mesh"] for link in looks["links"].values() for item in link["visual"]
    }
    assert sorted(meshes) == sorted(
        f"meshes/{file.name}" for file in (folder / "meshes").iterdir()
    )


def test_the_parameters_name_every_mesh_and_known_materials() -> None:
    named: set[Path] = set()
    for name, shape in SHAPES.items():
        file = BUNDLED / "config" / shape.kind / name / "visual_parameters.yaml"
        parameters = yaml.safe_load(file.read_text())
        entries = [e for link in parameters["links"].values() for e in link["visual"]]
        named |= {BUNDLED / e["mesh"].removeprefix(f"{PACKAGE}/") for e in entries}
        assert {e["material"] for e in entries} == set(parameters["materials"])
    assert named == set((BUNDLED / "meshes").rglob("*.stl"))


def test_the_meshes_stay_light() -> None:
    for name, shape in SHAPES.items():
        assert sum(len(corners(shape, link)) for link in shape.links) <= 7_000, name
    meshes = list((BUNDLED / "meshes").glob("ur*/**/*.stl"))
    assert 1_000_000 < sum(file.stat().st_size for file in meshes) <= 3_000_000


def test_stl_bytes_are_those_of_the_format() -> None:
    solid = turned(rounded(0.05, 0.0, 0.1))
    data = stl([solid, solid])
    assert data[:80] == HEADER
    assert not data.startswith(b"solid")  # readers would take it for text
    (count,) = struct.unpack("<I", data[80:84])
    assert count == 2 * len(solid.triangles)
    assert len(data) == 84 + 50 * count
    values = np.array(struct.unpack("<12f", data[84 : 84 + 48])).reshape(4, 3)
    normal, a, b, c = values
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-3)
    assert np.dot(np.cross(b - a, c - a), normal) > 0


@pytest.mark.parametrize("model", SHAPES)
def test_every_mesh_is_finite_closed_and_without_slivers_of_no_area(
    model: str,
) -> None:
    for link in SHAPES[model].links.values():
        for solids in link.visual.values():
            for solid in solids:
                a, b, c = solid.corners.transpose(1, 0, 2)
                areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
                assert np.isfinite(solid.vertices).all()
                assert areas.min() > 0
                assert solid.volume > 0
                assert np.abs(np.cross(b - a, c - a).sum(axis=0)).max() < 1e-12


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_an_arm_is_as_long_as_its_kinematics(arm: ArmParameters) -> None:
    shape = arm_shape(arm)
    for link, length in (("upper_arm", arm.a2), ("forearm", arm.a3)):
        x = corners(shape, link)[..., 0]
        reach = 1.3 * arm.shoulder_radius
        assert length < -x.min() < length + reach
        assert 0 < x.max() < reach
    assert corners(shape, "base")[..., 2].min() == 0.0
    assert corners(shape, "wrist_3")[..., 2].max() == pytest.approx(0.0, abs=1e-3)


def test_the_arms_have_their_sizes_and_generations() -> None:
    for name, arm in ARMS.items():
        reach = find_part("arm", name).load("specifications")["reach"]
        assert arm.a2 + arm.a3 + arm.d5 == pytest.approx(reach, rel=0.1)
        assert arm.forearm_radius < arm.upper_arm_radius < arm.shoulder_radius
        assert arm.flange_radius < arm.wrist_radius < arm.elbow_radius
        assert arm.elbow_radius < arm.shoulder_radius < arm.foot_radius
    colours = {tuple(style.materials.values()) for style in STYLES.values()}
    assert len(colours) == len({arm.style for arm in ARMS.values()}) == len(STYLES)


def test_the_kinematics_in_the_folder_move_the_shapes(tmp_path: Path) -> None:
    folder = Path(
        shutil.copytree(BUNDLED / "config" / "arms" / "ur5", tmp_path / "arm")
    )
    file = folder / "default_kinematics.yaml"
    file.write_text(file.read_text().replace("x: -0.425", "x: -0.6"))
    shape = arm_shape(read_parameters(folder))
    assert corners(shape, "upper_arm")[..., 0].min() < -0.6


@pytest.mark.parametrize("model", SHAPES)
def test_collision_primitives_are_few(model: str) -> None:
    most = 3 if SHAPES[model].kind == "arms" else 2
    for link in SHAPES[model].links.values():
        assert 1 <= len(link.collision) <= most
