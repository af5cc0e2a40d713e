"""Handlers of the requests to cameras and force-torque sensors."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

from tool0.description.camera import Camera
from tool0.errors import ControlError
from tool0.protocol.sensors import (
    ListCameras,
    ReadForceTorque,
    ReadForceTorqueRate,
    ReadForceTorqueSamples,
    StartForceTorque,
    StopForceTorque,
    TakePicture,
    TareForceTorque,
    WrenchReading,
    WrenchSensorRequest,
)
from tool0.sensing.force_torque import ForceTorqueSensor
from tool0.simulation.handlers.table import handles
from tool0.simulation.loop import POLL_PERIOD
from tool0.simulation.simulation import Simulation


@handles(ListCameras)
def _list_cameras(simulation: Simulation, _: ListCameras) -> tuple[Camera, ...]:
    """Return the cameras without their source locations.

    Only messages need the source locations.
    """
    cameras = simulation.cameras.values()
    return tuple(replace(camera, location=None) for camera in cameras)


handles(TakePicture)(
    lambda sim, request: sim.cameras.render(sim.cameras[request.camera])
)


@handles(StartForceTorque)
def _start(simulation: Simulation, request: StartForceTorque) -> float:
    sensors = simulation.force_torque
    return sensors.start(sensors.link(request.link), request.rate, request.cutoff)


def _sensor(
    simulation: Simulation, request: WrenchSensorRequest[Any]
) -> ForceTorqueSensor:
    """Return the sensor for a request.

    The first request starts the sensor.
    """
    sensors = simulation.force_torque
    return sensors.sensor(sensors.link(request.link))


handles(StopForceTorque)(
    lambda sim, request: sim.force_torque.stop(sim.force_torque.link(request.link))
)
handles(ReadForceTorqueRate)(
    lambda sim, request: sim.force_torque.rate(sim.force_torque.link(request.link))
)
handles(TareForceTorque)(lambda sim, request: _sensor(sim, request).zero())
handles(ReadForceTorque)(lambda sim, request: _sensor(sim, request).latest())


@handles(ReadForceTorqueSamples)
def _samples(
    simulation: Simulation, request: ReadForceTorqueSamples
) -> tuple[WrenchReading, ...]:
    sensor, loop = _sensor(simulation, request), simulation.loop
    end = time.monotonic() + request.timeout
    while True:
        left = max(0.0, end - time.monotonic())
        found = sensor.samples(request.since, min(left, POLL_PERIOD))
        if found or left == 0.0:
            return found
        loop.check()
        if loop.is_closed:
            raise ControlError("the simulation was closed")
