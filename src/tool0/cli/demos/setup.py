"""The demos: each consists of a robot, its surroundings, and a task."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, final

from tool0.api.grasps import Bin, find_bin
from tool0.api.table import BIN, ITEM, PickTable, arm_scale
from tool0.cli.demos.hand import PickOptions
from tool0.cli.demos.handover import GIVER, TAKER, HandoverCell, hand_over
from tool0.cli.demos.picker import pick_and_place
from tool0.cli.demos.report import PickReport
from tool0.cli.demos.shelf import (
    HELPER,
    SMALLEST_SCALE,
    pick_from_shelf,
    random_poses,
    shelf_scene,
    two_robots,
)
from tool0.cli.demos.trials import DemoReport, run_trials
from tool0.description.cell_file import parse_robots
from tool0.description.config import DescriptionConfig
from tool0.description.loading import load_description
from tool0.description.scene import Scene
from tool0.description.transform import Pose
from tool0.errors import ConfigError
from tool0.protocol.state import Snapshot

if TYPE_CHECKING:
    from tool0.api.robot import Robot

OnSnapshot = Callable[[Snapshot], None]


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Cube:
    """The cube to pick."""

    edge: float = 0.045
    """Edge of the cube [m]."""
    mass: float = 0.1
    """Mass of the cube [kg]."""
    friction: float = 1.0
    """Coefficient of friction of the cube."""

    def scene_of(self, place: PickTable | HandoverCell) -> Scene:
        """Return the scene with the cube."""
        return place.scene(edge=self.edge, mass=self.mass, friction=self.friction)


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Demo:
    """A demo: a robot, its surroundings, and a task."""

    description: DescriptionConfig
    scene: Scene
    poses: Callable[[Robot, int], Iterator[Pose]]
    """Function that yields random start poses of the cube for a seed."""
    task: Callable[[Robot, Bin, OnSnapshot], PickReport]
    """Function that performs the task once."""

    def play(
        self,
        robot: Robot,
        n: int,
        *,
        seed: int | None = None,
        on_snapshot: OnSnapshot = lambda snapshot: None,
        on_pick: Callable[[PickReport], None] = lambda report: None,
    ) -> DemoReport:
        """Perform the task ``n`` times, and return a report.

        Args:
            robot: A robot with the description and the scene of the demo.
            n: Number of trials.
            seed: Seed of the random start poses; without a seed, the first trial uses
                the pose from the scene.
            on_snapshot: Called with each snapshot.
            on_pick: Called after each trial.
        """
        into = find_bin(robot.scene.objects, BIN)
        poses = self.poses(robot, seed or 0)
        return run_trials(
            robot,
            ITEM,
            lambda: self.task(robot, into, on_snapshot),
            poses if seed is not None else itertools.chain([None], poses),
            n,
            on_snapshot=on_snapshot,
            on_pick=on_pick,
        )


def pick_demo(cube: Cube, options: PickOptions, description: DescriptionConfig) -> Demo:
    """Return the demo for picks from a table; the robot has one arm and one gripper."""
    table = PickTable(scale=_scale(description))
    options = replace(options, lift=table.lift)
    return Demo(
        description=description,
        scene=cube.scene_of(table),
        poses=lambda robot, seed: table.random_poses(robot, cube.edge, seed),
        task=lambda robot, into, on_snapshot: pick_and_place(
            robot, ITEM, into, options, on_snapshot
        ),
    )


def shelf_demo(
    cube: Cube,
    options: PickOptions,
    description: DescriptionConfig,
    second: str | None,
) -> Demo:
    """Return the demo for picks from a shelf, with obstacles.

    ``second`` is the second robot, as ARM+GRIPPER.

    Raises:
        ConfigError: If the arm is too short, or if the second robot is unknown.
    """
    if (scale := _scale(description)) < SMALLEST_SCALE:
        raise ConfigError(
            f"the arm reaches {scale:.0%} as far as a UR5, which is too short for the "
            "shelf"
        )
    if second is not None:
        (helper,) = parse_robots([f"{HELPER}={second}"]).robots
        description = DescriptionConfig(
            cell=two_robots(description, helper.description)
        )
    scene = shelf_scene(edge=cube.edge, mass=cube.mass, friction=cube.friction)
    return Demo(
        description=description,
        scene=scene,
        poses=lambda robot, seed: random_poses(scene, cube.edge, seed),
        task=lambda robot, into, on_snapshot: pick_from_shelf(
            robot, ITEM, into, options, on_snapshot
        ),
    )


def handover_demo(cube: Cube, options: PickOptions, giver: str, taker: str) -> Demo:
    """Return the demo for handovers between two robots, each given as ``ARM+GRIPPER``.

    Raises:
        ConfigError: If the giver or the taker does not have this form.
    """
    given = {GIVER: giver, TAKER: taker}
    robots = parse_robots([f"{name}={parts}" for name, parts in given.items()]).robots
    one, other = (robot.description for robot in robots)
    for name, description in zip(given, (one, other), strict=True):
        if description.gripper is None:
            raise ConfigError(
                f"--{name} '{given[name]}' has no gripper; write ARM+GRIPPER, such as "
                "ur5+2f85"
            )
    places = HandoverCell.of(_scale(one), _scale(other))
    options = replace(options, lift=places.lift)
    return Demo(
        description=DescriptionConfig(cell=places.cell(one, other)),
        scene=cube.scene_of(places),
        poses=lambda robot, seed: places.giver.random_poses(robot, cube.edge, seed),
        task=lambda robot, into, on_snapshot: hand_over(
            robot,
            ITEM,
            into,
            places.meeting,
            options=options,
            on_snapshot=on_snapshot,
        ),
    )


def _scale(description: DescriptionConfig) -> float:
    """Return the scale of an arm, from its full description."""
    return arm_scale(load_description(description).model)
