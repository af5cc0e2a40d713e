"""Rejection or replacement of physically impossible inertias in your own robot file."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from xml.dom.minidom import Document, Element

from tool0.description.model import Inertial
from tool0.description.urdf_elements import read_inertial
from tool0.description.xml_source import children, locate, number, only_child
from tool0.errors import ModelError

logger = logging.getLogger(__name__)

_DIAGONAL = ("ixx", "iyy", "izz")
_PRODUCTS = ("ixy", "ixz", "iyz")


def require_inertias(document: Document, *, relax: bool) -> None:
    """Reject impossible inertias, or replace them with a warning if ``relax`` is set.

    The replacement has the same moment about every axis: the middle principal moment.

    Raises:
        ModelError: If a link has an impossible inertia and ``relax`` is not set, or if
            the inertia has no positive principal moment.  The error states the first
            link with an impossible inertia.
    """
    for link, tensor, error in _impossible(document):
        if not relax:
            raise ModelError(
                f"{error.message}; --relax-inertia (in Python: relax_inertia=True in "
                "DescriptionConfig) replaces such an inertia",
                error.location,
            )
        moment = _middle_moment(tensor)
        if not moment > 0:
            raise error
        for key in _DIAGONAL:
            tensor.setAttribute(key, repr(moment))
        for key in _PRODUCTS:
            tensor.setAttribute(key, "0")
        logger.warning(
            "%s: the inertia of link '%s', which no body has, is replaced by "
            "%.3g kg·m² about every axis",
            error.location,
            link.getAttribute("name"),
            moment,
        )


def _impossible(
    document: Document,
) -> Iterator[tuple[Element, Element, ModelError]]:
    """Yield each link with an impossible inertia, its ``<inertia>``, and the error."""
    robot = document.documentElement
    for link in () if robot is None else children(robot, "link"):
        inertial = only_child(link, "inertial")
        tensor = None if inertial is None else only_child(inertial, "inertia")
        try:
            read_inertial(link, link.getAttribute("name"))
        except ModelError as error:
            if tensor is not None and error.location == locate(tensor):
                yield link, tensor, error


def _middle_moment(tensor: Element) -> float:
    """Return the middle principal moment of inertia [kg·m²].

    If the middle moment is not above zero, the largest moment is returned.
    """
    ixx, iyy, izz, ixy, ixz, iyz = (
        number(tensor, key, 0.0) for key in (*_DIAGONAL, *_PRODUCTS)
    )
    _, middle, high = Inertial(
        mass=1.0, ixx=ixx, iyy=iyy, izz=izz, ixy=ixy, ixz=ixz, iyz=iyz
    ).principal_moments
    return middle if middle > 0 else high
