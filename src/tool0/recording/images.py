"""Camera images as messages, which are rendered from the written snapshots."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, final

import numpy as np

from tool0.recording.frames import optical_frame, stamp
from tool0.recording.mcap_file import McapFile
from tool0.recording.message_types import IMAGE, message, stamp_of, typestore
from tool0.recording.png import encode_png

if TYPE_CHECKING:
    from tool0.protocol.state import Snapshot
    from tool0.sensing.cameras import Cameras

_ROUNDING: Final = 1e-6  # [s]


def image_topic(camera: str) -> str:
    """Return the name of the topic of a camera's images."""
    return f"/camera/{camera}/image/compressed"


@final
class ImageWriter:
    """Writer of color images from selected cameras to one file, at a constant rate."""

    def __init__(
        self, file: McapFile, cameras: Cameras, names: Sequence[str], period: float
    ) -> None:
        """Prepare to write one image per camera in each ``period`` [simulated s]."""
        self._file, self._cameras = file, cameras
        self._names, self._period = names, period
        self._next = -math.inf

    def write(self, snapshot: Snapshot) -> None:
        """Add the images of a snapshot if images are due."""
        if not self._names or snapshot.time < self._next:
            return
        self._next = snapshot.time + self._period - _ROUNDING
        time = stamp(snapshot.time)
        header = typestore().types["std_msgs/msg/Header"]
        for name in self._names:
            camera = self._cameras[name]
            png = encode_png(self._cameras.render(camera, snapshot).rgb)
            data = message(
                IMAGE,
                header=header(stamp=stamp_of(time), frame_id=optical_frame(name)),
                format="png",
                data=np.frombuffer(png, np.uint8),
            )
            self._file.write(image_topic(name), IMAGE, time, data, snapshot.step)
