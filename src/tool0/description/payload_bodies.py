"""Payloads as bodies that correct the dynamics model used by an arm's drives.

A payload replaces the model of all bodies beyond the flange, as ``set_payload`` does on
a UR.  The drives then compensate for the weight and inertia of the payload instead of
those of the tool in the description.  The simulated physics does not change.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tool0.description.bodies import BodyInertia, total_inertia
from tool0.description.forward_kinematics import link_poses
from tool0.description.model import RobotModel
from tool0.description.payload import Payload


def modelled_payload(model: RobotModel, flange: str) -> Payload:
    """Return the description's payload beyond ``flange``, with the grippers open."""
    tool = tool_inertia(model, flange)
    x, y, z = tool.center.tolist()
    return Payload(tool.mass, (x, y, z))


def replaced_tools(
    model: RobotModel, payloads: Mapping[str, Payload]
) -> dict[str, tuple[BodyInertia, ...]]:
    """Return the bodies to add to the flanges to replace the tools with payloads."""
    return {
        flange: (payload_inertia(payload), _negative(tool_inertia(model, flange)))
        for flange, payload in payloads.items()
    }


def payload_inertia(payload: Payload) -> BodyInertia:
    """Return a payload as a body in the flange's frame."""
    center, tensor = np.array(payload.center_of_gravity), payload.inertia * np.eye(3)
    return BodyInertia(payload.mass, center, tensor)


def tool_inertia(model: RobotModel, flange: str) -> BodyInertia:
    """Return all bodies beyond ``flange`` in the description as one body."""
    poses = link_poses(model, {})
    from_root = poses[flange].inverse()
    links = [
        (link, (from_root @ poses[link]).matrix) for link in model.links_from(flange)
    ]
    return total_inertia(model, links)


def _negative(inertia: BodyInertia) -> BodyInertia:
    return BodyInertia(-inertia.mass, inertia.center, -inertia.tensor)
