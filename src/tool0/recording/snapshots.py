"""The snapshots of a recording, which are created on access."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Protocol, final, overload

import numpy as np
from numpy.typing import NDArray

from tool0.description.scene import SceneObject
from tool0.description.scene_state import Contact, ObjectState
from tool0.protocol.state import ArmSample, JointSetpoint, MotionMode, Snapshot
from tool0.recording.damage import damage
from tool0.recording.robot import RecordedRobot

Array = NDArray[np.float64]

_DEFAULTS: Final[Mapping[str, Any]] = {
    "controllers": (),
    "is_paused": False,
    "is_stopped": False,
    "real_time_factor": 0.0,
    "overruns": 0,
}
"""Values of the state for snapshots before the first state record, which may be missing
in a truncated file."""


class Arrays(Protocol):
    """Arrays with a row for every snapshot, such as those of ``RecordingFile``."""

    def __len__(self) -> int: ...
    @property
    def path(self) -> Path: ...
    @property
    def joint_names(self) -> tuple[str, ...]: ...
    @property
    def robot(self) -> RecordedRobot: ...
    @property
    def tick(self) -> NDArray[np.int64]: ...
    @property
    def step(self) -> NDArray[np.int64]: ...
    @property
    def time(self) -> Array: ...
    @property
    def position(self) -> Array: ...
    @property
    def velocity(self) -> Array: ...
    @property
    def effort(self) -> Array: ...
    @property
    def desired_position(self) -> Array: ...
    @property
    def desired_velocity(self) -> Array: ...
    @property
    def tool_poses(self) -> Mapping[str, Array]: ...
    @property
    def objects(self) -> Mapping[str, Array]: ...
    @property
    def wrenches(self) -> Mapping[str, Array]: ...
    @property
    def contacts(self) -> Sequence[tuple[Contact, ...]]: ...
    @property
    def gripper_states(self) -> Mapping[str, Array]: ...


@final
@dataclass(frozen=True, slots=True)
class _State:
    """Rarely changing values that are valid from one snapshot to the next change."""

    fields: Mapping[str, Any]
    scene: tuple[SceneObject, ...]
    targets: Mapping[str, float]
    modes: Mapping[str, MotionMode]


@final
class Snapshots(Sequence[Snapshot]):
    """Sequence of a recording's snapshots, with the data that the file contains."""

    def __init__(
        self, recording: Arrays, changes: Mapping[int, Mapping[str, Any]]
    ) -> None:
        """Store ``changes``, which maps snapshot numbers to changed fields."""
        self._recording = recording
        state = _State(_DEFAULTS, (), {}, {})
        self._starts = [0]
        self._states = [state]
        for frame, fields in sorted(changes.items()):
            state = self._after(state, fields)
            self._starts.append(frame)
            self._states.append(state)

    def __len__(self) -> int:
        """Return the number of snapshots."""
        return len(self._recording)

    @overload
    def __getitem__(self, index: int) -> Snapshot: ...
    @overload
    def __getitem__(self, index: slice) -> list[Snapshot]: ...
    def __getitem__(self, index: int | slice) -> Snapshot | list[Snapshot]:
        """Return one snapshot, or a list of snapshots for a slice."""
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        i = range(len(self))[index]
        with damage(self._recording.path, f"snapshot {i}"):
            return self._at(i)

    def _after(self, before: _State, changes: Mapping[str, Any]) -> _State:
        fields = {**before.fields, **changes}
        infos = fields.pop("scene", None)
        fields.pop("bodies", None)
        return _State(
            targets=fields.pop("targets", before.targets),
            modes=fields.pop("modes", before.modes),
            scene=before.scene
            if infos is None
            else tuple(self._recording.robot.scene(infos)),
            fields=fields,
        )

    def _at(self, i: int) -> Snapshot:
        recording = self._recording
        names = recording.joint_names
        state = self._states[bisect_right(self._starts, i) - 1]
        desired = recording.desired_position[i].tolist()
        speed = recording.desired_velocity[i].tolist()
        targets, objects = state.targets, recording.objects
        return Snapshot(
            **state.fields,
            time=float(recording.time[i]),
            tick=int(recording.tick[i]),
            step=int(recording.step[i]),
            joint_names=names,
            position=tuple(recording.position[i].tolist()),
            velocity=tuple(recording.velocity[i].tolist()),
            effort=tuple(recording.effort[i].tolist()),
            received_setpoints={
                name: JointSetpoint(p, v, targets.get(name, p))
                for name, p, v in zip(names, desired, speed, strict=True)
                if not math.isnan(p)
            },
            scene=state.scene,
            contacts=recording.contacts[i],
            arms={
                arm: _arm_sample(
                    recording.robot.arms[arm], mode, recording.wrenches[arm][i].tolist()
                )
                for arm, mode in state.modes.items()
                if arm in recording.wrenches
            },
            objects=tuple(
                ObjectState(item.name, tuple(pose[:3]), tuple(pose[3:]))
                for item in state.scene
                for pose in (objects[item.name][i].tolist(),)
            ),
        )


def _arm_sample(
    joint_names: tuple[str, ...], mode: MotionMode, wrench: Sequence[float]
) -> ArmSample:
    """Return the recorded motion of an arm."""
    fx, fy, fz, tx, ty, tz = wrench
    return ArmSample(
        mode=mode,
        setpoint=None,
        path=0,
        path_time=0.0,
        is_done=True,
        force_mode=False,
        wrench=(fx, fy, fz, tx, ty, tz),
        joint_names=joint_names,
    )


def held(values: Array, frames: Sequence[int], n_frames: int) -> Array:
    """Return values for all frames; each sample is held until the next sample."""
    array = np.full((n_frames, values.shape[1]), math.nan)
    array[frames] = values
    row = np.zeros(n_frames, dtype=np.intp)
    row[frames] = frames
    filled: Array = array[np.maximum.accumulate(row)]
    return filled
