"""An environment with a running robot, which may be simulated or real.

Observations and actions have the form of ``tool0 export --format lerobot``, so policies
that were trained on demonstrations of a robot can control it.  An action is the
position of each driven joint at the end of a control period.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final, final

import numpy as np

from tool0.collect.demonstrations import (
    OBJECT,
    driven_joints,
    number_names,
    surroundings_of,
)
from tool0.errors import ConfigError, Tool0Error
from tool0.policy.environment import ActionRefusedError, Array, Outcome
from tool0.policy.seen import Seen

if TYPE_CHECKING:
    from tool0.api.arm_motion import ArmMotion
    from tool0.api.gripper import Gripper
    from tool0.api.robot import Robot

BY: Final = "policy"
"""Name under which the policy takes control of the arms, which is shown to users."""
FASTEST: Final = 0.9
"""Largest speed of an arm's joint, as a fraction of its velocity limit."""
_LOOKAHEAD: Final = 1.5
"""Lookahead of the servo motion [control periods].  A smaller lookahead reproduces the
steps between targets.  A larger lookahead increases the lag.  With a lookahead of 1.5
control periods, the lag is one control period."""
_LOOKAHEADS: Final = (0.03, 0.2)
"""Range of the lookahead [s]."""
_DEADBAND: Final = 0.02
"""Smallest change of a gripper's target that moves the gripper, as a fraction of the
joint's range."""
_SILENCE: Final = 0.3
"""Pause after which the next target starts a new stream [wall s].  The arm ends a
stream after a pause of 0.5 s."""
_LONGEST_STOP: Final = 2.0
"""Longest wait for an arm to stop [s]; see ``GoalHandle.wait``."""
_POLL: Final = 0.1
"""Longest time between checks for a stop request while simulated time is paused [wall
s]."""


