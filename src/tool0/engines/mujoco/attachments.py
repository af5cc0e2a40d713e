"""Objects that are fixed to links for as long as somebody asks: welds of MuJoCo's.

A weld is part of the model, so that robot and scene are compiled anew when one comes
or goes, as for an object that does; the state goes on (``succession``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np

from tool0.description.transform import Vector3
from tool0.engines.mujoco.contacts import Touch
from tool0.engines.mujoco.model import MIMIC_SOLIMP, MIMIC_SOLREF
from tool0.engines.mujoco.objects import free_joint_name

TINY = 1e-12
"""Keeps an average defined where nothing pulls [N]."""


@final
@dataclass(frozen=True, slots=True)
class Attachment:
    """Where an object was on a link when it was fixed to it."""

    link: str
    body: str
    """Of MuJoCo's, that the link is part of."""
    position: tuple[float, float, float]
    """Of the object, in the body [m]."""
    quat_wxyz: tuple[float, float, float, float]


def attachment_now(model: Any, data: Any, name: str, link: str) -> Attachment:
    """Return the attachment of the object ``name`` to ``link`` as both are now."""
    mujoco.mj_kinematics(model, data)  # frames are those of the step before, else
    body = int(model.site(link).bodyid[0])
    inverse, place = _inverse(data.xpos[body], data.xquat[body])
    position, quat = np.zeros(3), np.zeros(4)
    thing = data.body(name)
    mujoco.mju_mulPose(position, quat, inverse, place, thing.xpos, thing.xquat)
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
        # Anchor, in the object; the object in the body; what a turn weighs, as a lever.
        data = np.zeros_like(weld.data)
        data[3:11] = *attachment.position, *attachment.quat_wxyz, 1.0
        weld.data = data


def attachment_touches(
    model: Any, data: Any, attachments: Mapping[str, Attachment]
) -> Iterator[tuple[tuple[str, str], Touch]]:
    """Yield what each link did to the object on it in the last step, about its origin.

    The constraint's forces act on the object by its free joint alone, whose coordinates
    are a force in the world's axes and a torque in the object's.
    """
    for name, attachment in attachments.items():
        equality = mujoco.mjtConstraint.mjCNSTR_EQUALITY
        rows = data.efc_type == equality
        rows &= data.efc_id == model.equality(_weld_name(name)).id
        effort = np.zeros(model.nv)
        mujoco.mj_mulJacTVec(model, data, effort, np.where(rows, data.efc_force, 0.0))
        start = int(model.joint(free_joint_name(name)).dofadr[0])
        force, torque = effort[start : start + 3], effort[start + 3 : start + 6]
        thing = data.body(name)
        point = _three(thing.xpos)
        hold = max(float(np.linalg.norm(force)), TINY)
        turned = thing.xmat.reshape(3, 3) @ torque
        yield (attachment.link, name), (point, hold, _three(force), _three(turned))


def _weld_name(name: str) -> str:
    """Return what the weld of the object ``name`` is called: as no joint of a robot's.

    A slash is in no object's name.
    """
    return f"{name}/attachment"


def _inverse(position: Any, quat: Any) -> tuple[Any, Any]:
    inverse, turned = np.zeros(3), np.zeros(4)
    mujoco.mju_negPose(inverse, turned, position, quat)
    return inverse, turned


def _three(vector: Any) -> Vector3:
    x, y, z = vector.tolist()
    return x, y, z
