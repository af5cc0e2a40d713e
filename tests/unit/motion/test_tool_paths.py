"""Laws of paths of a tool: the twist is the derivative, and the ends are met."""

import numpy as np
import pytest

from tool0.description.transform import Pose, pose_matrix
from tool0.description.transform_arrays import (
    from_rotation_vectors,
    left_jacobians,
    rotation_vector,
)
from tool0.errors import UnreachableError
from tool0.kinematics.chain import Array
from tool0.motion.blend import BlendPath, ToolState
from tool0.motion.circle import CirclePath
from tool0.motion.line import LinePath
from tool0.motion.tool_path import ToolPath

START = pose_matrix(Pose(xyz=(0.4, -0.1, 0.3), rpy=(0.3, 2.0, -0.4)))
END = pose_matrix(Pose(xyz=(0.5, 0.2, 0.2), rpy=(0.1, 1.5, 0.3)))
TIP = np.linalg.inv(pose_matrix(Pose(xyz=(0.01, 0.0, 0.15), rpy=(0.2, 0.0, 0.3))))
VIA = np.array([0.55, 0.0, 0.25])
WAYPOINT = pose_matrix(Pose(xyz=(0.48, -0.02, 0.24), rpy=(0.2, 1.8, -0.1)))


def blend(*, is_arc: bool) -> BlendPath:
    """Return a blend of two lines that meet at the waypoint."""
    first = LinePath(START, WAYPOINT)
    second = LinePath(WAYPOINT, END)
    states = []
    for line, distance, speed in ((first, -0.02, 0.2), (second, 0.02, 0.3)):
        s = np.array([distance / line.length + (distance < 0.0)])
        T = line.tool(s)
        states.append(ToolState(T[0], line.twist(s, T)[0] * speed / line.length))
    return BlendPath(*states, WAYPOINT, is_arc=is_arc)


PATHS: dict[str, ToolPath] = {
    "line": LinePath(START, END),
    "circle": CirclePath(START, VIA, END),
    "circle about its centre": CirclePath(START, VIA, END, mode=1),
    "blend": blend(is_arc=False),
    "arc": blend(is_arc=True),
}


def small_twist(before: Array, after: Array) -> Array:
    """Return the twist between poses that differ little, shape (n, 6)."""
    turns = [
        rotation_vector(b[:3, :3] @ a[:3, :3].T)
        for a, b in zip(before, after, strict=True)
    ]
    return np.concatenate([after[:, :3, 3] - before[:, :3, 3], np.array(turns)], axis=1)


@pytest.mark.parametrize("path", PATHS.values(), ids=PATHS.keys())
def test_the_twist_is_the_derivative(path: ToolPath) -> None:
    s, h = np.linspace(0.01, 0.99, 21), 1e-5
    expected = small_twist(path.tool(s - h) @ TIP, path.tool(s + h) @ TIP) / (2.0 * h)
    np.testing.assert_allclose(path.twist(s, path.tool(s) @ TIP), expected, atol=1e-6)


def test_a_circle_passes_its_three_points() -> None:
    circle = CirclePath(START, VIA, END)
    T = circle.tool(np.linspace(0.0, 1.0, 2001))
    np.testing.assert_allclose(T[0], START, atol=1e-12)
    np.testing.assert_allclose(T[-1], END, atol=1e-12)
    assert np.linalg.norm(T[:, :3, 3] - VIA, axis=1).min() < 1e-3
    steps = np.linalg.norm(np.diff(T[:, :3, 3], axis=0), axis=1)
    assert steps.sum() == pytest.approx(circle.length, rel=1e-6)


def test_half_a_circle_and_more() -> None:
    for angle in (np.pi, 1.5 * np.pi, 1.9 * np.pi):
        points = []
        for part in (0.0, 0.4 * angle, angle):
            T = np.eye(4)
            T[:2, 3] = np.cos(part), np.sin(part)
            points.append(T)
        circle = CirclePath(points[0], points[1][:3, 3], points[2], mode=1)
        assert circle.length == pytest.approx(angle)
        assert circle.radius == pytest.approx(1.0)
        assert circle.angle == pytest.approx(angle)


@pytest.mark.parametrize("via", [START[:3, 3], (START + END)[:3, 3] / 2, END[:3, 3]])
def test_points_on_a_line_are_no_arc(via: Array) -> None:
    with pytest.raises(UnreachableError, match="on a line"):
        CirclePath(START, via, END)


@pytest.mark.parametrize("name", ["blend", "arc"])
def test_a_blend_meets_both_lines(name: str) -> None:
    path = PATHS[name]
    assert isinstance(path, BlendPath)
    s = np.array([0.0, 1.0])
    T = path.tool(s)
    V = path.twist(s, T) / path.duration
    for k, (line, distance, speed) in enumerate(
        (
            (LinePath(START, WAYPOINT), -0.02, 0.2),
            (LinePath(WAYPOINT, END), 0.02, 0.3),
        )
    ):
        place = np.array([distance / line.length + (distance < 0.0)])
        expected = line.tool(place)
        np.testing.assert_allclose(T[k], expected[0], atol=1e-12)
        twist = line.twist(place, expected)[0]
        twist /= np.linalg.norm(twist[:3])
        # An arc's s is the part of its length, with the direction of both lines.
        size = path.length / path.duration if name == "arc" else speed
        np.testing.assert_allclose(V[k], twist * size, atol=1e-9)


def test_the_jacobian_of_rotation_vectors() -> None:
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(50, 3)) * rng.choice([1e-6, 1e-3, 1.0], (50, 1))
    rates, h = rng.normal(size=(50, 3)), 1e-6
    R, ahead = (from_rotation_vectors(v) for v in (vectors, vectors + h * rates))
    for k in range(50):
        turn = rotation_vector(ahead[k] @ R[k].T) / h
        np.testing.assert_allclose(
            left_jacobians(vectors)[k] @ rates[k], turn, atol=1e-5
        )
