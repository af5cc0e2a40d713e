"""Record a motion to a file, and read the file as arrays and events."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import tool0

with TemporaryDirectory() as folder:
    file = Path(folder, "motion.mcap")
    with tool0.bringup(realtime=False, scene="table_and_cubes", record=file) as robot:
        robot.move_joints({"elbow_joint": 1.0})[0].wait()
        robot.gripper.move(opening=0.03).wait()
        robot.run(0.1)

    recording = tool0.open_recording(file)
    print(f"{len(recording)} snapshots, complete: {recording.is_complete}")
    for event in recording.events:
        print(f"{event.time:.2f} s: {event.text}")
    elbow = recording.joint_names.index("elbow_joint")
    error = recording.desired_position[:, elbow] - recording.position[:, elbow]
    print(f"largest error of the elbow: {1000 * np.nanmax(np.abs(error)):.1f} mrad")
    cube = recording.objects["red cube"]
    print(f"the red cube moved by {1000 * np.ptp(cube[:, :3], axis=0).max():.1f} mm")
