"""Poses of the camera and of rigid layers."""
from __future__ import annotations

import math
import struct
from typing import NamedTuple

from matroska import Damaged


class Pose(NamedTuple):
    health: int
    rotation: tuple[float, ...]  # unit quaternion w x y z
    translation: tuple[float, ...]  # metres


def read_pose(payload: bytes, of_camera: bool) -> Pose:
    if len(payload) != 40:
        raise Damaged("a pose has not 40 bytes")
    version, health, left_out, zero, *numbers = struct.unpack("<4B3i3q", payload)
    if version != 1 or zero != 0 or left_out > 3 or health > (0 if of_camera else 2):
        raise Damaged("head of a pose")
    others = [number * 2.0**-30 for number in numbers[:3]]
    squares = sum(x * x for x in others)
    if squares > 0.75 + 1e-6:
        raise Damaged("rotation of a pose")
    if any(abs(x) > 10**15 for x in numbers[3:]):
        raise Damaged("translation of a pose")
    others.insert(left_out, math.sqrt(1 - squares))
    return Pose(health, tuple(others), tuple(x * 1e-6 for x in numbers[3:]))
