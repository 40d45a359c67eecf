"""How much memory a file may ask for: the page's section "Hostile files"."""
from __future__ import annotations

from matroska import Damaged

MEBIBYTE = 1 << 20


class Budget:
    """Counts what the numbers of a file ask for."""

    def __init__(self, file_bytes: int) -> None:
        self.taken = 0
        self._most = 64 * file_bytes + 256 * MEBIBYTE

    def take(self, count: int) -> None:
        """Refuses before anything is allocated."""
        self.taken += count
        if self.taken > self._most:
            raise Damaged("a file of this size cannot need so much memory")
