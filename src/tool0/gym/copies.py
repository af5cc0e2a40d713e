"""n copies of a task, which reset, act and observe together."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tool0.batch.backend import CPU
from tool0.batch.batch import Batch
from tool0.batch.saved import BatchState
from tool0.gym.actions import Actions
from tool0.gym.arms import ArmCopies
from tool0.gym.bounds import FARTHEST, columns, reading
from tool0.gym.checks import check_functions, check_objects, check_start
from tool0.gym.held import grasped
from tool0.gym.looks import Looks
from tool0.gym.options import EnvOptions
from tool0.gym.sizes import Sizes
from tool0.gym.task import Mask, State, Task
from tool0.gym.tasks import task_class
from tool0.gym.workspace import workspaces
from tool0.kinematics.chain import Array

MOVING = 0.4
"""Duration of the motion to a random start pose if the arm holds an object [s]."""


@final
class Copies:
    """n copies of one task."""

    def __init__(self, task: str | type[Task], n: int, options: EnvOptions) -> None:
        """Make the copies; each copy must be reset before its first action.

        Raises:
            Tool0Error: If an option is wrong.
        """
        self.n = n
        self.options = options
        self._ticks = options.ticks
        self._task_class = of = task_class(task)
        spaces = workspaces(options, of.arms, of.distance_of_arms)
        self.workspace = next(iter(spaces.values()))
        self.task = of(self.workspace)
        self._scene = scene = self.task.scene()
        self._items = check_objects(self.task, scene)
        self._sizes = Sizes(self.task, self._items, self.workspace, options, n)
        self.batch = batch = self._make_batch(n, options.threads, options.device)
        self.arms = tuple(
            ArmCopies(batch, space, options, has_wrench=self.task.needs_wrench)
            for space in spaces.values()
        )
        """The arms, in the order of actions and observations."""
        self.actions = Actions([arm.actions for arm in self.arms])
        self._objects = columns(
            [batch.object_names.index(x) for x in self.task.objects]
        )
        self._start = batch.position[0].copy()
        for arm in self.arms:
            arm.put(self._start, arm.space.start)
        drawn = check_start(self.task, self.task.draw(np.random.default_rng(0)))
        self._goal = np.zeros((n, len(drawn.goal)))
        self._looks: Looks | None = None
        if options.ranges is not None and options.observation == "image":
            cameras = self.workspace.cameras
            self._looks = Looks(batch, options.ranges, scene.objects, cameras)
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
        """Return new copies in the same state."""
        twin = Copies(self._task_class, self.n, self.options)
        twin.batch.restore(self.batch.save())
        twin._sizes.extents = self._sizes.extents.copy()
        for arm, own in zip(twin.arms, self.arms, strict=True):
            arm.copy_from(own)
        twin._goal = self._goal.copy()
        twin._state = twin._goals = None
        return twin

    # ---- time -----------------------------------------------------------------------

    def reset(self, which: Mask, generators: Sequence[np.random.Generator]) -> None:
        """Start new episodes of the copies in ``which``, shape (n,).

        All random values of copy i come from generator i, so an episode does not depend
        on the other copies.
        """
        n, count = self.n, len(self.task.objects)
        q = [np.tile(arm.space.start, (n, 1)) for arm in self.arms]
        places, yaws = np.zeros((n, count, 3)), np.zeros((n, count))
        mass, friction, factor = np.ones((3, n, count))
        is_held = np.zeros(n, dtype=bool)
        for i in np.flatnonzero(which).tolist():
            rng = generators[i]
            places[i], yaws[i], self._goal[i], is_held[i] = self.task.draw(rng)
            if self.options.ranges is not None:
                mass[i], friction[i] = self._disturbances(rng)
                for each in q:
                    noise = rng.uniform(-1.0, 1.0, each.shape[1])
                    each[i] += noise * self.options.ranges.joint_noise
                factor[i] = self._sizes.draw(rng)
        batch = self.batch
        self._put_arms(which & ~is_held, q)
        if is_held.any():
            batch.restore(self._grasp, is_held, source=0)
        if self._looks is not None:
            for i in np.flatnonzero(which).tolist():
                self._looks.draw(i, generators[i])
        self._sizes.apply(batch, factor, which)
        places = self._sizes.risen(places)
        quat = np.zeros((n, count, 4))
        quat[..., 0], quat[..., 3] = np.cos(yaws / 2.0), np.sin(yaws / 2.0)
        for k, item in enumerate(self._items):
            if self.options.ranges is not None:
                batch.set_friction(item.name, friction[:, k], which)
                if item.mass is not None:
                    batch.set_mass(item.name, mass[:, k], which)
            placed = which if k else which & ~is_held
            batch.place(item.name, places[:, k], quat[:, k], placed)
        for arm, each in zip(self.arms, q, strict=True):
            arm.restart(which, each, is_held & (arm is self.arms[0]))
        if is_held.any() and self.options.ranges is not None:
            for arm, each in zip(self.arms, q, strict=True):
                arm.move(each, MOVING, is_held)
            batch.step(round(MOVING / batch.control_period), is_held)
        for arm in self.arms:
            arm.settle(which)
        self._state = self._goals = None

    def _disturbances(self, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return random masses [kg] and friction coefficients of the objects."""
        ranges = self.options.ranges
        assert ranges is not None
        count = len(self._items)
        own = np.array([(item.mass or 0.0, item.friction) for item in self._items])
        own = own.reshape(count, 2)
        mass = own[:, 0] * rng.uniform(*ranges.mass, count)
        friction = own[:, 1] * rng.uniform(*ranges.friction, count)
        return mass, friction

    def _put_arms(self, which: Mask, q: Sequence[Array]) -> None:
        """Reset copies, set the arms to ``q`` [rad], (n, 6), and open the grippers."""
        position = np.tile(self._start, (self.n, 1))
        for arm, each in zip(self.arms, q, strict=True):
            arm.put(position, each)
        self.batch.reset(which, position)

    @cached_property
    def _grasp(self) -> BatchState:
        """State of a single copy with the first object in the first gripper."""
        assert self.task.hold is not None
        with self._make_batch(1, 1, CPU) as batch:
            return grasped(
                batch,
                self._items[0],
                space=self.workspace,
                hold=self.task.hold,
                force=self.arms[0].force,
                start=self._start,
            )

    def act(self, actions: Array) -> None:
        """Advance all copies by one control period with checked ``actions``."""
        measured = self.state.arms.values()
        given = self.actions.of_arms(actions)
        for arm, each, state in zip(self.arms, given, measured, strict=True):
            arm.act(each, state.opening)
        self.batch.step(self._ticks)
        self._state = self._goals = None

    # ---- state and results ----------------------------------------------------------

    @property
    def state(self) -> State:
        """Measured state of all copies."""
        if self._state is None:
            self._state = self._measure()
        return self._state

    def goals(self) -> tuple[Array, Array]:
        """Return the achieved goals and the desired goals, each of shape (n, g)."""
        if self._goals is None:
            task, state = self.task, self.state
            self._goals = task.achieved(state), task.desired(state)
        return self._goals

    def _measure(self) -> State:
        batch = self.batch
        read = reading(batch.diverged)
        return State(
            arms={arm.space.arm: arm.measure() for arm in self.arms},
            object_position=read(batch.object_position[:, self._objects]),
            object_quat=read(batch.object_quat[:, self._objects]),
            object_velocity=read(batch.object_linear[:, self._objects]),
            object_size=self._sizes.extents,
            goal=self._goal.copy(),
        )

    @property
    def resized(self) -> tuple[str, ...]:
        """Names of the objects with random sizes."""
        return self._sizes.names

    def rewards(self, success: Mask) -> Array:
        """Return the rewards, shape (n,); a diverged copy gets the worst reward."""
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
        """Return the rewards that are computed from the goals alone, shape (…)."""
        success = self.task.is_success(achieved, desired)
        if self.options.reward == "sparse":
            return np.where(success, 0.0, -1.0)
        distance = self.task.distance(achieved, desired)
        return np.where(success, 0.0, -np.tanh(5.0 * distance))

    def successes(self) -> Mask:
        """Return for each copy whether the task is done, shape (n,)."""
        task = self.task
        done = task.is_success(*self.goals())
        return done & ~self.batch.diverged

    def checked(self, actions: ArrayLike) -> Array:
        """Return actions as an array of shape (n, m), or raise ControlError."""
        return self.actions.checked(actions, self.n)

    def image(self, i: int) -> NDArray[np.uint8]:
        """Return the first camera's image of copy ``i``, shape (height, width, 3)."""
        return self.batch.render(i, self.options.cameras[0]).rgb

    def images(self) -> dict[str, NDArray[Any]]:
        """Return the cameras' images of all copies.

        The key ``rgb`` contains uint8 values of shape (n, height, width, 3).  If depth
        images are enabled, the key ``depth`` contains float32 values of shape (n,
        height, width), which are at most ``FARTHEST`` [m].  If segmentation is enabled,
        the key ``segmentation`` contains int32 values of shape (n, height, width),
        which are defined in ``Batch.segment_all``.  If there are several cameras, the
        camera's name is appended to each key, as in ``rgb_scene``.
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
