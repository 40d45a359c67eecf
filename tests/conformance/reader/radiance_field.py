"""The radiance field of a layer: versions 3, 4 and 5, and 7 with its further levels in payloads of version 8."""
from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field

import numpy as np

from arithmetic import Decoder, IntegerModels, size_class
from budget import Budget
from grid import entries_of_level, read_occupancy, touched_entries, unpack_occupancy
from matroska import Damaged
from zstandard_frame import decompress

FEATURES = 8


@dataclass
class Field:
    version: int
    signed_distances: bool
    sharpness: float
    log2_entries: int
    corner: tuple[float, ...]
    side: float
    resolutions: list[int]
    exponents: list[int]
    occupancy: np.ndarray = field(default_factory=lambda: np.zeros((0, 0, 0), bool))
    levels: list[np.ndarray | None] = field(default_factory=list)  # entries by features; None: has not come
    density_net: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))
    color_net: np.ndarray = field(default_factory=lambda: np.zeros(0, np.float32))

    def whole(self) -> bool:
        return all(level is not None for level in self.levels)

    def table(self) -> np.ndarray:
        """All entries, level by level, with zeros for those that are not touched or have not come."""
        return np.concatenate([
            np.zeros((entries_of_level(n, self.log2_entries), FEATURES), np.float32) if level is None else level
            for n, level in zip(self.resolutions, self.levels)])


def matrices(levels: int) -> list[int]:
    """Numbers of weights of the five matrices, those of the density network first."""
    return [FEATURES * levels * 16, 16 * 16, 16 * 32, 32 * 32, 32 * 16]


def scaled(numbers: np.ndarray, exponent: int) -> np.ndarray:
    return np.ldexp(numbers.astype(np.float64), exponent).astype("<f4")


