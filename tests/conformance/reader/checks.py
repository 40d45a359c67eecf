"""What guards the contents of a file: CRC-32C, private data, envelopes and the digits of attachments."""
from __future__ import annotations

import struct
from typing import NamedTuple

from matroska import Attachment, Damaged


def _table() -> list[int]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
        table.append(value)
    return table


_TABLE = _table()


def crc32c(data: bytes) -> int:
    """The CRC-32C of RFC 3720."""
    table, crc = _TABLE, 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ table[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


class Payload(NamedTuple):
    track: int
    key: bool
    time: int
    data: bytes


def open_private(data: bytes) -> tuple[int, bytes]:
    """Track id and the codec's part of a track's private data."""
    if len(data) < 12 or data[:4] != b"KNRA":
        raise Damaged("private data is not Kinora's")
    version, zero, track, crc = struct.unpack_from("<BBHI", data, 4)
    if crc32c(data[:8] + data[12:]) != crc:
        raise Damaged("checksum of private data")
    if version != 1 or zero != 0:
        raise Damaged("version of private data")
    return track, data[12:]


MAX_PAYLOAD_BYTES = 24 << 20  # with its envelope


def open_envelope(block: bytes, track: int) -> Payload:
    """The payload of a block of a track."""
    if len(block) < 16:
        raise Damaged("a payload has no envelope")
    if len(block) > MAX_PAYLOAD_BYTES:
        raise Damaged("a payload is too large")
    version, flags, its_track, crc, time = struct.unpack_from("<BBHIq", block)
    if crc32c(block[:4] + block[8:]) != crc:
        raise Damaged(f"checksum of a payload of track {track}")
    if version != 1 or its_track != track or time < 0:
        raise Damaged(f"version, track or time of a payload of track {track}")
    return Payload(track, bool(flags & 1), time, block[16:])


def open_attachment(attachment: Attachment) -> bytes | None:
    """The contents of an attachment of Kinora's; None of anybody else's."""
    head, mark, digits = attachment.description.rpartition("crc32c:")
    if not mark or len(digits) != 8 or not all(digit in "0123456789abcdefABCDEF" for digit in digits):
        return None
    if crc32c(attachment.data) != int(digits, 16):
        raise Damaged(f"checksum of {attachment.name}")
    return attachment.data
