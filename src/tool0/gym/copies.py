"""n copies of a task: reset, act, observe, all of them at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tool0.batch.arguments import are_finite
from tool0.batch.backend import CPU
from tool0.batch.batch import Batch
from tool0.batch.saved import BatchState
from tool0.gym.actions import Actions
from tool0.gym.checks import check_functions, check_objects, check_start
from tool0.gym.held import grasped
from tool0.gym.looks import Looks
from tool0.gym.options import EnvOptions
from tool0.gym.task import Mask, State, Task
from tool0.gym.tasks import task_class
from tool0.gym.workspace import Workspace
from tool0.kinematics.chain import Array

GRIP_FORCE = 60.0
"""At each pad [N], as far as the gripper can."""
MOVING = 0.4
"""Time in which an arm that holds an object moves to its random start [s]."""
DEADBAND = 0.02
"""Change of a gripper's target that moves it, part of its largest opening."""
FARTHEST = 10.0
"""Bound of coordinates in observations [m]."""
FASTEST_OBJECT = 20.0
"""Bound of velocities of objects in observations [m/s]."""
STRONGEST, MOST_TORQUE = 1000.0, 100.0
"""Bounds of wrenches in observations [N], [N·m]."""


_XYZ: Final = ("x", "y", "z")
_WXYZ: Final = ("qw", "qx", "qy", "qz")
_WRENCH: Final = ("fx", "fy", "fz", "tx", "ty", "tz")
_SPEED: Final = ("vx", "vy", "vz")


class ObservationPart(NamedTuple):
    """One part of the state that an observation has."""

    name: str
    columns: tuple[str, ...]
    """Names of its m numbers."""
    low: Array
    """Shape (m,)."""
    high: Array
    """Shape (m,)."""
    of_robot: bool = True
    """Whether a robot measures it on itself; otherwise it is of its surroundings."""


