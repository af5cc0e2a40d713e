"""What a gripper grips with, and where."""

from __future__ import annotations

import numpy as np
import pytest
from ur5_rig import TWO_ROBOTS

import tool0
from tool0.description.grasp_frames import flange_of, grasp_frame, pad_links
from tool0.description.loading import assemble, load_robot
from tool0.errors import ControlError, ModelError

UR5 = assemble()
MODEL = UR5.model


def test_the_pads_are_the_links_with_a_surface() -> None:
    assert pad_links(MODEL, MODEL.grippers[0]) == (
        "left_inner_finger_pad",
        "right_inner_finger_pad",
    )


@pytest.mark.parametrize(("opening", "z"), [(0.085, 0.13076), (0.045, 0.14183)])
def test_the_frame_between_them(opening: float, z: float) -> None:
    # z: 87.3 + 37.6 sin q + 43.0 cos q [mm] above the base, which sits on tool0
    frame = grasp_frame(MODEL, MODEL.grippers[0], opening, "tool0").matrix
    np.testing.assert_allclose(frame[:3, 3], (0.0, 0.0, z), atol=1e-5)
    np.testing.assert_allclose(frame[:3, :3], np.eye(3), atol=1e-12)


def test_the_tcp_of_a_gripper_is_that_frame() -> None:
    with tool0.bringup(realtime=False) as robot:
        gripper = robot.gripper
        heights = [gripper.tcp(opening).position[2] for opening in (0.085, 0.03, 0.0)]
        assert heights == pytest.approx([0.13076, 0.14363, 0.14419], abs=1e-5)
        gripper.move(opening=0.05)
        robot.run(2.0)
        pads = [
            robot.pose(link).position for link in pad_links(MODEL, MODEL.grippers[0])
        ]
        between = (robot.pose("tool0") @ gripper.tcp()).position
        np.testing.assert_allclose(between, np.mean(pads, axis=0), atol=1e-4)
        base = gripper.tcp(0.03, relative_to="robotiq_arg2f_base_link")
        assert base.position[2] == pytest.approx(0.14363, abs=1e-5)
        with pytest.raises(ModelError):
            gripper.tcp(0.09)


def test_the_tcp_is_relative_to_the_flange_of_the_gripper() -> None:
    model = load_robot(TWO_ROBOTS).model
    flanges = [flange_of(model, gripper) for gripper in model.grippers]
    assert len(set(flanges)) == 2
    assert all(flange.endswith("tool0") for flange in flanges)


def test_a_mounted_gripper_takes_its_frame_along() -> None:
    turned = assemble(
        mount_xyz=(0.0, 0.01, 0.02), mount_rpy=(0.0, 0.0, np.pi / 2)
    ).model
    frame = grasp_frame(turned, turned.grippers[0], 0.045, "tool0").matrix
    np.testing.assert_allclose(frame[:3, 3], (0.0, 0.01, 0.16183), atol=1e-5)
    np.testing.assert_allclose(frame[:3, 1], (-1.0, 0.0, 0.0), atol=1e-12)


@pytest.mark.slow
def test_each_of_two_grippers_has_its_own() -> None:
    model = load_robot(TWO_ROBOTS).model
    pads = {pad_links(model, gripper) for gripper in model.grippers}
    assert len(pads) == len(model.grippers) == 2


def test_a_gripper_without_pads() -> None:
    import dataclasses

    bare = dataclasses.replace(
        MODEL,
        links=tuple(dataclasses.replace(link, surface=None) for link in MODEL.links),
    )
    with pytest.raises(ControlError) as caught:
        pad_links(bare, bare.grippers[0])
    assert "'robotiq_arg2f_base_link'" in str(caught.value)
