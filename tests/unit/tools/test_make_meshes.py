import struct
from pathlib import Path

import make_meshes
import numpy as np
import pytest
import yaml
from meshes.arm import arm_shape
from meshes.arm_parameters import ARMS, UR5, ArmParameters
from meshes.files import HEADER, PACKAGE, stl
from meshes.gripper import (
    INNER_PIVOT,
    OUTER_FINGER,
    OUTER_KNUCKLE,
    OUTER_PIVOT,
    PAD,
    PAD_SIZE,
)
from meshes.model import Box, ModelShape
from meshes.solid import rounded, turned

pytestmark = pytest.mark.slow

BUNDLED = make_meshes.PACKAGE
MODELS = [*ARMS, "2f85"]


def files_below(folder: Path) -> dict[str, bytes]:
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file()
    }


def corners(shape: ModelShape, link: str) -> np.ndarray:
    solids = [solid for part in shape.links[link].visual.values() for solid in part]
    return np.concatenate([solid.corners for solid in solids])


def kind_of(model: str) -> str:
    return make_meshes.model_shape(model).kind


def test_the_script_reproduces_every_bundled_byte_and_nothing_else_lies_there(
    tmp_path: Path,
) -> None:
    make_meshes.main(["--output", str(tmp_path)])
    assert files_below(tmp_path / "meshes") == files_below(BUNDLED / "meshes")
    for model in make_meshes.BUNDLED:
        name = Path("config", kind_of(model), model, "visual_parameters.yaml")
        assert (tmp_path / name).read_text() == (BUNDLED / name).read_text()


def test_an_unknown_model_is_refused_with_the_names_there_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        make_meshes.main(["ur55", "--output", str(tmp_path)])
    assert "'ur55': need 2f85, ur3, ur5, ur10" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("model", make_meshes.BUNDLED)
def test_the_parameters_name_every_mesh_once_and_known_materials(model: str) -> None:
    file = BUNDLED / "config" / kind_of(model) / model / "visual_parameters.yaml"
    parameters = yaml.safe_load(file.read_text())
    entries = [e for link in parameters["links"].values() for e in link["visual"]]
    named = [BUNDLED / e["mesh"].removeprefix(f"{PACKAGE}/") for e in entries]
    assert sorted(named) == sorted((BUNDLED / "meshes" / model).rglob("*.stl"))
    assert {e["material"] for e in entries} == set(parameters["materials"])


def test_the_bundled_robot_stays_light() -> None:
    meshes = list((BUNDLED / "meshes").rglob("*.stl"))
    sizes = {file: (file.stat().st_size - 84) // 50 for file in meshes}
    assembled = sum(
        n * (2 if "2f85" in file.parts and not file.name.startswith("base_") else 1)
        for file, n in sizes.items()
    )
    assert assembled <= 12_000
    assert sum(file.stat().st_size for file in meshes) <= 700_000


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


@pytest.mark.parametrize("model", MODELS)
def test_every_mesh_is_finite_closed_and_without_slivers_of_no_area(
    model: str,
) -> None:
    for link in make_meshes.model_shape(model).links.values():
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


def test_an_arm_without_parameters_in_the_package_is_drawn_from_the_table(
    tmp_path: Path,
) -> None:
    make_meshes.main(["ur3", "ur10", "--output", str(tmp_path)])
    for model in ("ur3", "ur10"):
        assert len(list((tmp_path / "meshes" / model).rglob("*.stl"))) == 19
        assert (
            tmp_path / "config" / kind_of(model) / model / "visual_parameters.yaml"
        ).exists()


def test_the_kinematics_in_the_package_move_the_shapes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kinematics = Path("config", "arms", "ur5", "default_kinematics.yaml")
    changed = yaml.safe_load((BUNDLED / kinematics).read_text())
    changed["kinematics"]["forearm"]["x"] = -0.6
    (tmp_path / kinematics).parent.mkdir(parents=True)
    (tmp_path / kinematics).write_text(yaml.safe_dump(changed))
    monkeypatch.setattr(make_meshes, "PACKAGE", tmp_path)
    shape = make_meshes.model_shape("ur5")
    assert corners(shape, "upper_arm")[..., 0].min() < -0.6


def test_the_table_agrees_with_the_packages_parameters() -> None:
    folder = BUNDLED / "config" / "arms" / "ur5"
    physical = yaml.safe_load((folder / "physical_parameters.yaml").read_text())
    assert make_meshes.model_shape("ur5").links.keys() == arm_shape(UR5).links.keys()
    assert physical["offsets"]["shoulder_offset"] == UR5.shoulder_offset
    assert physical["offsets"]["elbow_offset"] == UR5.elbow_offset


def test_the_gripper_is_drawn_on_the_packages_joints() -> None:
    file = BUNDLED / "config" / "grippers" / "2f85" / "kinematics.yaml"
    joints = yaml.safe_load(file.read_text())["kinematics"]
    drawn = {
        "outer_knuckle": OUTER_PIVOT,
        "inner_knuckle": INNER_PIVOT,
        "outer_finger": OUTER_KNUCKLE,
        "inner_finger": OUTER_FINGER,
        "inner_finger_pad": PAD,
    }
    for name, (y, z) in drawn.items():
        assert (joints[name]["y"], joints[name]["z"]) == (y, z)
    assert tuple(joints["pad_size"]) == PAD_SIZE


def test_the_pad_touches_with_exactly_its_box() -> None:
    shape = make_meshes.model_shape("2f85")
    assert shape.links["inner_finger_pad"].collision == (Box(size=PAD_SIZE),)
    drawn = corners(shape, "inner_finger_pad").reshape(-1, 3)
    np.testing.assert_allclose(np.ptp(drawn, axis=0), PAD_SIZE, atol=2e-6)


@pytest.mark.parametrize("model", make_meshes.BUNDLED)
def test_collision_primitives_are_few(model: str) -> None:
    most = 2 if model == "2f85" else 3
    for link in make_meshes.model_shape(model).links.values():
        assert 1 <= len(link.collision) <= most
