"""Types of request fields: bounds and units in one place."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

Name = Annotated[str, Meta(min_length=1, max_length=200)]
"""Of a controller, a joint, a link, a pose …"""
SpeedScale = Annotated[float, Meta(ge=0.01, le=1.0)]
"""Fraction of each joint's largest velocity."""
Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""w, x, y, z."""
RGBA = tuple[float, float, float, float]
Length = Annotated[float, Meta(gt=0.0, le=1000.0)]
"""[m]"""
Coordinate = Annotated[float, Meta(ge=-1000.0, le=1000.0)]
"""[m]"""
Place = tuple[Coordinate, Coordinate, Coordinate]
JointPositions = Annotated[dict[str, float], Meta(max_length=1000)]
"""Joint → position [rad | m]."""
