"""Joints of a person."""
from __future__ import annotations

import re
from typing import NamedTuple

from arithmetic import Decoder, IntegerModels
from budget import Budget
from matroska import Damaged

LIMIT = 1 << 23
Place = tuple[int, ...]


class Joints(NamedTuple):
    names: list[str]
    frames: list[list[Place]]  # in units of 2⁻⁹ m


def read_joints(payload: bytes, frames: int, budget: Budget) -> Joints:
    if len(payload) < 2 or payload[0] != 1 or not 1 <= payload[1] <= 64:
        raise Damaged("version or number of joints")
    names, at = [], 2
    for _ in range(payload[1]):
        if at >= len(payload):
            raise Damaged("names of joints")
        name = payload[at + 1:at + 1 + payload[at]]
        if len(name) != payload[at] or not re.fullmatch(rb"[a-z0-9_]{1,32}", name):
            raise Damaged("name of a joint")
        names.append(name.decode())
        at += 1 + len(name)
    budget.take(24 * frames * (len(names) + 1))
    decoder = Decoder(payload[at:])
    models = [IntegerModels() for _ in range(3)]
    read: list[list[Place]] = []
    for frame in range(frames):
        places: list[Place] = []
        for joint in range(len(names)):
            if frame == 0:
                expected = places[-1] if joint else (0, 0, 0)
            else:
                before = read[-1]
                moved = [a - b for a, b in zip(places[-1], before[joint - 1])] if joint else (0, 0, 0)
                expected = tuple(max(-LIMIT, min(LIMIT, a + b)) for a, b in zip(before[joint], moved))
            place = tuple(e + decoder.integer(m) for e, m in zip(expected, models))
            if any(abs(x) > LIMIT for x in place):
                raise Damaged("a joint is too far away")
            places.append(place)
        read.append(places)
    decoder.end()
    return Joints(names, read)
