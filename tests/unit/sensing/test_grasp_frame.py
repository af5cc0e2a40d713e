"""What a gripper grips with, and where."""

from __future__ import annotations

import numpy as np
import pytest
from ur5_rig import TWO_ROBOTS

from tool0.description.catalogue import assemble, load_robot
from tool0.errors import ControlError
from tool0.sensing.grasp import grasp_frame, pad_links

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


def test_a_mounted_gripper_takes_its_frame_along() -> None:
    turned = assemble(
        mount_xyz=(0.0, 0.01, 0.02), mount_rpy=(0.0, 0.0, np.pi / 2)
    ).model
    frame = grasp_frame(turned, turned.grippers[0], 0.045, "tool0").matrix
    np.testing.assert_allclose(frame[:3, 3], (0.0, 0.01, 0.16183), atol=1e-5)
    np.testing.assert_allclose(frame[:3, 1], (-1.0, 0.0, 0.0), atol=1e-12)


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
