"""How well a layer was seen: levels of the blocks of its field's occupancy."""
from __future__ import annotations

import numpy as np

from arithmetic import Decoder, IntegerModels
from budget import Budget
from matroska import Damaged

NORMALS = 26


def read_confidence(payload: bytes, occupancy: np.ndarray, budget: Budget) -> dict[tuple[int, int, int], list[int]]:
    """The 26 levels of each block (x, y, z) of 4³ cells that has any. The occupancy is indexed by z, y and x."""
    if len(payload) < 1 or payload[0] != 1:
        raise Damaged("version of a confidence")
    side = occupancy.shape[0] // 4
    occupied = occupancy.reshape(side, 4, side, 4, side, 4).any(axis=(1, 3, 5))
    budget.take(NORMALS * int(occupied.sum()) + 12 * ((side**3 + 63) // 64))
    decoder = Decoder(payload[1:])
    models = [IntegerModels() for _ in range(16)]
    blocks: dict[tuple[int, int, int], list[int]] = {}
    for z, y, x in np.argwhere(occupied).tolist():
        before = [blocks[place] for place in ((x - 1, y, z), (x, y - 1, z), (x, y, z - 1)) if place in blocks]
        levels = []
        for normal in range(NORMALS):
            expected = sum(block[normal] for block in before) // len(before) if before else 0
            level = expected + decoder.integer(models[expected])
            if not 0 <= level <= 15:
                raise Damaged("a level of a confidence")
            levels.append(level)
        blocks[x, y, z] = levels
    decoder.end()
    return blocks
