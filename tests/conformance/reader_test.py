#!/usr/bin/env python3
"""Decodes the clips of this folder with the reader in Python, which knows docs/container.md alone.

Exits with 77, "skipped", where NumPy or zstandard is not installed.
"""
from __future__ import annotations

import json
import math
import pathlib
import re
import sys
import unittest
from typing import Callable

FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER / "reader"))
try:
    import numpy as np
    import zstandard  # pylint: disable=unused-import
except ImportError as missing:
    print(f"skipped: {missing}; install the packages python3-numpy and python3-zstandard")
    sys.exit(77)

import matroska
from arithmetic import Decoder, new_model
from budget import MEBIBYTE, Budget
from checks import crc32c, open_envelope, open_private
from clip import Clip, read_clip
from matroska import Damaged
from summary import checksums

METRES_OF_NODES = 2.0**-13
METRES_OF_JOINTS = 2.0**-9
FARTHEST_STEP = 0.15  # metres, of a node or joint from one frame to the next


def expectations() -> dict[str, list[list[int]]]:
    """The four checksums of each layer of each file, of expected.h."""
    text = (FOLDER / "expected.h").read_text(encoding="utf-8")
    table = text[text.index("kExpected{"):]
    four = r"\{(0x[0-9A-F]+|0), (0x[0-9A-F]+|0), (0x[0-9A-F]+|0), (0x[0-9A-F]+|0)\}"
    pieces = re.split(r'"(\w+\.mkv)"', table)[1:]
    return {name: [[int(number, 0) for number in numbers] for numbers in re.findall(four, piece)]
            for name, piece in zip(pieces[::2], pieces[1::2])}


def frames_expectations() -> dict[str, list[list[list[list[int]] | list[int]]]]:
    """Of each file the spans of frames at which each layer is away, and the frames at which its nodes are born."""
    text = (FOLDER / "expected.h").read_text(encoding="utf-8")
    pieces = re.split(r'"(\w+\.mkv)"', text[text.index("kExpected{"):])[1:]
    stated = {name: re.findall(r'"(\[\[.*?\]\])"', re.sub(r'"\s+"', "", piece))
              for name, piece in zip(pieces[::2], pieces[1::2])}
    return {name: [json.loads(each) for each in found] + [[[], [], []]] * (2 - len(found))
            for name, found in stated.items()}


def clips() -> list[tuple[str, bytes]]:
    return [(path.name, path.read_bytes()) for path in sorted(FOLDER.glob("*.mkv"))]


def usual_clips() -> list[tuple[str, bytes]]:
    """Without the one that tumbles wildly and has millions of occupied cells, which take seconds."""
    return [(name, data) for name, data in clips() if name != "clip_corner_cases.mkv"]


def flipped(data: bytes, bit: int) -> bytes:
    changed = bytearray(data)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


