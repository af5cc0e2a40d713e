"""``tool0.Batch``: many copies of a robot and its scene, advanced together."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tool0.batch.arguments import Arguments, Indices, Which
from tool0.batch.backend import CPU, Backend, checked_device
from tool0.batch.frames import GripperFrames, LinkFrames
from tool0.control.goal_check import check_names, check_position, position_range
from tool0.control.manager import GRIPPER_KIND, TRAJECTORY_KIND, why_not_driven
from tool0.control.trajectory import TrajectoryGoal, TrajectoryPoint
from tool0.description.camera import default_cameras, merged
from tool0.description.config import SPAWN_Z, DescriptionConfig, File
from tool0.description.model import Joint, ParallelGripper, RobotModel
from tool0.description.parts import find_arms, find_grippers
from tool0.description.robot import load_description
from tool0.description.scene import Scene
from tool0.engines.registry import make_engine
from tool0.errors import (
    ConfigError,
    ControlError,
    LimitsError,
    did_you_mean,
)
from tool0.hardware.limits import DriveLimits
from tool0.kinematics.chain import Array
from tool0.runtime.assembly import Assembly, chosen_scene
from tool0.runtime.config import ControlConfig
from tool0.runtime.core import Core
from tool0.runtime.gripper_motion import direct_motion
from tool0.runtime.simulation import only_part
from tool0.sensing.cameras import CameraImage, Cameras
from tool0.sensing.grasp import pad_links
from tool0.sensing.snapshot import Snapshot

if TYPE_CHECKING:
    from tool0.batch.copies import Copies
    from tool0.engines.mujoco.copies import ObjectArrays

Item = TypeVar("Item")
FrozenArray = TypeVar("FrozenArray", bound=NDArray[Any])


class _Part(NamedTuple):
    """Joints of one running trajectory controller."""

    controller: str
    joints: tuple[str, ...]
    columns: list[int]
    """Of the joints, in an array of all joints that are commanded."""


@final
class Batch:
    """n copies of a robot and its scene, advanced together: MuJoCo only.

    Each copy behaves as a single ``bringup`` with ``realtime=False`` that gets the same
    commands at the same ticks, bit for bit.  Every array has one row per copy, shape
    (n, …), and is in SI units; a value without that axis counts for all copies alike.
    ``which`` chooses copies, by a mask of shape (n,) or by number; the rows of the
    others are not read.  Arrays that are returned cannot be written to, and stay as
    they are when time passes.
    """

    def __init__(
        self,
        n: int,
        *,
        description: DescriptionConfig = DescriptionConfig(),
        control: ControlConfig = ControlConfig(),
        scene: Scene | File | Sequence[Scene] | None = None,
        dt: float = 0.001,
        threads: int | None = None,
        device: str = "cpu",
    ) -> None:
        """Make ``n`` copies, each at its initial pose.

        Args:
            n: How many.
            description: Which robot.
            control: Its controllers and its initial pose.
            scene: The objects around the robot: for all copies, or one scene per copy.
                Those of the copies differ in mass, friction, pose and colour only.
            dt: Length of a physics step [s].
            threads: Threads that step the copies; as many as there are processors, or
                copies if these are fewer, if not given.  A GPU needs none.
            device: What computes: "cpu"; a GPU, as "cuda" or "cuda:1", in single
                precision; or "warp:cpu", which computes as a GPU does, slowly.

        Raises:
            ConfigError: If ``n`` or ``threads`` is out of range, scenes differ, or the
                device cannot run what is asked for.
            EngineUnavailableError: If there is no such device, or mujoco-warp is not
                installed.
            Tool0Error: If an option or a file is wrong.
        """
        self._n = _checked_count(n)
        self._device = checked_device(device)
        self._threads = _checked_threads(threads, self._n)
        if self._device != CPU:
            if threads is not None:
                raise ConfigError("threads are those of device='cpu'; leave them out")
            self._threads = 1
        self._dt = dt
        robot = load_description(description)
        self._model = robot.model
        if scene is None or isinstance(scene, Scene | str | Path):
            scenes = [chosen_scene(robot, scene)] * self._n
        else:
            scenes = _checked_scenes([chosen_scene(robot, one) for one in scene], n)
        if self._device != CPU:
            scenes = [_only_scene(scenes)]
        assembly = Assembly.of(robot, control)
        self._cores: list[Core] = []
        try:
            for one in scenes:
                engine = make_engine("mujoco", robot, dt=dt, spawn_z=SPAWN_Z, scene=one)
                self._cores.append(assembly.core(engine, one))
            cameras = merged(default_cameras(self._model), scenes[0].cameras)
            for camera in cameras.values():
                camera.check_on(self._model)
            self._copies = self._backend()
        except BaseException:
            for core in self._cores:
                core.engine.close()
            raise
        ground = self._cores[0].engine.world.ground
        self._cameras = Cameras(self._model, cameras, ground, lambda: self._snapshot(0))
        self._chains: dict[str, LinkFrames] = {}
        self._tcp_frames: dict[str, GripperFrames] = {}
        self._joints: tuple[Array, Array, Array] | None = None
        self._object_arrays: ObjectArrays | None = None
        """What was read since the state last changed, these two."""
        self._is_closed = False

    # ---- what it is -----------------------------------------------------------------

    @property
    def n(self) -> int:
        """How many copies there are."""
        return self._n

    @property
    def threads(self) -> int:
        """How many threads step them."""
        return self._threads

    @property
    def device(self) -> str:
        """What computes: "cpu", or a GPU."""
        return self._device

    @property
    def dt(self) -> float:
        """Length of a physics step [s]."""
        return self._dt

    @property
    def control_period(self) -> float:
        """Simulated time between updates of the controllers: a tick [s]."""
        return self._cores[0].control_period

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """All movable joints: the order of ``position``, ``velocity``, ``effort``."""
        return self._cores[0].engine.joint_names

    @cached_property
    def arm_joints(self) -> tuple[str, ...]:
        """The joints that ``command`` and ``follow`` move if none are named.

        Those of every running trajectory controller that drives no gripper.
        """
        return tuple(
            joint
            for joints in self._trajectory_controllers.values()
            if self._driven_by_grippers.isdisjoint(joints)
            for joint in joints
        )

    @cached_property
    def object_names(self) -> tuple[str, ...]:
        """The objects of the scene, in the order of their poses."""
        return tuple(item.name for item in self._cores[0].scene.objects)

    @cached_property
    def grippers(self) -> Mapping[str, ParallelGripper]:
        """The grippers by name."""
        return find_grippers(self._model)

    # ---- the state ------------------------------------------------------------------

    @property
    def time(self) -> Array:
        """Simulated time of each copy since its reset [s], shape (n,)."""
        return _frozen(self._copies.time)

    @property
    def position(self) -> Array:
        """Joint positions [rad | m], shape (n, n_joints)."""
        return self._states()[0]

    @property
    def velocity(self) -> Array:
        """Joint velocities [rad/s | m/s], shape (n, n_joints)."""
        return self._states()[1]

    @property
    def effort(self) -> Array:
        """Efforts that the drives applied in the last step [N·m | N], (n, n_joints)."""
        return self._states()[2]

    @property
    def diverged(self) -> NDArray[np.bool_]:
        """Copies whose physics failed, shape (n,): each stands still until a reset."""
        return _frozen(self._copies.has_diverged.copy())

    def tool_pose(self, robot: str | None = None) -> tuple[Array, Array]:
        """Return position [m], (n, 3), and quat_wxyz, (n, 4), of tool0 in the root.

        Args:
            robot: The arm, by name; the only one, if left out.

        Raises:
            ControlError: If there is no such arm, or several and no name.
        """
        arms = find_arms(self._model)
        link = _named(arms, robot, "arm", self._model).flange
        frames = self._link_frames(link).poses(self._positions())
        return _frozen(frames.position), _frozen(frames.quat_wxyz)

    def tcp_pose(self, gripper: str | None = None) -> tuple[Array, Array]:
        """Return position [m], (n, 3), and quat_wxyz, (n, 4), of the tcp in the root.

        It is the point midway between the pads: y points from pad to pad, z away from
        the gripper, as for ``Gripper.tcp``.

        Args:
            gripper: The gripper, by name; the only one, if left out.

        Raises:
            ControlError: If there is no such gripper, or several and no name.
        """
        geometry = self._gripper(gripper)
        if geometry.name not in self._tcp_frames:
            self._tcp_frames[geometry.name] = GripperFrames(self._model, geometry)
        frames = self._tcp_frames[geometry.name].poses(self._positions())
        return _frozen(frames.position), _frozen(frames.quat_wxyz)

    def opening(self, gripper: str | None = None) -> Array:
        """Return the distance between the pads [m], shape (n,); 0 is closed."""
        geometry = self._gripper(gripper)
        q = self.position[:, self.joint_names.index(geometry.joint)]
        return _frozen(
            np.array([max(0.0, geometry.opening(value)) for value in q.tolist()])
        )

    @property
    def object_position(self) -> Array:
        """Positions of the objects in the root [m], shape (n, n_objects, 3)."""
        return self._objects().position

    @property
    def object_quat(self) -> Array:
        """Their orientations, w, x, y, z, shape (n, n_objects, 4)."""
        return self._objects().quat

    @property
    def object_linear(self) -> Array:
        """Their velocities in the root's axes [m/s], shape (n, n_objects, 3)."""
        return self._objects().linear

    @property
    def object_angular(self) -> Array:
        """Their angular velocities in these axes [rad/s], shape (n, n_objects, 3)."""
        return self._objects().angular

    def pad_forces(self, gripper: str | None = None) -> Array:
        """Return the normal force on each pad in the last step [N], shape (n, 2).

        The sum over all contacts of a pad, whatever touches it.

        Raises:
            ControlError: If there is no such gripper, or it has no two pads.
        """
        geometry = self._gripper(gripper)
        pads = pad_links(self._model, geometry)
        return _frozen(self._copies.pad_forces(pads))

    # ---- commands -------------------------------------------------------------------

    def command(
        self,
        positions: ArrayLike,
        *,
        velocities: ArrayLike | None = None,
        duration: float,
        joints: Sequence[str] | None = None,
        which: Which | None = None,
    ) -> None:
        """Move joints to ``positions``, as ROS's topic ``~/command`` with one point.

        The motion leaves the present setpoint; it replaces what is left of the motion
        before it.

        Args:
            positions: [rad | m], shape (n, k).
            velocities: At the positions [rad/s | m/s], shape (n, k); if left out, the
                setpoints move linearly and then rest, as in ROS.
            duration: Time until the joints are there [s].
            joints: The k joints; ``arm_joints``, if left out.
            which: The copies.

        Raises:
            ControlError: If a shape, a number or a joint is wrong; nothing has moved.
        """
        check = Arguments(self._n, "command")
        duration = check.duration(duration)
        names, parts = self._parts(joints)
        rows = check.which(which)
        shape, axes = (len(names),), f" for joints {', '.join(names)}"
        q = check.rows("positions", positions, shape, rows, axes)
        qd = None
        if velocities is not None:
            qd = check.rows("velocities", velocities, shape, rows, axes)
        self._check_positions(names, q[:, None], rows)
        self._start(
            rows, parts, q[:, None], None if qd is None else qd[:, None], [duration]
        )

    def follow(
        self,
        positions: ArrayLike,
        times: ArrayLike,
        *,
        velocities: ArrayLike | None = None,
        joints: Sequence[str] | None = None,
        which: Which | None = None,
    ) -> None:
        """Move joints along trajectories, as ROS's topic ``~/command``.

        Args:
            positions: Of m points [rad | m], shape (n, m, k).
            times: After now [s], increasing, shape (m,).
            velocities: At the points [rad/s | m/s], shape (n, m, k); if left out, the
                setpoints move linearly between them.
            joints: The k joints; ``arm_joints``, if left out.
            which: The copies.

        Raises:
            ControlError: If a shape, a number or a joint is wrong; nothing has moved.
        """
        check = Arguments(self._n, "follow")
        names, parts = self._parts(joints)
        rows = check.which(which)
        points = check.times(times)
        shape = (len(points), len(names))
        axes = f" for joints {', '.join(names)}"
        q = check.rows("positions", positions, shape, rows, axes)
        qd = None
        if velocities is not None:
            qd = check.rows("velocities", velocities, shape, rows, axes)
        self._check_positions(names, q, rows)
        self._start(rows, parts, q, qd, points)

    def move_gripper(
        self,
        opening: ArrayLike,
        *,
        speed: ArrayLike | None = None,
        force: ArrayLike | None = None,
        gripper: str | None = None,
        which: Which | None = None,
    ) -> None:
        """Move the pads to ``opening``; what stops them is gripped with ``force``.

        The driven joint moves along one cubic that ends at rest
        (``gripper_motion.direct_motion``); a GripperActionController moves it its way.

        Args:
            opening: Distance between the pads [m], shape (n,).
            speed: Of the pads relative to each other [m/s], shape (n,); the fastest, if
                left out.
            force: Largest force at each pad [N], shape (n,); the strongest, if left
                out.
            gripper: The gripper, by name; the only one, if left out.
            which: The copies.

        Raises:
            ModelError: If an opening is out of reach.
            ControlError: If a shape, a speed or a force is wrong, or no running
                controller drives the gripper; nothing has moved.
        """
        check = Arguments(self._n, "move_gripper")
        geometry = self._gripper(gripper)
        rows = check.which(which)
        openings = check.rows("opening", opening, (), rows)[rows].tolist()
        fastest, strongest = geometry.speed[1], geometry.force[1]
        speeds = check.rows("speed", fastest if speed is None else speed, (), rows)
        forces = check.rows("force", strongest if force is None else force, (), rows)
        for value in openings:
            geometry.position(value)  # raises
        limits: dict[tuple[float, float], DriveLimits] = {}
        bounds = []
        for pair in zip(speeds[rows].tolist(), forces[rows].tolist(), strict=True):
            if pair not in limits:
                speed_, force_ = pair
                limits[pair] = DriveLimits(gripper=geometry, speed=speed_, force=force_)
            bounds.append(limits[pair])
        name, kind = self._gripper_controller(geometry)
        joint = geometry.joint
        effort = None
        if force is not None:
            effort = self._cores[0].hardware.limits[joint].effort
        self._change()
        motions = zip(rows.tolist(), openings, bounds, strict=True)
        if kind == GRIPPER_KIND:
            for i, end, bound in motions:
                core, target = self._host.core(i), geometry.position(end)
                core.command_gripper(name, target, effort, bound)
        elif not self._grip(rows, name, openings, bounds):
            for i, end, bound in motions:
                core = self._host.core(i)
                controller = core.trajectory_controller(name)
                column = controller.spec.joints.index(joint)
                here = controller.query_state(core.time).positions[column]
                point = self._grip_point(bound, here, end)
                goal = TrajectoryGoal(points=[point], joint_names=[joint])
                core.command_trajectory(name, goal, {joint: bound})

    # ---- time -----------------------------------------------------------------------

    def step(self, ticks: int = 1) -> None:
        """Advance all copies by ``ticks`` control periods.

        A copy that diverged stands still.

        Raises:
            ControlError: If ``ticks`` is no whole number, or negative.
        """
        if not isinstance(ticks, int | np.integer) or ticks < 0:
            raise ControlError(
                f"Batch.step: 'ticks' must be a whole number, 0 or more, got {ticks!r}"
            )
        self._change()
        self._copies.step(int(ticks))

    def run(self, duration: float) -> None:
        """Advance all copies by ``duration`` [s], rounded to whole control periods."""
        time = Arguments(self._n, "run").duration(duration)
        self.step(max(0, math.ceil(time / self.control_period - 0.5)))

    def reset(
        self, which: Which | None = None, position: ArrayLike | None = None
    ) -> None:
        """Return copies to their start: time, objects, controllers and pose.

        Args:
            which: The copies.
            position: Of all joints [rad | m], shape (n, n_joints); the initial pose, if
                left out.  Joints that mimic another follow it; their numbers are not
                read.

        Raises:
            ControlError: If a shape or a number is wrong.
            LimitsError: If a position is outside a joint's limits; nothing has changed.
        """
        check = Arguments(self._n, "reset")
        rows = check.which(which)
        free = [joint for joint in self._model.movable_joints if joint.mimic is None]
        starts: dict[str, Array] = {}
        if position is not None:
            axes = f" for joints {', '.join(self.joint_names)}"
            q = check.rows("position", position, (len(self.joint_names),), rows, axes)
            columns = [self.joint_names.index(joint.name) for joint in free]
            _check_starts(free, q[:, columns], rows)
            names = [joint.name for joint in free]
            starts = dict(zip(names, q[rows][:, columns].T, strict=True))
        self._change()
        self._copies.reset(rows, starts)

    # ---- the scene ------------------------------------------------------------------

    def place(
        self,
        name: str,
        position: ArrayLike,
        quat: ArrayLike | None = None,
        which: Which | None = None,
    ) -> None:
        """Place an object, at rest.  A reset returns it to its start.

        Args:
            name: The object.
            position: Of its origin in the root [m], shape (n, 3).
            quat: Its orientation w, x, y, z, shape (n, 4); upright as the root's axes,
                if left out.
            which: The copies.

        Raises:
            EngineError: If there is no such object, or it is fixed and on a GPU.
            ControlError: If a shape or a number is wrong; nothing has changed.
        """
        check = Arguments(self._n, "place")
        rows = check.which(which)
        self._object(name)
        xyz = check.rows("position", position, (3,), rows)[rows]
        turn = (1.0, 0.0, 0.0, 0.0) if quat is None else quat
        quats = check.rows("quat", turn, (4,), rows)[rows]
        if not (np.abs(quats).max(axis=1, initial=0.0) > 0.0).all():
            raise ControlError("Batch.place: a 'quat' is zero; it must not be")
        self._change()
        self._copies.place(rows, name, xyz, quats)

    def set_mass(self, name: str, mass: ArrayLike, which: Which | None = None) -> None:
        """Give a movable object another mass; it keeps its shape.

        Args:
            name: The object.
            mass: [kg], shape (n,).
            which: The copies.

        Raises:
            ControlError: If there is no such object, it is fixed, or a mass is not
                above 0; nothing has changed.
        """
        self._change_objects("set_mass", name, "mass", mass, which)

    def set_friction(
        self, name: str, friction: ArrayLike, which: Which | None = None
    ) -> None:
        """Give an object another friction coefficient.

        Args:
            name: The object.
            friction: As ``SceneObject.friction``, shape (n,).
            which: The copies.

        Raises:
            ControlError: If there is no such object, or a number is below 0; nothing
                has changed.
        """
        self._change_objects("set_friction", name, "friction", friction, which)

    # ---- pictures, and the end ------------------------------------------------------

    def render(self, i: int, camera: str) -> CameraImage:
        """Return an image of copy ``i``.

        Raises:
            ControlError: If there is no such copy, or this is a GPU.
            RenderError: If there is no such camera, or no OpenGL here.
        """
        if not 0 <= i < self._n:
            raise ControlError(
                f"Batch.render: no copy {i}; there are 0 … {self._n - 1}"
            )
        self._check_on_cpu("render")
        return self._cameras.render(self._cameras[camera], self._snapshot(i))

    def close(self) -> None:
        """End the batch; closing twice is allowed."""
        self._is_closed = True
        self._cameras.close()
        for core in self._cores:
            core.engine.close()

    def __enter__(self) -> Batch:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    # ---- details --------------------------------------------------------------------

    def _backend(self) -> Backend:
        """Return what simulates the copies."""
        if self._device == CPU:
            from tool0.batch.copies import Copies

            return Copies(self._cores, self._threads)
        from tool0.batch.device import DeviceCopies

        return DeviceCopies(self._cores[0], self._model, self._n, self._device)

    @property
    def _host(self) -> Copies:
        """The copies with a core each: those of the CPU."""
        from tool0.batch.copies import Copies

        assert isinstance(self._copies, Copies)
        return self._copies

    def _check_on_cpu(self, method: str) -> None:
        if self._device != CPU:
            raise ControlError(
                f"Batch.{method} works with device='cpu' only; this is {self._device!r}"
            )

    def _change(self) -> None:
        """Forget what was read: the state is about to change."""
        if self._is_closed:
            raise ControlError("the batch is closed")
        self._joints = self._object_arrays = None

    def _states(self) -> tuple[Array, Array, Array]:
        """Return positions, velocities and efforts of the joints."""
        if self._joints is None:
            position, velocity, effort = map(_frozen, self._copies.states())
            self._joints = position, velocity, effort
        return self._joints

    def _objects(self) -> ObjectArrays:
        from tool0.engines.mujoco.copies import ObjectArrays

        if self._object_arrays is None:
            self._object_arrays = ObjectArrays(*map(_frozen, self._copies.objects()))
        return self._object_arrays

    def _positions(self) -> dict[str, Array]:
        """Return each joint's positions, shape (n,)."""
        return dict(zip(self.joint_names, self.position.T, strict=True))

    def _link_frames(self, link: str) -> LinkFrames:
        if link not in self._chains:
            self._chains[link] = LinkFrames(self._model, link)
        return self._chains[link]

    def _gripper(self, name: str | None) -> ParallelGripper:
        return _named(self.grippers, name, "gripper", self._model)

    def _change_objects(
        self, method: str, name: str, field: str, values: ArrayLike, which: Which | None
    ) -> None:
        """Change a field of an object, as if each copy had been made with it."""
        check = Arguments(self._n, method)
        self._check_on_cpu(method)
        rows = check.which(which)
        numbers = check.rows(field, values, (), rows)[rows].tolist()
        self._object(name)
        items = []
        for i, number in zip(rows.tolist(), numbers, strict=True):
            objects = {item.name: item for item in self._cores[i].scene.objects}
            if field == "mass" and objects[name].mass is None:
                raise ControlError(
                    f"Batch.{method}: object '{name}' is fixed: it has no mass"
                )
            try:
                changes: dict[str, Any] = {field: number}
                items.append(replace(objects[name], **changes))
            except ConfigError as error:
                raise ControlError(f"Batch.{method}: copy {i}: {error}") from None
        from tool0.engines.mujoco.copies import mujoco_engine

        self._change()
        for i, item in zip(rows.tolist(), items, strict=True):
            mujoco_engine(self._cores[i].engine).world.change(item)
            self._cores[i].scene.changed(item)

    def _object(self, name: str) -> None:
        if name not in self.object_names:
            raise ControlError(
                f"there is no object '{name}'{did_you_mean(name, self.object_names)}"
            )

    @cached_property
    def _driven_by_grippers(self) -> frozenset[str]:
        return frozenset(gripper.joint for gripper in self._model.grippers)

    @cached_property
    def _trajectory_controllers(self) -> dict[str, tuple[str, ...]]:
        """The joints of each running trajectory controller."""
        manager = self._cores[0].manager
        return {
            status.name: manager.spec(status.name).joints
            for status in manager.list()
            if status.state == "running" and status.kind == TRAJECTORY_KIND
        }

    def _parts(
        self, joints: Sequence[str] | None
    ) -> tuple[tuple[str, ...], list[_Part]]:
        """Return the joints to move, and those of each controller."""
        names = self.arm_joints if joints is None else tuple(joints)
        manager = self._cores[0].manager
        owners = {
            joint: name
            for name, its in self._trajectory_controllers.items()
            for joint in its
        }
        if not names:
            raise ControlError(
                "no running trajectory controller drives an arm's joints"
            )
        for joint in names:
            if joint not in owners:
                raise ControlError(why_not_driven(manager.list(), [joint]))
            if names.count(joint) > 1:
                raise ControlError(f"joint '{joint}' is named twice")
        parts = []
        for name in dict.fromkeys(owners[joint] for joint in names):
            columns = [k for k, joint in enumerate(names) if owners[joint] == name]
            part = _Part(name, tuple(names[k] for k in columns), columns)
            controller = self._cores[0].trajectory_controller(name)
            check_names(
                TrajectoryGoal(points=(), joint_names=part.joints),
                controller.spec.joints,
                allow_partial=controller.spec.allow_partial_joints_goal,
            )
            parts.append(part)
        return names, parts

    def _check_positions(
        self, names: Sequence[str], positions: Array, rows: Indices
    ) -> None:
        """Raise GoalRejectedError for positions (n, m, k) beyond the joints' limits."""
        limits = self._cores[0].hardware.limits
        joints = [
            replace(joint, limits=limits.get(joint.name, joint.limits))
            for joint in map(self._model.joint, names)
        ]
        ranges = np.array([position_range(joint) for joint in joints])
        chosen = positions[rows]
        is_beyond = (chosen < ranges[:, 0]) | (chosen > ranges[:, 1])
        if is_beyond.any():
            i, m, k = np.argwhere(is_beyond)[0].tolist()
            where = f"point {m} of copy {rows[i]}"
            check_position(joints[k], float(chosen[i, m, k]), where)

    def _start(
        self,
        rows: Indices,
        parts: list[_Part],
        positions: Array,
        velocities: Array | None,
        times: Sequence[float],
    ) -> None:
        """Start trajectories through points (n, m, k)."""
        self._change()
        for part in parts:
            q = positions[..., part.columns]
            qd = None if velocities is None else velocities[..., part.columns]
            if self._start_native(rows, part, q, qd, times):
                continue
            for i in rows.tolist():
                points = [
                    TrajectoryPoint(
                        q[i, m].tolist(),
                        None if qd is None else qd[i, m].tolist(),
                        time_from_start=time,
                    )
                    for m, time in enumerate(times)
                ]
                goal = TrajectoryGoal(points=points, joint_names=part.joints)
                self._host.core(i).command_trajectory(part.controller, goal)

    def _start_native(
        self,
        rows: Indices,
        part: _Part,
        positions: Array,
        velocities: Array | None,
        times: Sequence[float],
    ) -> bool:
        """Start motions without Python; False if only Python can."""
        number, joints = self._running[part.controller]
        return self._copies.start(
            rows,
            number,
            [joints.index(joint) for joint in part.joints],
            times=np.tile(times, (len(rows), 1)),
            positions=positions[rows],
            velocities=None if velocities is None else velocities[rows],
            lifts_limits=not self._driven_by_grippers.isdisjoint(part.joints),
        )

    def _grip(
        self,
        rows: Indices,
        controller: str,
        openings: Sequence[float],
        bounds: Sequence[DriveLimits],
    ) -> bool:
        """Move grippers without Python; return False if only Python can."""
        joint = bounds[0].gripper.joint if bounds else ""
        number, joints = self._running[controller]
        column = joints.index(joint) if bounds else 0
        here = self._copies.desired(rows, number, column)
        if here is None:
            return False
        points = [
            self._grip_point(bound, at, end)
            for bound, at, end in zip(bounds, here.tolist(), openings, strict=True)
        ]
        target = np.array([point.positions for point in points]).reshape(-1, 1, 1)
        times = np.array([point.time_from_start for point in points]).reshape(-1, 1)
        has_started = self._copies.start(
            rows,
            number,
            [column],
            times=times,
            positions=target,
            velocities=np.zeros_like(target),
            lifts_limits=False,
        )
        if has_started:
            index = self.joint_names.index(joint) if bounds else 0
            self._copies.set_drive_limits(rows, index, bounds)
        return has_started

    def _grip_point(
        self, bounds: DriveLimits, here: float, end: float
    ) -> TrajectoryPoint:
        """Return the motion to an opening [m] from the joint's setpoint."""
        gripper = bounds.gripper
        speed = bounds.speed or gripper.speed[1]
        start = gripper.opening(here)
        return direct_motion(gripper, start, end, speed, self.control_period)

    @cached_property
    def _running(self) -> dict[str, tuple[int, tuple[str, ...]]]:
        """Number and joints of each running controller, in load order."""
        manager = self._cores[0].manager
        names = [s.name for s in manager.list() if s.state == "running"]
        return {
            name: (number, manager.spec(name).joints)
            for number, name in enumerate(names)
        }

    def _gripper_controller(self, gripper: ParallelGripper) -> tuple[str, str]:
        """Return name and kind of the running controller that drives a gripper."""
        statuses = self._cores[0].manager.list()
        kinds = (TRAJECTORY_KIND, GRIPPER_KIND)
        for status in statuses:
            is_owner = status.state == "running" and gripper.joint in status.joints
            if is_owner and status.kind in kinds:
                return status.name, status.kind
        raise ControlError(why_not_driven(statuses, [gripper.joint], kinds))

    def _snapshot(self, i: int) -> Snapshot:
        """Return the state of one copy, for its image."""
        core = self._host.observed(i)
        state = core.state
        return Snapshot(
            time=core.time,
            tick=core.ticks,
            joint_names=self.joint_names,
            position=tuple(state.position),
            velocity=tuple(state.velocity),
            effort=tuple(state.effort),
            controllers=core.manager.list(),
            is_paused=False,
            is_stopped=False,
            real_time_factor=0.0,
            overruns=0,
            scene=core.scene.objects,
            objects=core.engine.world.object_states(),
        )


