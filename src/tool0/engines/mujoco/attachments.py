"""Objects that are attached to links, by MuJoCo's weld constraints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from tool0.description.transform import Vector3
from tool0.engines.mujoco.contacts import ContactPoint
from tool0.engines.mujoco.model import MIMIC_SOLIMP, MIMIC_SOLREF
from tool0.engines.mujoco.objects import free_joint_name

MIN_WEIGHT = 1e-12
"""Keeps the mean point defined if the force is zero [N]."""


@final
@dataclass(frozen=True, slots=True)
class Attachment:
    """The pose that an object keeps on a link."""

    link: str
    body: str
    """MuJoCo's body that the link is part of."""
    position: tuple[float, float, float]
    """Of the object, in the body [m]."""
    quat_wxyz: tuple[float, float, float, float]


def attachment_now(model: Any, data: Any, name: str, link: str) -> Attachment:
    """Return the attachment of object ``name`` to ``link`` at its current pose."""
    mujoco.mj_kinematics(model, data)  # the frames are those before the last step
    body = int(model.site(link).bodyid[0])
    item = data.body(name)
    inverse, inverse_quat = np.zeros(3), np.zeros(4)
    mujoco.mju_negPose(inverse, inverse_quat, data.xpos[body], data.xquat[body])
    position, quat = np.zeros(3), np.zeros(4)
    mujoco.mju_mulPose(position, quat, inverse, inverse_quat, item.xpos, item.xquat)
    x, y, z = position.tolist()
    qw, qx, qy, qz = quat.tolist()
    return Attachment(link, model.body(body).name, (x, y, z), (qw, qx, qy, qz))


def add_attachments(spec: Any, attachments: Mapping[str, Attachment]) -> None:
    """Add a weld for each attached object, by name, as stiff as mimic joints are."""
    for name, attachment in attachments.items():
        weld = spec.add_equality(
            name=_weld_name(name),
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=attachment.body,
            name2=name,
            solref=MIMIC_SOLREF,
            solimp=MIMIC_SOLIMP,
        )
        # Anchor in the object; pose of the object in the body; weight of rotation [m].
        data = np.zeros_like(weld.data)
        data[3:11] = *attachment.position, *attachment.quat_wxyz, 1.0
        weld.data = data


def attachment_points(
    model: Any, data: Any, attachments: Mapping[str, Attachment]
) -> Iterator[tuple[tuple[str, str], ContactPoint]]:
    """Yield what each link exerted on its object in the last step, at its origin.

    The weld acts on the object's free joint only, whose coordinates are a force in the
    world's axes and a torque in the object's.
    """
    for name, attachment in attachments.items():
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        rows &= data.efc_id == model.equality(_weld_name(name)).id
        effort = np.zeros(model.nv)
        mujoco.mj_mulJacTVec(model, data, effort, np.where(rows, data.efc_force, 0.0))
        start = int(model.joint(free_joint_name(name)).dofadr[0])
        force, torque = effort[start : start + 3], effort[start + 3 : start + 6]
        item = data.body(name)
        weight = max(float(np.linalg.norm(force)), MIN_WEIGHT)
        torque = item.xmat.reshape(3, 3) @ torque
        yield (
            (attachment.link, name),
            (_three(item.xpos), weight, _three(force), _three(torque)),
        )


def _weld_name(name: str) -> str:
    return f"{name}/attachment"  # no object's name has a slash


def _three(vector: Any) -> Vector3:
    x, y, z = vector.tolist()
    return x, y, z
