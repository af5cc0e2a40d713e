"""``robot.record()``: desired and measured motion, and tool poses, as arrays."""

from __future__ import annotations

import contextlib
import math
import threading
from array import array
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

from tool0.errors import ControlError, Tool0Error
from tool0.protocol.channel import Channel
from tool0.protocol.state import (
    MAX_SNAPSHOT_RATE,
    MIN_SNAPSHOT_RATE,
    JointSetpoint,
    Snapshot,
    ticks_between_snapshots,
)

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd

    from tool0.description.tool_poses import ToolPoses

    Array = npt.NDArray[np.float64]

QUANTITIES: Final = (
    "position",
    "velocity",
    "effort",
    "desired_position",
    "desired_velocity",
)
"""Quantities that are recorded for each joint, in the order of the columns."""

_INTERVAL: Final = 0.1
"""Interval between conversions of received snapshots to compact form [wall s]."""
_LAST_WAIT: Final = 1.0
"""Longest wait for the last samples from another process [wall s]."""
_NO_SETPOINT: Final = JointSetpoint(float("nan"), float("nan"), float("nan"))


@final
class Recording(AbstractContextManager["Recording"]):
    """Recording of joint states and setpoints at a constant rate, until ``stop``.

    The end of a ``with`` block stops the recording.  The arrays can also be read during
    the recording; they then contain the samples that have been recorded so far.  The
    samples are evenly spaced unless the simulation was reset or samples were missed.
    No samples are recorded while time is paused.
    """

    def __init__(self, channel: Channel, rate: float, control_period: float) -> None:
        lowest, highest = MIN_SNAPSHOT_RATE, MAX_SNAPSHOT_RATE
        given: object = rate
        if not (isinstance(given, Real) and lowest <= rate <= highest):
            raise ControlError(
                f"rate {rate!s:.40} Hz is outside [{lowest:g}, {highest:g}] Hz"
            )
        self._channel = channel
        self._description = channel.description
        self._ticks = _ticks_between_samples(1.0 / rate, control_period)
        self._rate = 1.0 / (self._ticks * control_period)
        self._lock = threading.Lock()
        self._rows = array("d")
        self._missed = 0
        self._stopped = threading.Event()
        self._subscription = channel.subscribe(
            min(self._rate, MAX_SNAPSHOT_RATE), keep_all=True
        )
        start = channel.snapshot
        self._joint_names = start.joint_names
        self._last_tick = start.tick
        threading.Thread(target=self._run, name="tool0-recording", daemon=True).start()

    # ---- arrays ---------------------------------------------------------------------

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the arrays' columns."""
        return self._joint_names

    @property
    def rate(self) -> float:
        """Sampling rate in simulated time [Hz]: at least the requested rate."""
        return self._rate

    @property
    def missed(self) -> int:
        """Number of samples lost between processes; 0 within one process."""
        self._take()
        return self._missed

    @property
    def time(self) -> Array:
        """Simulated time of each sample [s], shape (n_samples,)."""
        return self._table()[:, 0]

    @property
    def position(self) -> Array:
        """Measured positions [rad | m], shape (n_samples, n_joints)."""
        return self._of("position")

    @property
    def velocity(self) -> Array:
        """Measured velocities [rad/s | m/s], shape (n_samples, n_joints)."""
        return self._of("velocity")

    @property
    def effort(self) -> Array:
        """Measured efforts [N·m | N], shape (n_samples, n_joints)."""
        return self._of("effort")

    @property
    def desired_position(self) -> Array:
        """Desired positions [rad | m], shape (n_samples, n_joints).

        A value is NaN if no controller commands the position of the joint.
        """
        return self._of("desired_position")

    @property
    def desired_velocity(self) -> Array:
        """Desired velocities [rad/s | m/s], shape (n_samples, n_joints).

        For NaN values, see ``desired_position``.
        """
        return self._of("desired_velocity")

    @property
    def tool_poses(self) -> Mapping[str, Array]:
        """Poses x, y, z [m], qw, qx, qy, qz in the root frame, (n_samples, 7), by tool.

        A tool is the flange of an arm, such as ``tool0``, or the point midway between
        the pads of a gripper, such as ``gripper.tcp``.  The poses are computed from the
        measured joint positions.
        """
        return self._tools.poses(self.position)

    def __len__(self) -> int:
        """Return the number of samples."""
        self._take()
        return len(self._rows) // self._width

    # ---- files ----------------------------------------------------------------------

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of a table.

        After ``time``, there are columns such as ``elbow_joint.position``, and the pose
        of each flange and of each gripper, such as ``tool0.x`` and ``gripper.tcp.qw``.
        """
        from tool0.description.tool_poses import POSE

        joints = self._joint_names
        return (
            "time",
            *(f"{joint}.{what}" for what in QUANTITIES for joint in joints),
            *(f"{tool}.{part}" for tool in self._tools.names for part in POSE),
        )

    def to_csv(self, path: Path | str) -> None:
        """Write a CSV file with ``columns`` and a line of SI values for each sample.

        A missing desired value is an empty field.

        Raises:
            OSError: If the file cannot be written.
        """
        with Path(path).open("w", encoding="utf-8") as file:
            file.write(",".join(self.columns) + "\n")
            file.writelines(self._lines())

    def to_pandas(self) -> pd.DataFrame:
        """Return a table with the index ``time`` [s] and the other ``columns``.

        Raises:
            ControlError: If pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise ControlError(
                "to_pandas needs pandas, which is not installed: pip install pandas"
            ) from None
        table = self._with_tools()
        index = pd.Index(table[:, 0], name="time")
        return pd.DataFrame(table[:, 1:], index=index, columns=list(self.columns[1:]))

    # ---- recording ------------------------------------------------------------------

    def stop(self) -> None:
        """Stop recording; further calls have no effect.

        The arrays then contain all samples up to this call, even if the robot runs in
        another process.
        """
        if self._stopped.is_set():
            return
        with contextlib.suppress(Tool0Error):  # no samples from a closed robot
            newest = self._channel.snapshot.tick
            last = newest - newest % self._ticks
            if not self._channel.wait_until(lambda: self._reached(last), _LAST_WAIT):
                self._missed += (last - self._last_tick) // self._ticks
        self._stopped.set()
        with contextlib.suppress(Tool0Error):
            self._subscription.close()

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _run(self) -> None:
        while not self._stopped.wait(_INTERVAL):
            self._take()

    def _reached(self, tick: int) -> bool:
        self._take()
        return self._last_tick >= tick

    def _take(self) -> None:
        """Store the received snapshots in a few hundred bytes each."""
        with self._lock:
            for snapshot in self._subscription.pending():
                if (
                    snapshot.tick % self._ticks == 0
                    and snapshot.tick != self._last_tick
                ):
                    self._append(snapshot)

    def _append(self, snapshot: Snapshot) -> None:
        gap = snapshot.tick // self._ticks - self._last_tick // self._ticks
        self._missed += max(0, gap - 1)  # the gap is negative after a reset
        self._last_tick = snapshot.tick
        setpoints = snapshot.setpoints()
        desired = [setpoints.get(name, _NO_SETPOINT) for name in self._joint_names]
        self._rows.append(snapshot.time)
        self._rows.extend(snapshot.position)
        self._rows.extend(snapshot.velocity)
        self._rows.extend(snapshot.effort)
        self._rows.extend(item.position for item in desired)
        self._rows.extend(item.velocity for item in desired)

    # ---- the table ------------------------------------------------------------------

    @property
    def _width(self) -> int:
        return 1 + len(QUANTITIES) * len(self._joint_names)

    def _table(self) -> Array:
        """Return a copy of the recorded samples: the time, then ``QUANTITIES``."""
        import numpy as np

        self._take()
        with self._lock:
            values = np.array(self._rows, dtype=np.float64)
        return values.reshape(-1, self._width)

    @cached_property
    def _tools(self) -> ToolPoses:
        from tool0.description.tool_poses import ToolPoses

        return ToolPoses(self._description.model, self._joint_names)

    def _with_tools(self) -> Array:
        """Return the samples so far with ``columns``, shape (n_samples, n_columns)."""
        import numpy as np

        table = self._table()
        positions = table[:, 1 : 1 + len(self._joint_names)]
        return np.hstack([table, *self._tools.poses(positions).values()])

    def _of(self, quantity: str) -> Array:
        n_joints = len(self._joint_names)
        start = 1 + QUANTITIES.index(quantity) * n_joints
        return self._table()[:, start : start + n_joints]

    def _lines(self) -> Iterator[str]:
        for row in self._with_tools().tolist():
            yield ",".join("" if math.isnan(x) else repr(x) for x in row) + "\n"


def _ticks_between_samples(period: float, control_period: float) -> int:
    """Return the number of control periods per sample, which fit into ``period`` [s].

    Up to the default rate of snapshots, every n-th snapshot is a sample.  Above the
    default rate, every snapshot is a sample.
    """
    ticks = ticks_between_snapshots(period, control_period)
    return ticks * max(1, int(period / (ticks * control_period) + 1e-9))