@final
class RobotEnvironment:
    """Environment that observes a robot and streams targets to arms and grippers."""

    def __init__(
        self,
        robot: Robot,
        *,
        rate: float = 25.0,
        cameras: Sequence[str] = (),
        instruction: str = "",
        should_stop: Callable[[], bool] = lambda: False,
    ) -> None:
        """Prepare the environment without moving the robot.

        Args:
            robot: The robot, which remains open when the environment is closed.
            rate: Actions per simulated second [Hz].
            cameras: Names of the cameras that provide images for observations.
            instruction: Description of the task.
            should_stop: Callback that is called during a wait.  If the callback returns
                True, the wait ends.

        Raises:
            ConfigError: If a driven joint is not a joint of an arm or a gripper, or the
                rate is out of range.
            RenderError: If there is no such camera.
        """
        if not 1.0 <= rate <= 125.0:
            raise ConfigError(f"rate must be 1 … 125 Hz, got {rate:g}")
        self._robot, self.rate = robot, rate
        self.instruction, self._should_stop = instruction, should_stop
        self._cameras = {name: robot.camera(name) for name in cameras}
        snapshot = robot.snapshot
        names = snapshot.joint_names
        self._joints = driven_joints(robot.description.model, names)
        self._columns = [names.index(name) for name in self._joints]
        self._arms = {
            name: [self._joints.index(joint) for joint in arm.joint_names]
            for name, arm in robot.arms.items()
            if set(arm.joint_names) <= set(self._joints)
        }
        self._grippers: dict[int, Gripper] = {
            self._joints.index(gripper.geometry.joint): gripper
            for gripper in robot.grippers.values()
        }
        driven = {*self._grippers, *(k for arm in self._arms.values() for k in arm)}
        for k, joint in enumerate(self._joints):
            if k not in driven:
                raise ConfigError(
                    f"a policy drives arms and grippers; joint '{joint}' is of neither"
                )
        limits = [robot.joint_limits[name] for name in self._joints]
        self.limits = (
            np.array([item.lower for item in limits]),
            np.array([item.upper for item in limits]),
        )
        speed = np.array([item.velocity for item in limits])
        self._lookahead = float(np.clip(_LOOKAHEAD / rate, *_LOOKAHEADS))
        self._largest_step = FASTEST * speed / rate
        """Largest step of each joint in a control period [rad], shape (m,), which is
        infinite for grippers because their speed is limited separately."""
        self._largest_step[list(self._grippers)] = np.inf
        movable = [item.name for item in snapshot.scene if item.mass is not None]
        self._objects = movable
        self.names = number_names(self._joints, movable)
        """Names of the components of the observations and of the action."""
        self.surroundings = surroundings_of(self.names)
        """Names of the numbers that the robot's sensors cannot measure."""
        self.action_names = self.names["action"]
        self._target = np.zeros(len(self._joints))
        self._grip = dict.fromkeys(self._grippers, 0.0)
        self._start, self._step = 0.0, 0
        self._sent = 0.0
        """Time at which targets were last sent [wall s]."""

    @property
    def is_realtime(self) -> bool:
        """Whether the simulation runs in real time."""
        return self._robot.is_realtime

    def begin(self, seed: int) -> None:
        """Take control of the arms, with their current positions as first targets.

        Raises:
            ControlError: If an arm is switched off, stopped, or controlled by another
                program.
        """
        for name in self._arms:
            self._robot.arms[name].motion.take(BY)
        snapshot = self._robot.snapshot
        position = np.array(snapshot.position)[self._columns]
        self._target = position.clip(*self.limits)  # limits may be exceeded
        self._grip = {k: float(self._target[k]) for k in self._grippers}
        self._start, self._step = snapshot.time, 0

    def see(self) -> Seen:
        """Return the current observation of the robot.

        Raises:
            RenderError: If a camera cannot render an image.
        """
        snapshot = self._robot.snapshot
        position = np.array(snapshot.position)[self._columns]
        velocity = np.array(snapshot.velocity)[self._columns]
        poses = {item.name: item for item in snapshot.objects}
        values = {"position": position, "velocity": velocity}
        for name in self._objects:
            if name not in poses:
                raise ConfigError(f"object '{name}' has been removed from the scene")
            pose = poses[name]
            values[f"{OBJECT}{name}"] = np.array([*pose.position, *pose.quat_wxyz])
        images = {name: camera.image().rgb for name, camera in self._cameras.items()}
        return Seen(
            observation={**values, **images},
            values={**values, **images},
            kept=values,  # images can be rendered from the recording
            names=self.names,
            surroundings=self.surroundings,
            instruction=self.instruction,
        )

    def hold(self) -> Array:
        """Return the current targets [rad | m], shape (m,)."""
        return self._target.copy()

    def act(self, action: Array) -> Outcome:
        """Send targets [rad | m], shape (m,), and wait for one control period.

        Raises:
            ActionRefusedError: If the action requires a joint of an arm to move too
                fast.
            ControlError: If the robot rejects the targets, or the policy no longer
                controls the arm.
        """
        near = self.nearest(action)
        if (near != action).any():
            k = int(np.argmax(np.abs(near - action)))
            raise ActionRefusedError(
                f"the action moves '{self._joints[k]}' from {self._target[k]:.3f} to "
                f"{action[k]:.3f} rad within {1.0 / self.rate:.3g} s; at most "
                f"{self._largest_step[k]:.3f} rad are allowed"
            )
        self.send(action)
        self._step += 1
        self._wait_until(self._start + self._step / self.rate)
        return Outcome()

    def nearest(self, action: Array) -> Array:
        """Return the allowed targets that are nearest to an action, shape (m,).

        The allowed targets are within the joint limits and within the largest step from
        the current targets.
        """
        step = np.clip(action - self._target, -self._largest_step, self._largest_step)
        near = np.where(np.abs(step) < self._largest_step, action, self._target + step)
        return np.asarray(np.clip(near, *self.limits))

    def send(self, action: Array) -> None:
        """Send targets [rad | m], shape (m,), without waiting.

        After a pause, the arms begin a new stream from the positions at which they came
        to rest.

        Raises:
            ControlError: If the robot rejects the targets, or the policy no longer
                controls the arm.
        """
        now = time.monotonic()
        was_silent, self._sent = now - self._sent > _SILENCE, now
        for name, columns in self._arms.items():
            motion = self._robot.arms[name].motion
            if was_silent:
                motion.stop()
            motion.servo_joints(
                action[columns].tolist(), lookahead_time=self._lookahead
            )
        for k, gripper in self._grippers.items():
            low, high = (float(limit[k]) for limit in self.limits)
            if abs(action[k] - self._grip[k]) > _DEADBAND * (high - low):
                self._grip[k] = float(action[k])
                gripper.move(position=self._grip[k])
        self._target = action.copy()

    def _wait_until(self, end: float) -> None:
        """Wait until simulated time reaches ``end`` [s], or a stop is requested."""
        robot = self._robot
        if not robot.is_realtime:
            robot.run(max(0.0, end - robot.time))
            return
        while not self._should_stop():
            if robot.channel.wait_until(lambda: robot.time >= end - 1e-9, _POLL):
                return

    def picture(self) -> None:
        """Return None, because images can be rendered from the recording later."""

    def end(self) -> None:
        """Stop the arms and return control to their controllers."""
        for name in self._arms:
            motion = self._robot.arms[name].motion
            with contextlib.suppress(Tool0Error):  # the arm is free or stopped
                motion.release()
                self._robot.channel.wait_until(partial(_is_free, motion), _LONGEST_STOP)

    def close(self) -> None:
        """Do nothing, because the robot remains open."""


def _is_free(motion: ArmMotion) -> bool:
    return motion.state.mode == "free"
