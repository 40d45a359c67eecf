"""Zstandard frames that state their decompressed size."""
from __future__ import annotations

import zstandard

from matroska import Damaged


def decompress(data: bytes, largest: int, size: int | None = None) -> bytes:
    """The contents of the one frame that the data is: of the given size, or of one that is not too large."""
    try:
        stated = zstandard.frame_content_size(data)
        if stated < 0 or stated > largest or (size is not None and stated != size):
            raise Damaged("a Zstandard frame states another size, none, or too large a one")
        decompressor = zstandard.ZstdDecompressor().decompressobj()
        contents = decompressor.decompress(data)
        if not decompressor.eof or decompressor.unused_data or len(contents) != stated:
            raise Damaged("a part is not one Zstandard frame")
    except zstandard.ZstdError as error:
        raise Damaged(f"Zstandard: {error}") from error
    return contents
