"""Matroska, as far as Kinora's files need it: tracks, attachments, tags of the whole file, and blocks."""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import Iterator, NamedTuple

EBML, SEGMENT, CLUSTER = 0x1A45DFA3, 0x18538067, 0x1F43B675
TRACKS, ATTACHMENTS, TAGS = 0x1654AE6B, 0x1941A469, 0x1254C367
SIMPLE_BLOCK, BLOCK_GROUP, BLOCK = 0xA3, 0xA0, 0xA1
KINORA = "S_KINORA/"


class Damaged(Exception):
    """The file is not as the page says."""


class Cut(Damaged):
    """The file ends within an element."""


class Element(NamedTuple):
    identifier: int
    body: bytes


@dataclass
class Track:
    number: int = 0
    codec: str = ""
    private: bytes = b""
    stripped: bytes = b""  # what header stripping took from the beginning of each block
    readable: bool = True  # no other encoding


@dataclass
class Attachment:
    name: str = ""
    description: str = ""
    data: bytes = b""


@dataclass
class File:
    tracks: dict[int, Track] = field(default_factory=dict)
    attachments: list[Attachment] = field(default_factory=list)
    tags: dict[str, str] = field(default_factory=dict)
    blocks: list[tuple[Track, bytes]] = field(default_factory=list)  # of Kinora's tracks, in the order of the file
    cut: bool = False


def _number(data: bytes, at: int, longest: int) -> tuple[int, int]:
    """The variable-length number at a place with its marker, and its length."""
    if at >= len(data):
        raise Cut(f"the file ends at {at}, within an element")
    length = 9 - data[at].bit_length()
    if length > longest:
        raise Damaged(f"no element at {at}")
    if at + length > len(data):
        raise Cut(f"the file ends within the element at {at}")
    return int.from_bytes(data[at:at + length], "big"), length


def _size(data: bytes, at: int) -> tuple[int | None, int]:
    """A size without its marker, None where it is unknown, and its length."""
    number, length = _number(data, at, 8)
    size = number & ((1 << 7 * length) - 1)
    return (None if size == (1 << 7 * length) - 1 else size), length


def _head(data: bytes, at: int) -> tuple[int, int, int | None]:
    """Identifier, beginning of the body and end (None: unknown) of the element at a place."""
    identifier, length = _number(data, at, 4)
    size, more = _size(data, at + length)
    start = at + length + more
    return identifier, start, None if size is None else start + size


def _children(data: bytes) -> Iterator[Element]:
    at = 0
    while at < len(data):
        identifier, start, end = _head(data, at)
        if end is None or end > len(data):
            raise Damaged(f"element {identifier:X} does not fit what holds it")
        yield Element(identifier, data[start:end])
        at = end


def _integer(body: bytes) -> int:
    return int.from_bytes(body, "big")


def _text(body: bytes) -> str:
    try:
        return body.split(b"\0")[0].decode("utf-8")
    except UnicodeDecodeError as error:
        raise Damaged("text is not UTF-8") from error


def _check_header(body: bytes) -> None:
    values = {child.identifier: child.body for child in _children(body)}
    if _text(values.get(0x4282, b"")) != "matroska" or _integer(values.get(0x4285, b"\1")) > 2:
        raise Damaged("not a Matroska file of read version 1 or 2")
    if _integer(values.get(0x42F2, b"\4")) > 4 or _integer(values.get(0x42F3, b"\x08")) > 8:
        raise Damaged("identifiers or sizes are too long")


def _flat(data: bytes, file: File) -> Iterator[Element]:
    """What stands in the segment and in its clusters. Both may be of unknown size."""
    identifier, start, end = _head(data, 0)
    if identifier != EBML or end is None or end > len(data):
        raise Damaged("not a Matroska file")
    _check_header(data[start:end])
    at, segment_end, cluster_end = end, None, None
    inside = False
    while at < len(data) and at != segment_end:
        cluster_end = None if at == cluster_end else cluster_end
        identifier, start, end = _head(data, at)
        if identifier in (SEGMENT, CLUSTER):
            if identifier == SEGMENT and inside:
                return
            inside = True
            if identifier == SEGMENT:
                segment_end = end
            cluster_end = end if identifier == CLUSTER else None
            at = start
            continue
        if end is None or (cluster_end is not None and end > cluster_end) or (segment_end is not None and end > segment_end):
            raise Damaged(f"the element at {at} does not fit what holds it")
        if end > len(data):
            raise Cut(f"the file ends within the element at {at}")
        if inside:
            yield Element(identifier, data[start:end])
        at = end
    if segment_end is not None and segment_end > len(data):
        raise Cut("the file ends before its segment")