def read_level(data: bytes, touched: np.ndarray, entries: int, exponent: int) -> np.ndarray:
    """The entries of a level of version 5."""
    decoder = Decoder(data)
    models = [[[IntegerModels() for _ in range(4)] for _ in range(6)] for _ in range(FEATURES)]
    values = np.zeros((entries, FEATURES), np.int32)
    before = [0] * FEATURES
    for entry in touched.tolist():
        now, total = [], 0
        for f in range(FEATURES):
            activity = min(5, size_class(2 * total // f)) if f else 0
            value = decoder.integer(models[f][activity][min(3, size_class(abs(before[f])))])
            if not -32768 <= value <= 32767:
                raise Damaged("a parameter has not 16 bits")
            total += abs(value)
            now.append(value)
        values[entry] = before = now
    decoder.end()
    return scaled(values, exponent)


def read_networks(data: bytes, levels: int, exponents: tuple[int, ...]) -> list[np.ndarray]:
    decoder = Decoder(data)
    read = []
    for count, exponent in zip(matrices(levels), exponents):
        models = IntegerModels()
        read.append(scaled(np.array([decoder.integer(models) for _ in range(count)], np.int64), exponent))
    decoder.end()
    if not all(np.isfinite(matrix).all() for matrix in read):
        raise Damaged("a weight is not finite")
    return read


def _set_networks(result: Field, networks: list[np.ndarray]) -> None:
    result.density_net = np.concatenate(networks[:2])
    result.color_net = np.concatenate(networks[2:])


def _read_header(payload: bytes) -> tuple[Field, int]:
    """What all versions share, and the resolution of the occupancy. The levels stand at 56 in all of them."""
    if len(payload) < 56 or payload[0] not in (3, 4, 5, 7):
        raise Damaged("version of a field")
    version, levels, log2_entries, features, coarsest, finest, side = struct.unpack_from("<4B3H", payload)
    distances = version == 4 if version < 5 else payload[48] == 1
    (sharpness,) = struct.unpack_from("<e", payload, 14)
    corner, length = struct.unpack_from("<3d", payload, 16), struct.unpack_from("<d", payload, 40)[0]
    if not 2 <= levels <= 8 or levels % 2 or not 4 <= log2_entries <= 20 or features != FEATURES:
        raise Damaged("configuration of a field")
    if not 1 <= coarsest <= finest <= 8192 or side % 64 or not 64 <= side <= 512:
        raise Damaged("resolutions of a field")
    if payload[10:14] != bytes((16, 16, 32, 16)) or (version >= 5 and payload[48] > 1):
        raise Damaged("networks or geometry of a field")
    if (not -11 <= sharpness <= 11) if distances else payload[14:16] != b"\0\0":
        raise Damaged("sharpness of a field")
    if not all(map(math.isfinite, (*corner, length))) or length <= 0:
        raise Damaged("cube of a field")
    if len(payload) < 56 + 4 * levels:
        raise Damaged("a field is too short")
    table = [struct.unpack_from("<HbB", payload, 56 + 4 * level) for level in range(levels)]
    for level, (resolution, exponent, zero) in enumerate(table):
        expected = coarsest * (finest / coarsest) ** (level / (levels - 1))
        if resolution != math.floor(expected + 0.5) or not -60 <= exponent <= 40 or zero != 0:
            raise Damaged("levels of a field")
    return Field(version, distances, sharpness if distances else 0.0, log2_entries, corner, length,
                 [row[0] for row in table], [row[1] for row in table], levels=[None] * levels), side


def _read_versions_3_and_4(result: Field, side: int, payload: bytes) -> None:
    count = len(result.levels)
    occupancy_size, parameters_size = struct.unpack_from("<II", payload, 48)
    start = 56 + 4 * count
    if len(payload) != start + occupancy_size + parameters_size:
        raise Damaged("sizes of a field's parts")
    occupancy = decompress(payload[start:start + occupancy_size], side**3 // 8, side**3 // 8)
    result.occupancy = unpack_occupancy(occupancy, side)
    touched = [touched_entries(result.occupancy, n, result.log2_entries) for n in result.resolutions]
    total, weights = FEATURES * sum(map(len, touched)), sum(matrices(count))
    size = 2 * (total + weights)
    data = np.frombuffer(decompress(payload[start + occupancy_size:], size, size), np.uint8)
    z = data[:total].astype(np.int32) | data[total:2 * total].astype(np.int32) << 8
    numbers = np.where(z % 2 == 0, z // 2, -(z + 1) // 2)
    at = 0
    for level, (n, exponent) in enumerate(zip(result.resolutions, result.exponents)):
        entries = touched[level]
        values = np.zeros((entries_of_level(n, result.log2_entries), FEATURES), np.int32)
        values[entries] = numbers[at:at + FEATURES * len(entries)].reshape(FEATURES, len(entries)).T
        at += FEATURES * len(entries)
        result.levels[level] = scaled(values, exponent)
    networks = data[2 * total:].view("<f2").astype("<f4")
    if not np.isfinite(networks).all():
        raise Damaged("a weight is not finite")
    _set_networks(result, np.split(networks, np.cumsum(matrices(count))[:-1]))


def _read_coded_level(result: Field, level: int, data: bytes) -> None:
    n = result.resolutions[level]
    touched = touched_entries(result.occupancy, n, result.log2_entries)
    entries = entries_of_level(n, result.log2_entries)
    result.levels[level] = read_level(data, touched, entries, result.exponents[level])


def _read_versions_5_and_7(result: Field, side: int, payload: bytes) -> None:
    count = len(result.levels)
    (held,) = struct.unpack_from("<H", payload, 54)
    if not 1 <= held <= count if result.version == 7 else held != 0:
        raise Damaged("number of levels in a payload")
    held = held or count
    at = 56 + 4 * count + 4 * (count + 2)
    if len(payload) < at:
        raise Damaged("a field is too short")
    sizes = struct.unpack_from(f"<{count + 2}I", payload, 56 + 4 * count)
    if len(payload) != at + sum(sizes):
        raise Damaged("sizes of a field's parts")
    if any(sizes[2 + held:]) or any(result.exponents[held:]):
        raise Damaged("a level that is not there has a size or an exponent")
    ends = np.cumsum((at, *sizes)).tolist()
    parts = [payload[start:end] for start, end in zip(ends, ends[1:])]
    result.occupancy = read_occupancy(parts[0], side)
    _set_networks(result, read_networks(parts[1], count, struct.unpack_from("<5b", payload, 49)))
    for level in range(held):
        _read_coded_level(result, level, parts[2 + level])


def read_field(payloads: list[bytes], budget: Budget, whole_parts: bool = False) -> Field:
    """The field of a track's payloads. Levels that have not come are None; of whole parts, all behind one that is missing."""
    first = payloads[0]
    result, side = _read_header(first)
    entries = sum(entries_of_level(n, result.log2_entries) for n in result.resolutions)
    budget.take(2 * 4 * FEATURES * entries + side**3 // 4)
    (_read_versions_3_and_4 if result.version < 5 else _read_versions_5_and_7)(result, side, first)
    held = sum(level is not None for level in result.levels)
    if len(payloads) > 1 and result.version != 7:
        raise Damaged("a whole field has further payloads")
    for level, payload in enumerate(payloads[1:], held):
        if len(payload) < 4 or payload[0] != 8 or payload[3] != 0 or not level <= payload[1] < len(result.levels):
            raise Damaged("version or number of a level")
        if payload[1] > level:
            if not whole_parts:
                raise Damaged("a field lacks a level")
            break
        (exponent,) = struct.unpack_from("<b", payload, 2)
        if not -60 <= exponent <= 40:
            raise Damaged("exponent of a level")
        result.exponents[level] = exponent
        _read_coded_level(result, level, payload[4:])
    return result