def _only_scene(scenes: list[Scene]) -> Scene:
    """Return the scene of all copies, or raise ConfigError."""
    if any(scene != scenes[0] for scene in scenes):
        raise ConfigError(
            "on a GPU, all copies have the same scene; place their objects with "
            "Batch.place, or use device='cpu'"
        )
    return scenes[0]


def _named(
    parts: Mapping[str, Item], name: str | None, kind: str, model: RobotModel
) -> Item:
    """Return a part by name, or the only one; ControlError otherwise."""
    if name is None:
        return only_part(parts, kind, model)
    if name not in parts:
        raise ControlError(f"no {kind} '{name}'{did_you_mean(name, set(parts))}")
    return parts[name]


def _check_starts(joints: Sequence[Joint], positions: Array, rows: Indices) -> None:
    """Raise LimitsError for positions (n, k) outside the joints' limits."""
    for k, joint in enumerate(joints):
        limits = joint.limits
        for i in rows.tolist():
            if not limits.lower <= positions[i, k] <= limits.upper:
                raise LimitsError(
                    f"Batch.reset: position {positions[i, k]} of joint '{joint.name}' "
                    f"in copy {i} is outside [{limits.lower}, {limits.upper}]"
                )


def _frozen(values: FrozenArray) -> FrozenArray:
    values.flags.writeable = False
    return values


