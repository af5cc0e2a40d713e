"""Simulation of a recorded run, with the same requests and simulated physics.

The recording may be from a real robot or another engine.  Requests are executed at
their recorded steps, with the recorded positions of the speed slider.  Other events,
such as a stop by a real robot's safety system or a manual push, are not reproduced.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

import msgspec
import numpy as np

from tool0.description.parts import find_arms
from tool0.errors import RecordingError, Tool0Error
from tool0.protocol.control_box import SetSpeedSlider
from tool0.protocol.control_box_state import ControlBoxState
from tool0.recording.entries import RecordedRequest
from tool0.recording.reading import RecordingFile, open_recording
from tool0.recording.repetition import Repetition
from tool0.simulation.handlers.reproduction import restarted
from tool0.simulation.handlers.table import answer

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from tool0.simulation.simulation import Simulation

    Array = NDArray[np.float64]

ENGINE: Final = "mujoco"
LONGEST_LAG: Final = 0.5
"""Largest lag of the recorded robot that is tried [s]."""
_LAG_STEP: Final = 0.002
"""Step size of the search for the lag of the recorded robot [s]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class JointDifference:
    """Difference between recording and simulation of one joint, without the lag."""

    position_rms: float
    """Root mean square of the position difference [rad | m]."""
    position_most: float
    """Largest position difference [rad | m]."""
    effort_rms: float
    """Root mean square of the effort difference [N·m | N]."""
    recorded_effort: float
    """Root mean square of the recorded effort, for comparison [N·m | N]."""


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedRun:
    """States of the simulated robot at the times of the recording's snapshots."""

    position: Array
    """Simulated positions [rad | m], shape (n, n_joints)."""
    effort: Array
    """Simulated efforts [N·m | N], shape (n, n_joints)."""
    lag: float
    """Lag of the recorded arms behind the simulated arms at which the position
    differences are smallest [s]."""
    joints: Mapping[str, JointDifference]
    """Differences by driven joint, in the order of the recording."""
    notes: tuple[str, ...]
    """Descriptions of the requests that were not repeated."""


def simulate_beside(
    recording: RecordingFile | Path | str,
    when_done: Callable[[int, int], None] = lambda done, total: None,
) -> SimulatedRun:
    """Simulate the requests of a recording, and compare the motions.

    Args:
        recording: One file, which is simulated from its first frame to its last.
        when_done: Callback that is called after each frame with the number of simulated
            frames and the total number of frames.

    Raises:
        RecordingError: If the file is not a recording, or contains no frame.
        Tool0Error: If the robot cannot be brought up, or its simulation fails.
    """
    if not isinstance(recording, RecordingFile):
        recording = open_recording(recording)
    if not len(recording):
        raise RecordingError(f"{recording.path} has no snapshot to compare")
    start = msgspec.structs.replace(recording.bringup, engine=ENGINE, engine_options={})
    with tempfile.TemporaryDirectory(prefix="tool0-beside-") as folder:
        meshes = recording.robot.mesh_files
        simulation = restarted(start, Path(folder), meshes)
        try:
            run = _Run(recording, simulation, Repetition(simulation, meshes))
            return run.run(when_done)
        finally:
            simulation.close()


@final
class _Run:
    def __init__(
        self, recording: RecordingFile, simulation: Simulation, repetition: Repetition
    ) -> None:
        self._recording = recording
        self._simulation = simulation
        self._repetition = repetition
        self._requests = sorted(recording.requests, key=lambda item: item.step)

    def run(self, when_done: Callable[[int, int], None]) -> SimulatedRun:
        recording, simulation = self._recording, self._simulation
        snapshots = recording.snapshots()
        n = len(recording)
        position = np.empty_like(recording.position)
        effort = np.empty_like(recording.effort)
        boxes: Sequence[ControlBoxState] = ()
        n_requests = 0
        for k, step in enumerate(recording.step.tolist()):
            n_requests = self._carry_out(n_requests, step)
            self._repetition.advance(step)
            if snapshots[k].control_boxes is not boxes:
                boxes = snapshots[k].control_boxes
                self._set_sliders(boxes)
            snapshot = simulation.snapshot
            position[k], effort[k] = snapshot.position, snapshot.effort
            when_done(k + 1, n)
        return _compared(recording, position, effort, tuple(self._repetition.notes))

    def _carry_out(self, first: int, step: int) -> int:
        """Execute successful requests before a step; return the next request index."""
        requests, repetition = self._requests, self._repetition
        while first < len(requests) and requests[first].step < step:
            recorded = requests[first]
            first += 1
            if recorded.error is not None:
                continue
            repetition.advance(recorded.step)
            error = repetition.repeat(_from_here(recorded))
            if error is not None:
                repetition.notes.append(
                    f"{recorded.method} at {recorded.time:.3f} s: {error}"
                )
        return first

    def _set_sliders(self, boxes: Sequence[ControlBoxState]) -> None:
        """Set the speed sliders of the simulated arms to the recorded positions."""
        present = {box.arm: box for box in self._simulation.snapshot.control_boxes}
        for box in boxes:
            mine = present.get(box.arm)
            if mine is not None and mine.speed_slider != box.speed_slider:
                request = SetSpeedSlider(arm=box.arm, fraction=box.speed_slider)
                try:
                    answer(self._simulation, request)
                except Tool0Error as error:
                    self._repetition.notes.append(f"speed slider: {error}")


def _from_here(recorded: RecordedRequest) -> RecordedRequest:
    """Return a request with a path that begins at the simulated arm's position.

    The recorded path began at the position of the real arm, which differs by a fraction
    of a milliradian.
    """
    params = recorded.params or {}
    times = params.get("times")
    if recorded.method != "execute_path" or not times or times[0] != 0.0:
        return recorded
    rest = {
        name: params[name][1:]
        for name in ("times", "positions", "velocities", "accelerations")
        if name in params
    }
    return replace(recorded, params={**params, **rest})


def _compared(
    recording: RecordingFile, position: Array, effort: Array, notes: tuple[str, ...]
) -> SimulatedRun:
    names, time = recording.joint_names, recording.time
    model = recording.description.model
    arms = find_arms(model).values()
    moving = {joint.name for arm in arms for joint in arm.joints}
    columns = [k for k, name in enumerate(names) if name in moving]
    lag = _lag(time, recording.position[:, columns], position[:, columns])
    at = time - lag
    joints = {}
    for k, name in enumerate(names):
        if model.joint_by_name[name].mimic is not None:
            continue
        q = recording.position[:, k] - np.interp(at, time, position[:, k])
        tau = recording.effort[:, k] - np.interp(at, time, effort[:, k])
        joints[name] = JointDifference(
            position_rms=_rms(q),
            position_most=float(np.abs(q).max()),
            effort_rms=_rms(tau),
            recorded_effort=_rms(recording.effort[:, k]),
        )
    return SimulatedRun(
        position=position, effort=effort, lag=lag, joints=joints, notes=notes
    )


def _lag(time: Array, recorded: Array, simulated: Array) -> float:
    """Return the lag of the recorded motion [s]; 0 if no joint moved."""
    if not recorded.size or not np.ptp(simulated, axis=0).any():
        return 0.0

    def error(lag: float) -> float:
        return sum(
            _rms(q - np.interp(time - lag, time, model)) ** 2
            for q, model in zip(recorded.T, simulated.T, strict=True)
        )

    return float(min(np.arange(0.0, LONGEST_LAG, _LAG_STEP), key=error))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
