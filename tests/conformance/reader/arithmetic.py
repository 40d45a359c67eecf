"""The arithmetic code and its integers."""
from __future__ import annotations

from matroska import Damaged

Model = list[int]  # probability and count


def new_model() -> Model:
    return [1 << 15, 0]


class IntegerModels:
    """One kind of models: all that an integer is coded with."""

    def __init__(self) -> None:
        self.zero = new_model()
        self.negative = new_model()
        self.longer = [new_model() for _ in range(31)]
        self.highest = [new_model() for _ in range(31)]
        self.next = [(new_model(), new_model()) for _ in range(31)]


class Decoder:
    """Reads bits and integers from the bytes of one code."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 4
        self._low, self._high = 0, 0xFFFFFFFF
        self._code = int.from_bytes(data[:4].ljust(4, b"\0"), "big")

    def bit(self, model: Model) -> int:
        probability, count = model
        low, high = self._low, self._high
        split = low + ((high - low) * (probability >> 4) >> 12)
        if self._code <= split:
            bit, high = 1, split
            model[0] = probability + (65520 - probability) // (count + 2)
        else:
            bit, low = 0, split + 1
            model[0] = probability - (probability - 16) // (count + 2)
        if count < 30:
            model[1] = count + 1
        while (low ^ high) < 1 << 24:
            low = low << 8 & 0xFFFFFFFF
            high = high << 8 & 0xFFFFFFFF | 0xFF
            at = self._at
            if at >= len(self._data) + 4:
                raise Damaged("an arithmetic code ends too early")
            byte = self._data[at] if at < len(self._data) else 0
            self._code = self._code << 8 & 0xFFFFFFFF | byte
            self._at = at + 1
        self._low, self._high = low, high
        return bit

    def integer(self, models: IntegerModels) -> int:
        if self.bit(models.zero):
            return 0
        negative = self.bit(models.negative)
        k = 0
        while k < 30 and self.bit(models.longer[k]):
            k += 1
        size = 1
        for i in range(k):
            if i == 0:
                model = models.highest[k]
            elif i == 1:
                model = models.next[k][size & 1]
            else:
                model = new_model()
            size = size << 1 | self.bit(model)
        return -size if negative else size

    def end(self) -> None:
        """Refuses bytes that are left."""
        if self._at < len(self._data):
            raise Damaged("bytes are left behind an arithmetic code")


def size_class(number: int) -> int:
    """0 for 0, else 1 + the logarithm to base 2, rounded down."""
    return number.bit_length()