def _read_encodings(body: bytes, track: Track) -> None:
    encodings = list(_children(body))
    if len(encodings) > 1:
        track.readable = False
        return
    for encoding in encodings:
        values = {child.identifier: child.body for child in _children(encoding.body)}
        scope = _integer(values.get(0x5032, b"\1"))
        compression = {child.identifier: child.body for child in _children(values.get(0x5034, b""))}
        stripping = 0x5034 in values and _integer(compression.get(0x4254, b"\0")) == 3
        if scope != 1 or _integer(values.get(0x5033, b"\0")) != 0 or not stripping:
            track.readable = False
            return
        track.stripped = compression.get(0x4255, b"")


def _read_tracks(body: bytes, file: File) -> None:
    for entry in _children(body):
        if entry.identifier != 0xAE:
            continue
        track = Track()
        for child in _children(entry.body):
            if child.identifier == 0xD7:
                track.number = _integer(child.body)
            elif child.identifier == 0x86:
                track.codec = _text(child.body)
            elif child.identifier == 0x63A2:
                track.private = child.body
            elif child.identifier == 0x6D80:
                _read_encodings(child.body, track)
        file.tracks[track.number] = track


def _read_attachments(body: bytes, file: File) -> None:
    for entry in _children(body):
        if entry.identifier == 0x61A7:
            values = {child.identifier: child.body for child in _children(entry.body)}
            file.attachments.append(
                Attachment(_text(values.get(0x466E, b"")), _text(values.get(0x467E, b"")), values.get(0x465C, b"")))


def _read_tags(body: bytes, file: File) -> None:
    for tag in _children(body):
        if tag.identifier != 0x7373:
            continue
        children = list(_children(tag.body))
        # 63C5, 63C9, 63C4 and 63C6 name a track, an edition, a chapter and an attachment.
        targets = [target.identifier for child in children if child.identifier == 0x63C0
                   for target in _children(child.body) if _integer(target.body) != 0]
        if set(targets) & {0x63C5, 0x63C9, 0x63C4, 0x63C6}:
            continue
        for child in children:
            if child.identifier == 0x67C8:
                values = {part.identifier: part.body for part in _children(child.body)}
                file.tags[_text(values.get(0x45A3, b""))] = _text(values.get(0x4487, b""))


def _read_block(body: bytes, file: File) -> None:
    number, length = _size(body, 0)
    track = file.tracks.get(-1 if number is None else number)
    if track is None or not track.codec.startswith(KINORA):
        return
    if len(body) < length + 3:
        raise Damaged("a block is too short")
    if not track.readable or body[length + 2] & 0x06:
        raise Damaged("lacing, or an encoding other than header stripping")
    file.blocks.append((track, track.stripped + body[length + 3:]))


def read(data: bytes, may_be_cut: bool = False) -> File:
    """All that is whole of a file. A cut file is refused unless it may be cut."""
    file = File()
    blocks: list[bytes] = []
    readers = {TRACKS: _read_tracks, ATTACHMENTS: _read_attachments, TAGS: _read_tags}
    try:
        for identifier, body in _flat(data, file):
            if identifier in readers:
                readers[identifier](body, file)
            elif identifier == SIMPLE_BLOCK:
                blocks.append(body)
            elif identifier == BLOCK_GROUP:
                blocks += [child.body for child in _children(body) if child.identifier == BLOCK]
    except Cut:
        file.cut = True
        if not may_be_cut:
            raise
    for block in blocks:
        _read_block(block, file)
    return file
