"""The named poses of a robot: built-in poses, and poses that a user saved to a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import final
from urllib.parse import quote

from tool0.description.config import CellRobot
from tool0.description.forward_kinematics import joint_positions
from tool0.description.loading import named_poses
from tool0.description.named_pose import NamedPose, Positions
from tool0.description.parts import gripper_joints, joints_of_robot
from tool0.description.robot import RobotDescription
from tool0.description.units import ANGLE, LENGTH, read_number
from tool0.description.yaml_tree import YamlEntry, read_verbatim
from tool0.errors import (
    ConfigError,
    ControlError,
    ModelError,
    SourceLocation,
    did_you_mean,
)
from tool0.user_data import data_folder, locked, replace_text

DEFAULT_POSE = "home"
LONGEST_NAME = 60
"""Largest number of characters in the name of a pose.  Longer names would not fit on a
button."""
_HEADER = "# Poses saved with tool0: joint positions [rad | m].\n"


def poses_file(robot: str) -> Path:
    """Return the path of the file that contains the saved poses of a robot."""
    return data_folder() / "poses" / f"{quote(robot, safe=' ')}.yaml"


@final
class PoseStore:
    """The poses of a robot: built-in poses, and saved poses in a file of the user.

    Several processes can change the file at the same time.  Each change is written to a
    new file that replaces the old file under a lock.  Therefore no pose is lost, and no
    reader receives an incomplete file.  A file that cannot be parsed is never replaced.
    """

    def __init__(self, description: RobotDescription) -> None:
        self._description = description
        self.file = poses_file(description.model.name)
        self.own: Mapping[str, NamedPose] = {
            name: NamedPose(name=name, positions=positions, saved=False)
            for name, positions in named_poses(description).items()
        }
        """The built-in poses, which cannot be changed."""
        self._gripper_joints = gripper_joints(description.model)
        self._version: tuple[int, int, int] | None = None
        self._saved: Mapping[str, Positions] = {}

    def adopt(self, poses: Mapping[str, Positions]) -> None:
        """Set the built-in poses.

        A robot that is brought up again from its URDF has no built-in poses, because
        the URDF does not state that the robot is from the catalogue.
        """
        self.own = {
            name: NamedPose(name=name, positions=positions, saved=False)
            for name, positions in poses.items()
        }

    def all(self) -> Mapping[str, NamedPose]:
        """Return all poses by name, starting with the built-in poses.

        If a saved pose has the name of a built-in pose, only the built-in pose is
        returned.

        Raises:
            ConfigError: If the file of saved poses cannot be read or parsed.
        """
        saved = {
            name: NamedPose(name=name, positions=positions, saved=True)
            for name, positions in self._read().items()
            if name not in self.own
        }
        return {**self.own, **saved}

    def find(self, name: str) -> NamedPose:
        """Return the pose called ``name``.

        The file of saved poses is not read for a built-in pose.

        Raises:
            ControlError: If there is no pose of this name.
            ConfigError: If the file of saved poses cannot be read or parsed.
        """
        if name in self.own:
            return self.own[name]
        poses = self.all()
        if name not in poses:
            raise ControlError(f"unknown pose '{name}'{did_you_mean(name, set(poses))}")
        return poses[name]

    def goal(self, name: str, robot: str | None = None) -> dict[str, float]:
        """Return the joints involved in a move to a pose, and their targets [rad | m].

        A pose that contains joints of an arm does not move the gripper.

        Args:
            name: Name of the pose.
            robot: Name of the robot that provides the joints.  If the name is left out,
                the joints of all robots are returned.

        Raises:
            ControlError: If there is no pose of this name, or the pose contains no
                joint of the robot.
            ConfigError: If the file of saved poses cannot be read or parsed.
        """
        positions = self.moved(self.find(name))
        return joints_of_robot(self._description.model, positions, robot)

    def moved(self, pose: NamedPose) -> dict[str, float]:
        """Return the joints involved in a move to ``pose``, and targets [rad | m].

        A pose that contains joints of an arm does not move the gripper, which could
        otherwise drop an object.
        """
        grippers, positions = self._gripper_joints, pose.positions
        of_arms = {name: q for name, q in positions.items() if name not in grippers}
        return of_arms or dict(positions)

    def is_of_grippers(self, pose: NamedPose) -> bool:
        """Return whether a move to ``pose`` moves a gripper."""
        return not self._gripper_joints.isdisjoint(self.moved(pose))

    def start(self) -> dict[str, float]:
        """Return the default start positions of the joints [rad | m].

        The start position of a joint is its initial value in ``<ros2_control>``.  If
        there is no initial value, the start position is that in the pose ``home``.  If
        ``home`` does not contain the joint, the start position is the position within
        the limits that is nearest to zero.  The initial poses of a cell's robots
        override these values.

        Raises:
            ConfigError: If the initial pose of a robot in a cell is invalid.
        """
        model, cell = self._description.model, self._description.cell
        positions = {
            joint.name: joint.limits.clamp(0.0)
            for joint in model.movable_joints
            if joint.mimic is None
        }
        if DEFAULT_POSE in self.own:
            positions |= self.own[DEFAULT_POSE].positions
        positions |= model.initial_positions
        for robot in cell.robots if cell else ():
            try:
                own = self._initial(robot)
                joint_positions(model, own, [0.0] * len(model.movable_joints))
            except (ControlError, ModelError) as error:
                raise ConfigError(
                    f"initial_pose of robot '{robot.name}': {error}", robot.location
                ) from None
            positions |= own
        return positions

    def _initial(self, robot: CellRobot) -> Positions:
        pose = robot.initial_pose
        if isinstance(pose, str):
            positions = self.find(pose).positions
            return joints_of_robot(self._description.model, positions, robot.name)
        return {robot.prefix + joint: q for joint, q in (pose or {}).items()}

    def save(self, name: str, positions: Positions, *, update: bool = False) -> None:
        """Save a pose, replacing any saved pose of the same name.

        If ``update`` is set, the positions of joints that are not in ``positions`` are
        kept from the existing pose.

        Raises:
            ControlError: If the name is that of a built-in pose or is not printable.
            ConfigError: If the file of saved poses cannot be read, parsed or written.
        """
        self._refuse_own(name, "choose another name")
        is_sound = 1 <= len(name) <= LONGEST_NAME and name.isprintable()
        if not is_sound or name != name.strip():
            raise ControlError(
                f"a pose cannot be called {name!r}; give 1 to {LONGEST_NAME} printable "
                "characters, with no space at either end"
            )
        with self._changing() as poses:
            poses[name] = {**(poses.get(name, {}) if update else {}), **positions}

    def delete(self, name: str) -> None:
        """Delete a saved pose.

        Raises:
            ControlError: If there is no pose of this name, or the pose is built in.
            ConfigError: If the file of saved poses cannot be read, parsed or written.
        """
        self._refuse_own(name, "only saved poses can be deleted")
        self.find(name)
        with self._changing() as poses:
            poses.pop(name, None)

    def _refuse_own(self, name: str, remedy: str) -> None:
        if name in self.own:
            raise ControlError(f"pose '{name}' is built in; {remedy}")

    def _read(self) -> Mapping[str, Positions]:
        try:
            status = self.file.stat()
            version = (status.st_mtime_ns, status.st_size, status.st_ino)
            if version != self._version:
                self._saved = _parse(self.file)
                self._version = version
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise self._failure("read", error) from None
        return self._saved

    @contextmanager
    def _changing(self) -> Iterator[dict[str, Positions]]:
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            with locked(self.file.with_suffix(".lock")):
                poses = dict(self._read())
                yield poses
                replace_text(self.file, _text(poses))
        except OSError as error:
            raise self._failure("write", error) from None

    def _failure(self, verb: str, error: OSError) -> ConfigError:
        return ConfigError(
            f"cannot {verb} the saved poses: {error.strerror}",
            SourceLocation(self.file),
        )


def _text(poses: Mapping[str, Positions]) -> str:
    import yaml

    plain = {name: dict(positions) for name, positions in poses.items()}
    return _HEADER + yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)


def _parse(file: Path) -> dict[str, Positions]:
    """Return the poses in a file that a user may have edited, or raise ConfigError."""
    tree = read_verbatim(file)
    tree.require_unique_keys()
    poses = {} if tree.root.is_null else _children(tree.root, "the file")
    return {
        name: {
            joint: _number(value, f"joint '{joint}' of pose '{name}'")
            for joint, value in _children(pose, f"pose '{name}'").items()
        }
        for name, pose in poses.items()
    }


def _children(entry: YamlEntry, what: str) -> dict[str, YamlEntry]:
    if not entry.is_mapping:
        raise ConfigError(f"{what} must be a mapping", entry.location)
    return entry.children


def _number(entry: YamlEntry, what: str) -> float:
    try:
        return read_number(str(entry.scalar), ANGLE, LENGTH)[0]
    except ConfigError:
        raise ConfigError(
            f"{what} must be a finite number, alone or with a unit, got "
            f"{entry.describe()}",
            entry.location,
        ) from None
