"""What a clip decodes to, in numbers that others can compare."""
from __future__ import annotations

import math
import struct
from typing import Any

from checks import crc32c
from clip import Clip, Layer


def checksums(layer: Layer) -> list[int]:
    """Of table, density network and colour network as floats, and of the motion as i32: health, and translation and rotation
    matrix of a pose or the states of nodes."""
    numbers: list[int] = []
    for pose in layer.poses:
        if pose is not None:
            numbers.append(pose.health)
            numbers += (math.floor(x * 1e6 + 0.5) for x in pose.translation)
            numbers += (math.floor(x * 2**16 + 0.5) for x in pose.matrix())
    for frame in layer.deformations:
        if frame is not None:
            numbers.append(frame.health)
            for state in frame.states:
                numbers += (*state.position, *state.rotation)
    field = layer.field
    arrays = [] if field is None else [field.table(), field.density_net, field.color_net]
    motion = crc32c(struct.pack(f"<{len(numbers)}i", *numbers)) if numbers else 0
    return [crc32c(array.astype("<f4").tobytes()) for array in arrays] + [motion]


def _of_layer(layer: Layer) -> dict[str, Any]:
    found: dict[str, Any] = {"name": layer.name, "label": layer.label, "kind": layer.kind,
                             "checksums": [f"{value:08X}" for value in checksums(layer)]}
    if layer.field is not None:
        field = layer.field
        found["field"] = {"version": field.version,
                          "geometry": "signed distances" if field.signed_distances else "densities",
                          "resolutions": field.resolutions, "levels": sum(level is not None for level in field.levels),
                          "occupied_cells": int(field.occupancy.sum())}
    motion = layer.poses or layer.deformations
    if motion:
        found["frames_with_motion"] = sum(frame is not None for frame in motion)
        found["health"] = "".join("-" if frame is None else "thl"[frame.health] for frame in motion)
    if layer.graph is not None:
        found["nodes"] = len(layer.graph.nodes)
    if layer.confidence is not None:
        levels = [level for block in layer.confidence.values() for level in block]
        found["confidence"] = {"blocks": len(layer.confidence), "mean": round(sum(levels) / max(1, len(levels)), 3)}
    if any(layer.births):
        found["nodes_born_late"] = sum(birth > 0 for birth in layer.births)
    if layer.away:
        found["away"] = layer.away
    if layer.joints is not None:
        found["joints"] = layer.joints.names
    return found


def summary(clip: Clip) -> dict[str, Any]:
    return {"frames": len(clip.times), "seconds": (clip.times[-1] - clip.times[0]) / 1e9,
            "camera_poses": sum(pose is not None for pose in clip.camera), "calibration": clip.calibration,
            "metadata": sorted(clip.metadata), "layers": [_of_layer(layer) for layer in clip.layers]}