def element(identifier: int, body: bytes, unknown_size: bool = False) -> bytes:
    size = b"\xff" if unknown_size else (len(body) | 1 << 56).to_bytes(8, "big")
    return identifier.to_bytes((identifier.bit_length() + 7) // 8, "big") + size + body


def rewritten(data: bytes, change: dict[int, Callable[[bytes], bytes]], unknown_sizes: bool) -> bytes:
    """The elements of some bytes, those that have a change with what it makes of their body."""
    written, at = b"", 0
    while at < len(data):
        identifier, start, end = matroska._head(data, at)  # pylint: disable=protected-access
        body = data[start:end]
        unknown = unknown_sizes and identifier in (matroska.SEGMENT, matroska.CLUSTER)
        written += element(identifier, change.get(identifier, bytes)(body), unknown)
        at = start + len(body)
    return written


class Conformance(unittest.TestCase):
    def refuses(self, data: bytes, why: str) -> None:
        with self.assertRaisesRegex(Damaged, why):
            read_clip(data)

    def test_checksum_is_that_of_the_page(self) -> None:
        self.assertEqual(crc32c(b"123456789"), 0xE3069283)

    def test_refuses_bytes_left_behind_a_code_and_too_few_of_them(self) -> None:
        Decoder(bytes(4)).end()
        with self.assertRaises(Damaged):
            Decoder(bytes(5)).end()
        decoder = Decoder(b"")
        with self.assertRaises(Damaged):
            for _ in range(1000):
                decoder.bit(new_model())

    def test_decodes_to_the_expected_bits(self) -> None:
        expected = expectations()
        self.assertEqual(sorted(expected), [name for name, _ in clips()])
        for name, data in clips():
            with self.subTest(name):
                layers = read_clip(data).layers
                self.assertEqual([checksums(layer) for layer in layers], expected[name])
                away, births = frames_expectations()[name]
                self.assertEqual([layer.away for layer in layers], away)
                self.assertEqual([layer.births for layer in layers], births)

    def test_refuses_what_asks_for_more_memory_than_its_size_allows(self) -> None:
        budget = Budget(1000)
        budget.take(256 * MEBIBYTE)
        budget.take(64000)
        with self.assertRaisesRegex(Damaged, "memory"):
            budget.take(1)
        for name, data in usual_clips():
            with self.subTest(name):
                clip = read_clip(data)
                nodes = len(next(layer.graph.nodes for layer in clip.layers if layer.graph is not None))
                joints = next((len(layer.joints.names) for layer in clip.layers if layer.joints is not None), 0)
                self.assertGreaterEqual(clip.memory, len(clip.times) * (64 * nodes + 24 * joints))

    def test_poses_confidence_and_joints_are_plausible(self) -> None:
        for name, data in usual_clips():
            with self.subTest(name):
                self.check_plausible(read_clip(data))

    def check_plausible(self, clip: Clip) -> None:
        for pose in clip.camera + [pose for layer in clip.layers for pose in layer.poses]:
            self.assertAlmostEqual(math.hypot(*pose.rotation), 1, places=9)
            self.assertLess(math.hypot(*pose.translation), 10)
        kinds = {layer.kind: layer for layer in clip.layers}
        self.assertEqual(set(kinds), {"still", "rigid", "deforming"})
        self.assertEqual(len(kinds["rigid"].poses), len(clip.times))
        levels = [level for block in kinds["still"].confidence.values() for level in block]
        self.assertTrue(0 in levels and max(levels) > 5 and min(levels) >= 0 and max(levels) <= 15)
        person = kinds["deforming"]
        places = [[state.position for state in frame.states] for frame in person.deformations]
        for frames, unit in ((places, METRES_OF_NODES), (person.joints.frames, METRES_OF_JOINTS)):
            self.assertEqual(len(frames), len(clip.times))
            for before, now in zip(frames, frames[1:]):
                self.assertTrue(all(math.dist(a, b) * unit < FARTHEST_STEP for a, b in zip(before, now, strict=True)))

    def test_refuses_a_flipped_bit(self) -> None:
        for name, data in clips():
            blocks = matroska.read(data).blocks
            for number in range(0, len(blocks), max(1, len(blocks) // 12)):
                block = blocks[number][1]
                self.assertEqual(data.count(block), 1)
                start = 8 * data.index(block)
                for bit in (0, 13, 17, 35, 70, 8 * 16, 4 * len(block), 8 * len(block) - 1):  # head, checksum, time, payload
                    with self.subTest(name, block=number, bit=bit):
                        self.refuses(flipped(data, start + bit), "checksum of a payload")

    def test_refuses_a_flipped_bit_of_attachments_and_private_data(self) -> None:
        for name, data in clips():
            file = matroska.read(data)
            for attachment in file.attachments:
                with self.subTest(name, attachment=attachment.name):
                    self.refuses(flipped(data, 8 * data.index(attachment.data) + 100), "checksum of " + attachment.name)
            for track in file.tracks.values():
                with self.subTest(name, track=track.number):
                    self.refuses(flipped(data, 8 * data.index(track.private) + 50), "checksum of private data")

    def test_passes_over_a_damaged_payload_where_whole_parts_are_asked_for(self) -> None:
        for name, data in usual_clips():
            whole = read_clip(data)
            for number, (track, block) in enumerate(matroska.read(data).blocks):
                if not track.codec.endswith("FIELD"):
                    continue
                damaged = flipped(data, 8 * data.index(block) + 8 * len(block) - 3)
                with self.subTest(name, block=number):
                    layers = read_clip(damaged, whole_parts=True).layers
                    lacking = [i for i, layer in enumerate(layers) if layer.field is None or not layer.field.whole()]
                    self.assertEqual(len(lacking), 1)
                    field, its = layers[lacking[0]].field, whole.layers[lacking[0]].field
                    if block[16] == 8:  # all levels before the damaged one, none from it on
                        came = [level is not None for level in field.levels]
                        self.assertEqual(came, [level < block[17] for level in range(len(its.levels))])
                    else:
                        self.assertIsNone(field)

    def test_reads_what_is_whole_of_a_cut_file(self) -> None:
        for name, data in usual_clips():
            whole, blocks = read_clip(data), matroska.read(data).blocks
            first_camera = next(i for i, (track, _) in enumerate(blocks) if track.codec.endswith("CAMERA"))
            for number in range(first_camera + 1, len(blocks), max(1, len(blocks) // 10)):
                block = blocks[number][1]
                cut = data[:data.index(block) + len(block) // 2]
                with self.subTest(name, block=number):
                    self.refuses(cut, "file ends")
                    held = matroska.read(cut, may_be_cut=True)
                    self.assertTrue(held.cut)
                    self.assertEqual([block for _, block in held.blocks], [block for _, block in blocks[:number]])
                    self.check_part_of(read_clip(cut, whole_parts=True), whole, held)

    def check_part_of(self, part: Clip, whole: Clip, held: matroska.File) -> None:
        """Everything that the part has is as in the whole clip, and all of its payloads of motion were used."""
        motions = sum(track.codec.endswith(("MOTION", "CAMERA")) for track, _ in held.blocks)
        found = [(part.camera, whole.camera)]
        for a, b in zip(part.layers, whole.layers, strict=True):
            found += [(a.poses, b.poses), (a.deformations, b.deformations)]
            for level, its in zip(a.field.levels if a.field else [], b.field.levels):
                self.assertTrue(level is None or np.array_equal(level, its))
            self.assertTrue(a.confidence is None or a.confidence == b.confidence)
        for some, every in found:
            self.assertEqual([x for x in some if x is not None], [y for x, y in zip(some, every) if x is not None])
        self.assertEqual(sum(x is not None for some, _ in found for x in some), motions)

    def test_reads_other_ways_to_write_the_same(self) -> None:
        """Clusters and a segment of unknown size, BlockGroups, Void elements, and the first byte of each block stripped."""
        encoding = element(0x6D80, element(0x6240, element(0x5034, element(0x4254, b"\3") + element(0x4255, b"\1"))))
        for name, data in usual_clips():
            for track, block in matroska.read(data).blocks:
                self.assertEqual(open_envelope(block, open_private(track.private)[0]).data, block[16:])
                self.assertEqual(block[0], 1)

            def group(cluster: bytes) -> bytes:
                blocks = rewritten(cluster, {0xA3: lambda body: body[:4] + body[5:]}, False)  # one-byte numbers of tracks
                return b"".join(
                    element(0xEC, b"void") + (element(0xA0, element(0xA1, child.body)) if child.identifier == 0xA3
                                              else element(child.identifier, child.body))
                    for child in matroska._children(blocks))  # pylint: disable=protected-access

            def tracks(body: bytes) -> bytes:
                return rewritten(body, {0xAE: lambda entry: entry + encoding}, False)

            def segment(body: bytes) -> bytes:
                return rewritten(body, {matroska.TRACKS: tracks, matroska.CLUSTER: group}, True)

            changed = rewritten(data, {matroska.SEGMENT: segment}, True)
            with self.subTest(name):
                self.assertNotIn(matroska.read(data).blocks[0][1], changed)
                self.assertEqual([checksums(layer) for layer in read_clip(changed).layers], expectations()[name])


if __name__ == "__main__":
    unittest.main()