def _checked_count(n: int) -> int:
    if not isinstance(n, int | np.integer) or isinstance(n, bool) or n < 1:
        raise ConfigError(f"a batch needs a whole number of copies, 1 or more, got {n}")
    return int(n)


def _checked_threads(threads: int | None, n: int) -> int:
    if threads is None:
        return min(n, os.cpu_count() or 1)
    if not isinstance(threads, int | np.integer) or not 1 <= threads <= n:
        raise ConfigError(
            f"threads must be within 1 … {n}, the number of copies, got {threads}"
        )
    return int(threads)


def _checked_scenes(scenes: list[Scene], n: int) -> list[Scene]:
    """Return the scenes, which differ only in what may differ between copies."""
    if len(scenes) != n:
        raise ConfigError(f"give one scene for all copies, or {n}, got {len(scenes)}")
    first = scenes[0]
    for i, scene in enumerate(scenes):
        names, wanted = ([o.name for o in each.objects] for each in (scene, first))
        if names != wanted:
            raise ConfigError(
                f"scene {i} has objects {', '.join(names) or 'none'}; the first has "
                f"{', '.join(wanted) or 'none'}; they must be the same"
            )
        for item, other in zip(scene.objects, first.objects, strict=True):
            what = None
            if item.geometry != other.geometry:
                what = "another shape"
            elif (item.mass is None) != (other.mass is None):
                what = "no mass" if item.mass is None else "a mass"
            if what is not None:
                raise ConfigError(
                    f"object '{item.name}' of scene {i} has {what}, unlike that of the "
                    "first; copies differ in mass, friction, pose and colour only"
                )
    return scenes
