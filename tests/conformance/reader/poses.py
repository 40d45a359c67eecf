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

    def matrix(self) -> tuple[float, ...]:
        """The rotation, row by row."""
        w, x, y, z = self.rotation
        return (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y))


def read_pose(payload: bytes, of_camera: bool) -> Pose:
    version = payload[0] if payload else 0
    if len(payload) != {1: 40, 2: 23}.get(version):
        raise Damaged("version or size of a pose")
    if version == 1:
        health, left_out, zero, *numbers = struct.unpack_from("<3B3i3q", payload, 1)
        if zero != 0:
            raise Damaged("head of a pose")
        unit = 2.0**-30
    else:
        health, left_out = payload[1] & 3, payload[1] >> 2
        numbers = [int.from_bytes(payload[at:at + 3], "little", signed=True) for at in (2, 5, 8)]
        numbers += struct.unpack_from("<3i", payload, 11)
        unit = 2.0**-23
    if left_out > 3 or health > (0 if of_camera else 2):
        raise Damaged("head of a pose")
    others = [number * unit for number in numbers[:3]]
    squares = sum(x * x for x in others)
    if squares > 0.75 + 1e-6:
        raise Damaged("rotation of a pose")
    if any(abs(x) > 10**15 for x in numbers[3:]):
        raise Damaged("translation of a pose")
    others.insert(left_out, math.sqrt(1 - squares))
    return Pose(health, tuple(others), tuple(x * 1e-6 for x in numbers[3:]))
