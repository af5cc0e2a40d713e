"""``tool0 state | wrench | camera``: measurements of a running bringup."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tool0.cli.connection import DEFAULT, Bringup, chosen_robot
from tool0.cli.parameters import AsJson, Option
from tool0.cli.text import columns, grasp_text, print_json
from tool0.description.transform import to_pose
from tool0.errors import ConfigError
from tool0.protocol.sensors import DEFAULT_CUTOFF

if TYPE_CHECKING:
    from tool0.api.sensors import ForceTorque
    from tool0.cli.outputs import (
        CameraOutput,
        CamerasOutput,
        PictureOutput,
        StateOutput,
    )
    from tool0.description.camera import Camera
    from tool0.description.transform import Pose, Vector3
    from tool0.protocol.gripper import GraspState
    from tool0.protocol.sensors import CameraImage, WrenchReading
    from tool0.protocol.state import Snapshot


def state(
    *,
    as_json: AsJson = False,
    bringup: Bringup = DEFAULT,
) -> None:
    """Print the simulated time, joint states, gripper states and the pose of `tool0`.

    Args:
        as_json: Print one JSON object.
    """
    with bringup.connect() as robot:
        snapshot = robot.snapshot
        grippers = {name: item.state for name, item in robot.grippers.items()}
        tools = {arm.tip: to_pose(arm.pose()) for arm in robot.arms.values()}
    if as_json:
        print_json(_plain(snapshot, grippers, tools))
    else:
        print(_table(snapshot, grippers) + _poses(tools), end="")


def _plain(
    snapshot: Snapshot, grippers: Mapping[str, GraspState], tools: Mapping[str, Pose]
) -> StateOutput:
    names = snapshot.joint_names
    return {
        "time": snapshot.time,
        "is_paused": snapshot.is_paused,
        "is_stopped": snapshot.is_stopped,
        "real_time_factor": snapshot.real_time_factor,
        "overruns": snapshot.overruns,
        "late_ticks": snapshot.late_ticks,
        "fault": snapshot.fault,
        "stalls": [stall._asdict() for stall in snapshot.stalls],
        "position": dict(zip(names, snapshot.position, strict=True)),
        "velocity": dict(zip(names, snapshot.velocity, strict=True)),
        "effort": dict(zip(names, snapshot.effort, strict=True)),
        "grippers": {
            name: {**asdict(state), "gobj": state.gobj}
            for name, state in grippers.items()
        },
        "poses": {name: asdict(pose) for name, pose in tools.items()},
    }


def _poses(ends: Mapping[str, Pose]) -> str:
    """Return the poses of the arms' ends, in the notation of ``tool0 move --pose``."""
    return "".join(
        f"{name}: xyz {_numbers(pose.xyz)} m, rpy {_numbers(pose.rpy)} rad\n"
        for name, pose in ends.items()
    )


def _numbers(values: Vector3) -> str:
    return " ".join(f"{value:+.5f}" for value in values)


def _table(snapshot: Snapshot, grippers: Mapping[str, GraspState]) -> str:
    marks = [f"t = {snapshot.time:.3f} s"]
    if snapshot.real_time_factor > 0.0:  # 0 until it is measured
        marks.append(f"{snapshot.real_time_factor:.2f} x real time")
    if snapshot.is_paused:
        marks.append("paused")
    if snapshot.is_stopped:
        marks.append("emergency stop")
    if snapshot.fault is not None:
        marks.append(f"stopped by a fault: {snapshot.fault}")
    rows = [("joint", "position", "velocity", "effort")]
    rows += [
        (name, f"{position:+.5f}", f"{velocity:+.5f}", f"{effort:+.3f}")
        for name, position, velocity, effort in zip(
            snapshot.joint_names,
            snapshot.position,
            snapshot.velocity,
            snapshot.effort,
            strict=True,
        )
    ]
    lines = "".join(
        f"{name}: {grasp_text(state)}\n" for name, state in grippers.items()
    )
    lines += "".join(f"{stall}\n" for stall in snapshot.stalls)
    return f"{', '.join(marks)}\n{columns(rows)}{lines}"


def wrench(
    *,
    zero: bool = False,
    rate: float | None = None,
    cutoff: float | None = None,
    duration: float | None = None,
    raw: bool = False,
    as_json: AsJson = False,
    robot: str | None = None,
    bringup: Bringup = DEFAULT,
) -> None:
    """Print the force and torque of the tool on the link `tool0`, in the link's axes.

    The measurement includes the weight and the inertial forces of the tool, as well as
    contact forces.

    Args:
        zero: Tare the sensor before the measurement.  Changing --rate or --cutoff
            clears the tare.
        rate: Set the sampling rate [Hz], 50 to 1000.  The initial rate is 125 Hz.
        cutoff: Set the cutoff frequency of the low-pass filter [Hz].  The initial
            frequency is 15 Hz.
        duration: Print every sample for this simulated time [s].  By default, print one
            sample.
        raw: Print unfiltered values.
        as_json: Print one JSON object per line for each sample, with filtered and raw
            values.
        robot: In a cell, the robot that has the sensor.
    """
    if duration is not None and not duration >= 0.0:
        raise ConfigError(f"--duration must be 0 or more seconds, got {duration}")
    with bringup.connect() as connected:
        if robot is None and len(connected.arms) <= 1:
            sensor = connected.force_torque
        else:
            sensor = chosen_robot(connected, robot).force_torque
        if rate is not None or cutoff is not None:
            sensor.start(rate, DEFAULT_CUTOFF if cutoff is None else cutoff)
        if zero:
            sensor.zero()
        for reading in _readings(sensor, duration or 0.0):
            if as_json:
                print_json(reading)
            else:
                print(_line(reading, raw), flush=True)