@final
class Copies:
    """n copies of one task.  Each one has a random generator of its own."""

    def __init__(self, task: str | type[Task], n: int, options: EnvOptions) -> None:
        """Make the copies; each needs a reset before it acts.

        Raises:
            Tool0Error: If an option is wrong.
        """
        self.n = n
        self.options = options
        self._task_class = task_class(task)
        self.workspace = workspace = Workspace(options)
        self.task = self._task_class(workspace)
        self.actions = Actions(workspace, options)
        scene = self.task.scene()
        self._items = check_objects(self.task, scene)
        self._scene = scene
        self.batch = self._make_batch(n, options.threads, options.device)
        names, gripper = self.batch.joint_names, workspace.gripper
        self._arm = _columns([names.index(x) for x in workspace.chain.joint_names])
        self._drive = names.index(gripper.joint)
        numbers = [self.batch.object_names.index(x) for x in self.task.objects]
        self._objects = _columns(numbers)
        self._start = self.batch.position[0].copy()
        self._start[self._arm] = workspace.start
        self._start[self._drive] = gripper.position(gripper.max_opening)
        self._force = min(max(GRIP_FORCE, gripper.force[0]), gripper.force[1])
        self.target = np.tile(workspace.start, (n, 1))
        """Targets of the arm's joints [rad], shape (n, 6)."""
        self._opening_target = np.full(n, gripper.max_opening)
        self._last_opening = self._opening_target.copy()
        drawn = check_start(self.task, self.task.draw(np.random.default_rng(0)))
        self._goal = np.zeros((n, len(drawn.goal)))
        self._looks: Looks | None = None
        if options.ranges is not None and options.observation == "image":
            cameras = workspace.cameras
            self._looks = Looks(self.batch, options.ranges, scene.objects, cameras)
        self._state: State | None = None
        self._goals: tuple[Array, Array] | None = None
        check_functions(self.task, self.state)

    def _make_batch(self, n: int, threads: int | None, device: str) -> Batch:
        return Batch(
            n,
            description=self.workspace.description,
            scene=self._scene,
            dt=self.options.dt,
            threads=threads,
            device=device,
        )

    def __deepcopy__(self, memo: dict[int, object]) -> Copies:
        """Return other copies in the same state."""
        twin = Copies(self._task_class, self.n, self.options)
        twin.batch.restore(self.batch.save())
        twin.target = self.target.copy()
        twin._opening_target = self._opening_target.copy()
        twin._last_opening = self._last_opening.copy()
        twin._goal = self._goal.copy()
        twin._state = twin._goals = None
        return twin

    # ---- time -----------------------------------------------------------------------

    def reset(self, which: Mask, generators: Sequence[np.random.Generator]) -> None:
        """Start new episodes of the copies in ``which``, shape (n,).

        What is random comes from each copy's own generator alone, so that an episode
        does not depend on the other copies.
        """
        n, count = self.n, len(self.task.objects)
        q = np.tile(self.workspace.start, (n, 1))
        places, yaws = np.zeros((n, count, 3)), np.zeros((n, count))
        mass, friction = np.ones((n, count)), np.ones((n, count))
        is_held = np.zeros(n, dtype=bool)
        for i in np.flatnonzero(which).tolist():
            rng = generators[i]
            places[i], yaws[i], self._goal[i], is_held[i] = self.task.draw(rng)
            if self.options.ranges is not None:
                mass[i], friction[i], noise = self._disturbances(rng)
                q[i] += noise
        batch = self.batch
        self._put_arms(which & ~is_held, q)
        if is_held.any():
            batch.restore(self._grasp, is_held, source=0)
        if self._looks is not None:
            for i in np.flatnonzero(which).tolist():
                self._looks.draw(i, generators[i])
        quat = np.zeros((n, count, 4))
        quat[..., 0], quat[..., 3] = np.cos(yaws / 2.0), np.sin(yaws / 2.0)
        for k, item in enumerate(self._items):
            if self.options.ranges is not None:
                batch.set_friction(item.name, friction[:, k], which)
                if item.mass is not None:
                    batch.set_mass(item.name, mass[:, k], which)
            placed = which if k else which & ~is_held
            batch.place(item.name, places[:, k], quat[:, k], placed)
        self._opening_target[which] = self.workspace.gripper.max_opening
        self._opening_target[is_held] = 0.0
        if is_held.any() and self.options.ranges is not None:
            batch.command(q, velocities=0.0 * q, duration=MOVING, which=is_held)
            batch.step(round(MOVING / batch.control_period), is_held)
        self.target[which] = q[which]
        self._last_opening[which] = batch.opening()[which]
        self._state = self._goals = None

    def _disturbances(self, rng: np.random.Generator) -> tuple[Array, Array, Array]:
        """Return masses and frictions of the objects, and deviations of the joints."""
        ranges = self.options.ranges
        assert ranges is not None
        count = len(self._items)
        own = np.array([(item.mass or 0.0, item.friction) for item in self._items])
        own = own.reshape(count, 2)
        mass = own[:, 0] * rng.uniform(*ranges.mass, count)
        friction = own[:, 1] * rng.uniform(*ranges.friction, count)
        noise = rng.uniform(-1.0, 1.0, len(self.workspace.start)) * ranges.joint_noise
        return mass, friction, noise

    def _put_arms(self, which: Mask, q: Array) -> None:
        """Reset copies, with their arms at ``q`` [rad], (n, 6), and open grippers."""
        position = np.tile(self._start, (self.n, 1))
        position[:, self._arm] = q
        self.batch.reset(which, position)

    @cached_property
    def _grasp(self) -> BatchState:
        """The start with the first object in the gripper, of one copy."""
        space, hold, item = self.workspace, self.task.hold, self._items[0]
        assert hold is not None
        place = np.array([*space.start_position[:2], item.pose.xyz[2]])
        yaw = space.start_yaw
        quat = np.array([[np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0)]])
        low = self._start.copy()
        low[self._arm] = space.posture(hold.places(place[None], quat)[0])
        with self._make_batch(1, 1, CPU) as batch:
            return grasped(
                batch,
                item.name,
                place=place,
                yaw=yaw,
                hold=hold,
                force=self._force,
                low=low,
                high=space.start,
            )

    def act(self, actions: Array) -> None:
        """Advance all copies by one control period; ``actions`` are checked ones."""
        batch, options = self.batch, self.options
        q = batch.position[:, self._arm]
        which = None
        if not are_finite(q) or np.count_nonzero(batch.diverged):
            which = np.isfinite(q).all(axis=1) & ~batch.diverged
        self._last_opening = self.state.opening
        moved = self.actions.positions(actions, self.target, q)
        if which is not None:
            moved = np.where(which[:, None], moved, self.target)
        self.target = moved
        batch.command(
            self.target,
            duration=options.period,
            joints=self.workspace.chain.joint_names,
            which=which,
        )
        widest = self.workspace.gripper.max_opening
        openings = self.actions.openings(actions)
        is_new = np.abs(openings - self._opening_target) > DEADBAND * widest
        if np.count_nonzero(is_new):
            self._opening_target = np.where(is_new, openings, self._opening_target)
            batch.move_gripper(self._opening_target, force=self._force, which=is_new)
        batch.step(options.ticks)
        self._state = self._goals = None

    # ---- what there is --------------------------------------------------------------

    @property
    def state(self) -> State:
        """What is measured now."""
        if self._state is None:
            self._state = self._measure()
        return self._state

    def goals(self) -> tuple[Array, Array]:
        """Return the goals that are achieved now, and those to achieve, (n, g)."""
        if self._goals is None:
            task, state = self.task, self.state
            self._goals = task.achieved(state), task.desired(state)
        return self._goals

    def _measure(self) -> State:
        batch = self.batch
        q = _finite(batch.position[:, self._arm])
        pose = self.workspace.tool.pose(q)
        opening = _finite(batch.opening())
        return State(
            q=q,
            qd=_finite(batch.velocity[:, self._arm]),
            tcp_position=pose.position,
            tcp_rotation=pose.rotation,
            opening=opening,
            opening_rate=(opening - self._last_opening) / self.options.period,
            opening_target=self._opening_target.copy(),
            object_position=_finite(batch.object_position[:, self._objects]),
            object_quat=_finite(batch.object_quat[:, self._objects]),
            object_velocity=_finite(batch.object_linear[:, self._objects]),
            goal=self._goal.copy(),
            wrench=self._wrench(),
        )

    def _wrench(self) -> Array:
        if not self.task.needs_wrench:
            return np.empty((self.n, 0))
        return _finite(self.batch.tool_wrench())

    def values(self) -> list[Array]:
        """Return the observed state by its parts, each of shape (n, m)."""
        state = self.state
        values = [
            state.q,
            state.qd,
            state.tcp_position,
            self.workspace.tool.quats(state.tcp_rotation),
            state.opening[:, None],
            state.opening_target[:, None],
        ]
        if self.task.needs_wrench:
            values.append(state.wrench)
        for k in range(len(self.task.objects)):
            position = state.object_position[:, k]
            values += [
                position,
                state.object_quat[:, k],
                state.object_velocity[:, k],
                position - state.tcp_position,
            ]
        achieved, desired = self.goals()
        values += [desired, desired - achieved]
        for given in self.task.observe(state).values():
            values.append(_finite(np.asarray(given, np.float64).reshape(self.n, -1)))
        return values

    def parts(self) -> list[ObservationPart]:
        """Return what ``values`` are, in their order."""
        workspace, task = self.workspace, self.task
        fastest = 2.0 * workspace.fastest
        widest = 1.1 * workspace.gripper.max_opening
        joints = workspace.chain.joint_names
        parts = [
            ObservationPart(
                "joint_position",
                tuple(f"{name}.position" for name in joints),
                workspace.lower - 0.1,
                workspace.upper + 0.1,
            ),
            ObservationPart(
                "joint_velocity",
                tuple(f"{name}.velocity" for name in joints),
                -fastest,
                fastest,
            ),
            _symmetric("tcp_position", _of("tcp", _XYZ), FARTHEST),
            _symmetric("tcp_quat_wxyz", _of("tcp", _WXYZ), 1.0),
            *(
                ObservationPart(
                    name, (f"gripper.{name}",), np.zeros(1), np.full(1, widest)
                )
                for name in ("opening", "opening_target")
            ),
        ]
        if task.needs_wrench:
            bound = np.repeat([STRONGEST, MOST_TORQUE], 3)
            columns = _of("wrench", _WRENCH)
            parts.append(ObservationPart("wrench", columns, -bound, bound))
        # What the robot does not measure on itself: objects and goal.
        around = []
        for name in task.objects:
            away = f"tcp_to_{name}"
            around += [
                _symmetric(f"{name}_position", _of(name, _XYZ), FARTHEST),
                _symmetric(f"{name}_quat_wxyz", _of(name, _WXYZ), 1.0),
                _symmetric(f"{name}_velocity", _of(name, _SPEED), FASTEST_OBJECT),
                _symmetric(away, _of(away, _XYZ), FARTHEST),
            ]
        for name in ("goal", "to_goal"):
            around.append(_symmetric(name, _of(name, task.goal_names), FARTHEST))
        for name, given in task.observe(self.state).items():
            width = np.reshape(given, (self.n, -1)).shape[1]
            columns = _of(name, [str(k) for k in range(width)])
            around.append(_symmetric(name, columns, np.inf))
        return parts + [part._replace(of_robot=False) for part in around]

    def rewards(self, success: Mask) -> Array:
        """Return the rewards, shape (n,); a copy that diverged gets the worst."""
        state, task = self.state, self.task
        if self.options.reward == "sparse":
            found = np.where(success, 0.0, -1.0)
        elif self.options.observation == "goal":
            found = self.goal_rewards(*self.goals())
        else:
            found = task.reward(state, success)
        if not np.count_nonzero(self.batch.diverged):
            return found
        return np.where(self.batch.diverged, task.worst_reward, found)

    def goal_rewards(self, achieved: Array, desired: Array) -> Array:
        """Return the rewards that follow from goals alone, shape (…)."""
        success = self.task.is_success(achieved, desired)
        if self.options.reward == "sparse":
            return np.where(success, 0.0, -1.0)
        distance = self.task.distance(achieved, desired)
        return np.where(success, 0.0, -np.tanh(5.0 * distance))

    def successes(self) -> Mask:
        """Return whether the task is done, shape (n,)."""
        task = self.task
        done = task.is_success(*self.goals())
        return done & ~self.batch.diverged

    def checked(self, actions: ArrayLike) -> Array:
        """Return actions as numbers, shape (n, m), or raise ControlError."""
        return self.actions.checked(actions, self.n)

    def image(self, i: int) -> NDArray[np.uint8]:
        """Return what the first camera sees of copy ``i``, (height, width, 3)."""
        return self.batch.render(i, self.options.cameras[0]).rgb

    def images(self) -> dict[str, NDArray[Any]]:
        """Return what the cameras see of all copies.

        ``rgb``, uint8 of shape (n, height, width, 3), perhaps ``depth`` [m], float32 of
        shape (n, height, width), at most ``FARTHEST``, and perhaps ``segmentation``,
        int32 of that shape, as ``Batch.segment_all``; with several cameras as
        ``rgb_scene``.
        """
        found = {}
        for name, keys in self.options.image_keys.items():
            drawn = self.batch.render_all(name)
            found[keys.rgb] = np.stack([image.rgb for image in drawn])
            if self.options.depth:
                depths = np.stack([image.depth for image in drawn])
                found[keys.depth] = np.minimum(depths, np.float32(FARTHEST))
            if self.options.segmentation:
                segments = self.batch.segment_all(name)
                found[keys.segmentation] = np.stack(segments)
        return found


def _finite(values: Array) -> Array:
    """Return a copy in which what diverged is a number, too."""
    if are_finite(values):
        return values.copy()
    return np.nan_to_num(values, nan=0.0, posinf=FARTHEST, neginf=-FARTHEST)


def _columns(numbers: list[int]) -> slice | list[int]:
    """Return an index for columns: a slice, which is quicker, if they are in a row."""
    first = numbers[0] if numbers else 0
    row = slice(first, first + len(numbers))
    return row if numbers == list(range(row.start, row.stop)) else numbers


def _of(name: str, parts: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{name}.{part}" for part in parts)


def _symmetric(name: str, columns: tuple[str, ...], bound: float) -> ObservationPart:
    bounds = np.full(len(columns), bound)
    return ObservationPart(name, columns, -bounds, bounds)
