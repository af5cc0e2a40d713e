"""Trajectories of ROS 2's controllers: the kernel starts them as Python does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import tool0
from tool0.kernel import library
from tool0.simulation.core import Core

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        library.load() is None, reason="no compiled kernel in this installation"
    ),
]

Array = NDArray[np.float64]
DESCRIPTION = tool0.DescriptionConfig(arm="ur3e", gripper=None, ros2_control=True)
"""Its last joint turns endlessly."""
CONTROLLER = """
arm:
  ros__parameters:
    type: joint_trajectory_controller/JointTrajectoryController
    joints: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint,
             wrist_1_joint, wrist_2_joint, wrist_3_joint]
    command_interfaces: [{interface}]
    state_interfaces: [position, velocity]
    {options}
    gains: &g
      shoulder_pan_joint: &k {{p: 4.0, i: 0.2, i_clamp: 1.0, ff_velocity_scale: 1.0}}
      shoulder_lift_joint: *k
      elbow_joint: *k
      wrist_1_joint: *k
      wrist_2_joint: *k
      wrist_3_joint: *k
    constraints:
      goal_time: {goal_time}
      elbow_joint: {{trajectory: {path}, goal: 0.01}}
"""


def control(
    folder: Path,
    options: str = "",
    *,
    interface: str = "position",
    path: float = 0.2,
    goal_time: float = 0.0,
) -> tool0.ControlConfig:
    file = folder / "controllers.yaml"
    file.write_text(
        CONTROLLER.format(
            interface=interface, options=options, path=path, goal_time=goal_time
        )
    )
    return tool0.ControlConfig(controllers_file=file, controllers="arm")


def moved(chosen: tool0.ControlConfig, seed: int) -> list[Array]:
    """Command trajectories in all orders; return the states in between."""
    rng = np.random.default_rng(seed)
    found: list[Array] = []
    with tool0.Batch(2, description=DESCRIPTION, control=chosen) as batch:
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        home, saved = batch.position[:, columns], batch.save()
        for k in range(24):
            for _ in range(rng.choice((1, 1, 2, 3))):
                n_points = int(rng.choice((1, 1, 4)))
                q = home[:, None] + rng.uniform(-0.1, 0.1, (2, n_points, 6))
                q[..., 5] += rng.choice((0.0, 0.0, 2 * np.pi, 10.0))
                qd = rng.uniform(-0.3, 0.3, q.shape)
                qd[:, -1] = 0.0
                longest = rng.choice((0.002, 0.12))
                times = np.cumsum(rng.uniform(0.001, longest, n_points)).tolist()
                which = [1] if rng.random() < 0.2 else None
                velocities = qd if rng.random() < 0.6 else None
                batch.follow(q, times, velocities=velocities, which=which)
            batch.step(int(rng.choice((0, 1, 2, 15, 80))))
            found += [batch.position, batch.velocity, batch.effort]
            if k == 8:
                saved = batch.save()
            elif k == 14:
                batch.restore(saved, which=[0])
            elif k == 19:
                batch.reset([0])
    return found


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"options": "allow_trajectory_replacement: false"},
        {"options": "interpolate_from_desired_state: true"},
        {
            "options": "allow_trajectory_replacement: false\n"
            "    interpolate_from_desired_state: true"
        },
        {"options": "interpolation_method: none"},
        {"interface": "velocity", "path": 0.002},
        {"path": 0.0005, "goal_time": 0.02},
    ],
    ids=["follow", "at once", "desired", "both", "stepped", "velocity", "violated"],
)
def test_trajectories_that_replace_each_other(
    options: dict[str, object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also before the next tick, with other joints' turns, and after violations."""
    chosen = control(tmp_path, **options)  # type: ignore[arg-type]
    compiled = moved(chosen, 3)
    monkeypatch.setenv(library.VARIABLE, "python")
    reference = moved(chosen, 3)
    for number, (one, other) in enumerate(zip(compiled, reference, strict=True)):
        assert np.array_equal(one, other), number
    assert np.ptp(reference[::3], axis=0).max() > 0.05


def test_an_error_in_the_first_tick_of_a_short_trajectory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It counts, though the trajectory ends within that tick: the joints stay."""
    chosen = control(tmp_path, "interpolate_from_desired_state: true", path=0.01)

    def jumped() -> list[Array]:
        with tool0.Batch(1, description=DESCRIPTION, control=chosen) as batch:
            columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
            batch.step(2)
            q = batch.position[:, columns] + 0.1
            found = []
            for ticks in (2, 1, 40):
                batch.command(q, duration=0.0008)
                batch.step(ticks)
                found.append(batch.position)
            return found

    compiled = jumped()
    monkeypatch.setenv(library.VARIABLE, "python")
    assert np.array_equal(compiled, jumped())
    assert np.ptp(compiled, axis=0)[0, 2] < 0.06


def test_a_motion_costs_no_tick_in_python(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks: list[Core] = []
    monkeypatch.setattr(Core, "tick", lambda core: ticks.append(core) or tick(core))
    with tool0.Batch(2, description=DESCRIPTION) as batch:
        batch.step(1)  # the first one is Python's
        ticks.clear()
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        home = batch.position[:, columns]
        for k in range(4):
            batch.command(home + 0.01 * k, duration=0.05)
            batch.run(0.04)
            path = home[:, None] + 0.01 * np.arange(3)[:, None]
            batch.follow(path, [0.05, 0.1, 0.15])
            batch.run(0.06)
        assert ticks == []


tick = Core.tick


def test_what_ros_2_rejects_changes_nothing() -> None:
    with tool0.Batch(2, description=DESCRIPTION) as batch:
        batch.step(2)
        columns = [batch.joint_names.index(joint) for joint in batch.arm_joints]
        q = batch.position[:, columns]
        with pytest.raises(tool0.GoalRejectedError, match="is not zero"):
            batch.command(q, velocities=np.full_like(q, 0.1), duration=0.1)
        speeds = np.zeros((2, 2, 6))
        speeds[1, 0] = 1e12
        with pytest.raises(tool0.GoalRejectedError, match="copy 1"):
            batch.follow(q[:, None].repeat(2, 1), [1.0, 2.0], velocities=speeds)
        before = batch.position
        batch.step(20)
        assert np.allclose(batch.position, before, atol=1e-6)