def _readings(sensor: ForceTorque, duration: float) -> Iterator[WrenchReading]:
    """Yield the newest sample, then all following samples."""
    newest = sensor.read()
    end = newest.time + duration - 1e-6
    yield newest
    while newest.time < end:
        for reading in sensor.samples(newest.number, None):
            if reading.dropped:
                print(f"tool0: {reading.dropped} samples were lost", file=sys.stderr)
            if newest.time < end:
                newest = reading
                yield newest


def _line(reading: WrenchReading, raw: bool) -> str:
    force = reading.raw_force if raw else reading.force
    torque = reading.raw_torque if raw else reading.torque
    return (
        f"t = {reading.time:.3f} s  force {_aligned(force, 2)} N"
        f"  torque {_aligned(torque, 4)} N·m  {reading.frame}"
    )


def _aligned(values: Vector3, digits: int) -> str:
    rounded = (round(value, digits) + 0.0 for value in values)  # avoids -0.00
    return " ".join(f"{value:+{digits + 5}.{digits}f}" for value in rounded)


def camera(
    name: Annotated[str | None, Option(is_positional=True, metavar="CAMERA")] = None,
    *,
    out: Path | None = None,
    depth: Path | None = None,
    as_list: Annotated[bool, Option(name="list")] = False,
    as_json: AsJson = False,
    robot: str | None = None,
    bringup: Bringup = DEFAULT,
) -> None:
    """Take a picture with a camera, or list the cameras.

    Args:
        name: The camera, such as wrist or scene.
        out: Write the color image to this PNG file.
        depth: Write the depth image to this file: a 16-bit PNG [mm], or a .npy array
            [m].  Pixels without an object are 0 in a PNG, and inf in an array.
        as_list: List the cameras.
        as_json: Print one JSON object: the cameras, or the files and the image size.
        robot: In a cell, the robot that has the camera: `--robot left wrist` selects
            left_wrist.
    """
    if as_list == (name is not None):
        raise ConfigError("give the name of a camera, or --list")
    if name is not None and out is None and depth is None:
        raise ConfigError("give a file for the picture: --out FILE.png or --depth FILE")
    for path, suffixes in ((out, (".png",)), (depth, (".png", ".npy"))):
        if path is not None and path.suffix.lower() not in suffixes:
            raise ConfigError(f"{path}: the name must end in {' or '.join(suffixes)}")
    with bringup.connect() as connected:
        if name is None:
            cameras = [handle.camera for handle in connected.cameras.values()]
            if as_json:
                listed: CamerasOutput = {"cameras": list(map(_plain_camera, cameras))}
                print_json(listed)
            else:
                print(_camera_table(cameras), end="")
            return
        if robot is not None:
            name = f"{chosen_robot(connected, robot).name}_{name}"
        image = connected.camera(name).image()
    _write(image, out, depth)
    height, width = image.depth.shape
    files = [str(path) for path in (out, depth) if path is not None]
    if as_json:
        found: PictureOutput = {
            "files": files,
            "width": width,
            "height": height,
            "time": image.time,
        }
        print_json(found)
    else:
        at = f"at t = {image.time:.3f} s"
        print(f"{', '.join(files)}: {width} x {height}, {at}")


def _plain_camera(item: Camera) -> CameraOutput:
    return {
        "name": item.name,
        "link": item.link,
        "width": item.width,
        "height": item.height,
        "field_of_view": item.field_of_view,
        "near": item.near,
        "far": item.far,
    }


def _camera_table(cameras: Sequence[Camera]) -> str:
    rows = [("camera", "link", "pixels", "field of view", "sees")]
    rows += [
        (
            item.name,
            item.link or "(none)",
            f"{item.width} x {item.height}",
            f"{math.degrees(item.field_of_view):.0f}°",
            f"{item.near:g} … {item.far:g} m",
        )
        for item in cameras
    ]
    return columns(rows)


def _write(image: CameraImage, out: Path | None, depth: Path | None) -> None:
    import numpy as np

    from tool0.recording.png import encode_depth, encode_png

    try:
        if out is not None:
            out.write_bytes(encode_png(image.rgb))
        if depth is not None and depth.suffix.lower() == ".npy":
            with depth.open("wb") as file:
                np.save(file, image.depth)
        elif depth is not None:
            depth.write_bytes(encode_depth(image.depth))
    except OSError as error:
        raise ConfigError(f"cannot write {error.filename}: {error.strerror}") from None
