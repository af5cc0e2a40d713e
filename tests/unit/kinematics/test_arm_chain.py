"""Which joints are an arm, and where they carry its flange."""

from pathlib import Path

import numpy as np
import pytest
from arm_rig import old_model, only_chain, ur5

from tool0.description.forward_kinematics import link_pose
from tool0.description.loading import assemble, load_robot
from tool0.errors import ControlError, ModelError
from tool0.kinematics.chain import find_chains, fixed_transform, why_no_arm

TWO_ARMS = Path(__file__).parents[3] / "examples" / "cell" / "two_arms.urdf.xacro"


def test_it_is_the_kinematics_of_the_model() -> None:
    model = assemble("ur5").model
    chain = only_chain(model)
    q = np.random.default_rng(0).uniform(-3, 3, (20, 6))
    for row, found in zip(q, chain.forward(q).T_base_tip, strict=True):
        position = dict(zip(chain.joint_names, row.tolist(), strict=True))
        T = link_pose(model, position, chain.tip, chain.base).matrix
        np.testing.assert_allclose(found, T, atol=1e-12)


def test_the_jacobian_is_the_derivative() -> None:
    chain = ur5()
    rng = np.random.default_rng(1)
    q, qd, h = rng.uniform(-3, 3, (1, 6)), rng.normal(size=(1, 6)), 1e-6
    behind, ahead = (chain.forward(q + way * qd).T_base_tip[0] for way in (-h, h))
    linear, angular = np.split((chain.forward(q).jacobian @ qd[0])[0], 2)
    np.testing.assert_allclose(linear, (ahead - behind)[:3, 3] / (2 * h), atol=1e-8)
    spin = (ahead - behind)[:3, :3] / (2 * h) @ chain.forward(q).T_base_tip[0, :3, :3].T
    np.testing.assert_allclose(angular, [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-8)


def test_a_prefix_is_the_name_and_none_is_arm() -> None:
    assert list(find_chains(assemble("ur5").model)) == ["arm"]
    assert list(find_chains(assemble("ur5", prefix="left_").model)) == ["left"]


def test_two_arms_are_two() -> None:
    chains = find_chains(load_robot(TWO_ARMS).model)
    assert sorted(chains) == ["left", "right"]
    assert set(chains["left"].joint_names).isdisjoint(chains["right"].joint_names)


def test_the_joints_of_a_urdf_without_our_elements_are_found(tmp_path: Path) -> None:
    chain = only_chain(old_model(tmp_path))
    assert chain.joint_names == ("j1", "j2", "j3", "j4", "j5", "j6")
    assert (chain.base, chain.tip) == ("base_link", "tool0")


def test_what_is_missing_is_said(tmp_path: Path) -> None:
    path = tmp_path / "mine.urdf"
    path.write_text('<robot name="mine"><link name="a"/></robot>')
    model = load_robot(path).model
    assert find_chains(model) == {}
    assert "no link is called tool0" in why_no_arm(model)
    model = old_model(tmp_path, kind="fixed")
    assert find_chains(model) == {}
    assert "above 'tool0' are not 6 turning joints" in why_no_arm(model)


def test_links_that_move_apart_have_no_fixed_pose() -> None:
    model = assemble("ur5").model
    base = "robotiq_arg2f_base_link"
    T = fixed_transform(model, "tool0", base) @ fixed_transform(model, base, "tool0")
    np.testing.assert_allclose(T.matrix, np.eye(4), atol=1e-12)
    with pytest.raises(ControlError):
        fixed_transform(model, "tool0", "left_inner_finger_pad")
    with pytest.raises(ModelError):
        fixed_transform(model, "tool0", "tool")
