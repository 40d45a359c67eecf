"""Occupancy and hash grid of a field: which cells are occupied and which entries are touched."""
from __future__ import annotations

import itertools

import numpy as np

from arithmetic import Decoder, new_model
from matroska import Damaged

CONTEXT = ((-1, 0, 0), (-2, 0, 0), (0, -1, 0), (1, -1, 0), (-1, -1, 0),
           (0, 0, -1), (1, 0, -1), (0, 1, -1), (-1, 0, -1), (0, -1, -1))


def unpack_occupancy(packed: bytes, side: int) -> np.ndarray:
    """Cells by z, y and x of the bytes of versions 3 and 4."""
    bits = np.unpackbits(np.frombuffer(packed, np.uint8), bitorder="little")
    return bits.reshape(side, side, side).astype(bool)


def read_occupancy(data: bytes, side: int) -> np.ndarray:
    """Cells by z, y and x of the arithmetic code of version 5."""
    decoder = Decoder(data)
    block_models = [new_model() for _ in range(8)]
    cell_models = [new_model() for _ in range(1024)]
    row, layer = side + 3, (side + 3) * (side + 3)  # cells stand 2 from the edges, so that each has all before it
    cells = bytearray(layer * (side + 3))
    steps = [(dx + row * dy + layer * dz, 1 << i) for i, (dx, dy, dz) in enumerate(CONTEXT)]
    blocks = side // 8
    occupied: set[tuple[int, int, int]] = set()
    for z, y, x in itertools.product(range(blocks), repeat=3):
        context = (((x - 1, y, z) in occupied) + 2 * ((x, y - 1, z) in occupied) + 4 * ((x, y, z - 1) in occupied))
        if not decoder.bit(block_models[context]):
            continue
        occupied.add((x, y, z))
        any_cell = 0
        for k, j in itertools.product(range(8), repeat=2):
            start = (8 * z + k + 2) * layer + (8 * y + j + 2) * row + 8 * x + 2
            for at in range(start, start + 8):
                which = 0
                for step, bit in steps:
                    if cells[at + step]:
                        which |= bit
                cells[at] = decoder.bit(cell_models[which])
                any_cell |= cells[at]
        if not any_cell:
            raise Damaged("a block of the occupancy has no occupied cell")
    decoder.end()
    padded = np.frombuffer(cells, np.uint8).reshape(side + 3, side + 3, side + 3)
    return padded[2:-1, 2:-1, 2:-1].astype(bool)


def entries_of_level(resolution: int, log2_entries: int) -> int:
    return min((resolution + 1) ** 3, 1 << log2_entries)


def touched_entries(occupancy: np.ndarray, resolution: int, log2_entries: int) -> np.ndarray:
    """Numbers of the touched entries of a level, increasing."""
    side, n = occupancy.shape[0], resolution
    entries = entries_of_level(n, log2_entries)
    cells = np.argwhere(occupancy)[:, ::-1]  # x, y, z
    if len(cells) > (1 << 26) // (n // side + 3) ** 3:
        return np.arange(entries)
    first = cells * n // side
    last = np.minimum((cells + 1) * n // side + 1, n)
    widest = int((last - first).max(initial=-1)) + 1
    marked = np.zeros(entries, bool)
    for step in itertools.product(range(widest), repeat=3):
        vertices = first + step
        x, y, z = vertices[(vertices <= last).all(axis=1)].T.astype(np.uint64)
        if (n + 1) ** 3 <= 1 << log2_entries:
            index = (z * np.uint64(n + 1) + y) * np.uint64(n + 1) + x
        else:
            index = (x ^ y * np.uint64(2654435761) ^ z * np.uint64(805459861)) & np.uint64(entries - 1)
        marked[index.astype(np.int64)] = True
    return np.flatnonzero(marked)
