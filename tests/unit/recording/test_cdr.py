"""Messages packed by hand equal those of rosbags, byte for byte, and are read back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from tool0.recording.cdr import (
    JointStates,
    Points,
    Transforms,
    Wrenches,
    decode_text,
    encode_text,
)
from tool0.recording.message_types import (
    JOINT_STATE,
    POINTS,
    TEXT,
    TRANSFORMS,
    WRENCH,
    message,
    stamp_of,
    typestore,
)

TIME = 12_345_678_901  # [ns]
TYPES = typestore().types


def header(frame: str) -> Any:
    return TYPES["std_msgs/msg/Header"](stamp=stamp_of(TIME), frame_id=frame)


def vector(kind: str, values: Sequence[float]) -> Any:
    return TYPES[f"geometry_msgs/msg/{kind}"](*values)


@pytest.mark.parametrize("names", [(), ("a",), ("elbow_joint", "b", "cc", "ddd")])
@pytest.mark.parametrize("has_effort", [True, False])
def test_joint_states(names: tuple[str, ...], has_effort: bool) -> None:
    rng = np.random.default_rng(seed=0)
    values = rng.normal(size=(3, len(names)))
    effort = values[2] if has_effort else values[2, :0]
    layout = JointStates(names, has_effort=has_effort)
    data = layout.encode(TIME, values[0], values[1], effort)
    assert data == message(
        JOINT_STATE,
        header=header(""),
        name=list(names),
        position=values[0],
        velocity=values[1],
        effort=effort,
    )
    position, velocity, read_effort = layout.arrays([data, data])
    np.testing.assert_array_equal(position, [values[0]] * 2)
    np.testing.assert_array_equal(velocity, [values[1]] * 2)
    np.testing.assert_array_equal(read_effort, [effort] * 2)


@pytest.mark.parametrize(
    "frames",
    [(), (("world", "a"),), (("world", "a"), ("w", "bcde"), ("x", "red cube, large"))],
)
def test_transforms(frames: tuple[tuple[str, str], ...]) -> None:
    poses = np.random.default_rng(seed=1).normal(size=(len(frames), 7)).tolist()
    layout = Transforms(frames)
    data = layout.encode(TIME, poses)
    items = [
        TYPES["geometry_msgs/msg/TransformStamped"](
            header=header(parent),
            child_frame_id=child,
            transform=TYPES["geometry_msgs/msg/Transform"](
                translation=vector("Vector3", pose[:3]),
                rotation=vector("Quaternion", pose[3:]),
            ),
        )
        for (parent, child), pose in zip(frames, poses, strict=True)
    ]
    assert data == message(TRANSFORMS, transforms=items)
    assert [array.tolist() for array in layout.arrays([data])] == [[p] for p in poses]


@pytest.mark.parametrize("frame", ["tool0", "left_tool0", "t"])
def test_wrenches(frame: str) -> None:
    layout = Wrenches(frame)
    values = [1.0, -2.0, 3.0, 4.0, 5.0, 6.0]
    data = layout.encode(TIME, values)
    wrench = TYPES["geometry_msgs/msg/Wrench"](
        force=vector("Vector3", values[:3]), torque=vector("Vector3", values[3:])
    )
    assert data == message(WRENCH, header=header(frame), wrench=wrench)
    assert layout.arrays([data]).tolist() == [values]


@pytest.mark.parametrize("frame", ["world", "base", "w"])
@pytest.mark.parametrize("n_points", [0, 1, 2])
def test_points(frame: str, n_points: int) -> None:
    layout = Points(frame, ("x", "y", "z", "force"), ("first", "second"))
    points = [(1.0, 2.0, 3.0, 4.0, 7, 8), (5.0, 6.0, 7.0, 8.0, 9, 10)][:n_points]
    data = layout.encode(TIME, points)
    names = ("x", "y", "z", "force", "first", "second")
    offsets, kinds = (0, 8, 16, 24, 32, 36), (8, 8, 8, 8, 6, 6)
    fields = [
        TYPES["sensor_msgs/msg/PointField"](name, offset, kind, 1)
        for name, offset, kind in zip(names, offsets, kinds, strict=True)
    ]
    raw = b"".join(
        np.array(p[:4]).tobytes() + np.array(p[4:], np.uint32).tobytes() for p in points
    )
    assert data == message(
        POINTS,
        header=header(frame),
        height=1,
        width=n_points,
        fields=fields,
        is_bigendian=False,
        point_step=40,
        row_step=40 * n_points,
        data=np.frombuffer(raw, np.uint8),
        is_dense=True,
    )
    assert layout.decode(data) == points


def test_text() -> None:
    text = "the elbow, 肘"
    data = encode_text(text.encode())
    assert data == message(TEXT, data=text)
    assert decode_text(data).decode() == text
