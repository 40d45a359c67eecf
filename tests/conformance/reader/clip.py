"""A clip: its timeline and layers, put together from attachments and tracks."""
from __future__ import annotations

import dataclasses
import json
from typing import Any

import matroska
from births import read_births
from budget import MEBIBYTE, Budget
from checks import Payload, open_attachment, open_envelope, open_private
from confidence import read_confidence
from deformation import Deformations, Frame, Graph, read_graph
from joints import Joints, read_joints
from matroska import Damaged
from poses import Pose, read_pose
from radiance_field import Field, read_field
from zstandard_frame import decompress

BYTES_OF_A_NODE = 64  # in each frame
DEEPEST = 64
TRACKS_OF_A_LAYER = ("field_track", "motion_track", "confidence_track", "joints_track", "births_track")


@dataclasses.dataclass
class Layer:
    name: str
    label: int
    kind: str
    field: Field | None = None
    poses: list[Pose | None] = dataclasses.field(default_factory=list)  # of a rigid layer
    graph: Graph | None = None
    deformations: list[Frame | None] = dataclasses.field(default_factory=list)
    confidence: dict[tuple[int, int, int], list[int]] | None = None
    joints: Joints | None = None
    births: list[int] = dataclasses.field(default_factory=list)  # a frame for each node; none: all from the start
    away: list[list[int]] = dataclasses.field(default_factory=list)  # spans of frames, [begin, end)


@dataclasses.dataclass
class Clip:
    times: list[int]
    calibration: dict[str, Any]
    metadata: dict[str, Any]
    camera: list[Pose | None]
    layers: list[Layer]
    memory: int  # bytes that it asked for


@dataclasses.dataclass
class Track:
    codec: str
    private: bytes
    payloads: list[Payload] = dataclasses.field(default_factory=list)


def _depth(value: Any) -> int:
    if isinstance(value, dict):
        value = list(value.values())
    return 1 + max(map(_depth, value), default=0) if isinstance(value, list) else 0


def _json(data: bytes, name: str) -> dict[str, Any]:
    try:
        value = json.loads(data.decode("utf-8"))
        if not isinstance(value, dict) or _depth(value) > DEEPEST:
            raise Damaged(f"{name} is not an object, or nested too deeply")
    except (ValueError, RecursionError) as error:
        raise Damaged(f"{name}: {error}") from error
    return value


def _attachments(file: matroska.File, whole_parts: bool) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    for attachment in file.attachments:
        try:
            data = open_attachment(attachment)
        except Damaged:
            if not whole_parts:
                raise
            continue
        if data is not None:
            found.setdefault(attachment.name, data)
    return found


def _tracks(file: matroska.File, whole_parts: bool) -> dict[int, Track]:
    """Kinora's tracks by their ids, each with its payloads in the order of time."""
    tracks: dict[int, Track] = {}
    ids: dict[int, int] = {}
    for track in file.tracks.values():
        if not track.codec.startswith(matroska.KINORA):
            continue
        try:
            identifier, private = open_private(track.private)
        except Damaged:
            if not whole_parts:
                raise
            continue
        if identifier in tracks:
            raise Damaged(f"two tracks with the id {identifier}")
        ids[track.number] = identifier
        tracks[identifier] = Track(track.codec, private)
    for track, block in file.blocks:
        if track.number not in ids:
            continue
        identifier = ids[track.number]
        try:
            tracks[identifier].payloads.append(open_envelope(block, identifier))
        except Damaged:
            if not whole_parts:
                raise
    for track in tracks.values():
        track.payloads.sort(key=lambda payload: payload.time)
    return tracks


def _require(condition: bool, what: str) -> None:
    if not condition:
        raise Damaged(what)


def _check_timeline(description: dict[str, Any]) -> None:
    times, captured, held_out = (description.get(key) for key in ("times_ns", "capture_frames", "held_out"))
    for numbers in (times, captured, held_out):
        _require(isinstance(numbers, list) and all(type(n) is int for n in numbers), "clip.json: the timeline")
    _require(bool(times) and times[0] >= 0 and all(a < b for a, b in zip(times, times[1:])), "clip.json: times_ns")
    _require(len(captured) == len(times), "clip.json: capture_frames")
    _require(all(0 <= frame < len(times) for frame in held_out), "clip.json: held_out")
    camera = description.get("camera")
    _require(isinstance(camera, dict) and type(camera.get("track")) is int and type(camera.get("moves")) is bool,
             "clip.json: camera")


def _check_away(spans: Any, frames: int) -> None:
    _require(isinstance(spans, list) and all(isinstance(span, list) and len(span) == 2 for span in spans) and
             all(type(frame) is int for span in spans for frame in span), "clip.json: away")
    ends = [-1] + [frame for span in spans for frame in span] + [frames + 1]
    _require(all(a < b for a, b in zip(ends, ends[1:])), "clip.json: spans of frames at which a layer is away")


def _check_layers(description: dict[str, Any]) -> None:
    layers = description.get("layers")
    _require(isinstance(layers, list) and len(layers) <= 255 and all(isinstance(layer, dict) for layer in layers),
             "clip.json: layers")
    tracks = [description["camera"]["track"]]
    for layer in layers:
        name, kind = layer.get("name"), layer.get("kind")
        _require(isinstance(name, str) and 1 <= len(name.encode()) <= 255, "clip.json: name of a layer")
        _require(kind in ("still", "rigid", "deforming"), "clip.json: kind of a layer")
        _require(type(layer.get("label")) is int, "clip.json: label of a layer")
        _require("field_track" in layer and ("motion_track" in layer) == (kind != "still"), "clip.json: tracks of a layer")
        _require("joints_track" not in layer or kind == "deforming", "clip.json: joints of a layer")
        _require("births_track" not in layer or kind == "deforming", "clip.json: births of a layer")
        _check_away(layer.get("away", []), len(description["times_ns"]))
        tracks += [layer[key] for key in TRACKS_OF_A_LAYER if key in layer]
    _require(len({layer["name"] for layer in layers}) == len(layers), "clip.json: a name stands twice")
    _require(all(type(t) is int for t in tracks) and len(set(tracks)) == len(tracks), "clip.json: a track stands twice")


def _check_calibration(calibration: dict[str, Any]) -> None:
    _require(calibration.get("version") == 1, "version of calibration.json")
    _require(all(type(calibration.get(key)) is int and calibration[key] > 0 for key in ("width", "height")) and
             all(type(calibration.get(key)) in (int, float) for key in ("fx", "fy", "cx", "cy")), "calibration.json")


class _Reading:
    """The tracks of a clip. Of what is missing or damaged, whole parts are given if they are all that is asked for."""

    def __init__(self, tracks: dict[int, Track], times: list[int], budget: Budget, whole_parts: bool) -> None:
        self.tracks, self.times, self.budget, self.whole_parts = tracks, times, budget, whole_parts

    def track(self, identifier: int, codec: str) -> Track:
        track = self.tracks.get(identifier)
        if track is None or track.codec != matroska.KINORA + codec:
            _require(self.whole_parts, f"no track {identifier} of {codec}")
            return Track(codec, b"")
        times = set(self.times)
        _require(all(payload.time in times for payload in track.payloads), f"a payload of track {identifier} has no frame")
        return track

    def frames(self, track: Track, times: list[int], what: str) -> list[Payload | None]:
        """The payload at each of the times."""
        found = {payload.time: payload for payload in track.payloads}
        if not self.whole_parts:
            _require([payload.time for payload in track.payloads] == times, f"{what}: not one payload for each frame")
        return [found.get(time) for time in times]

    def poses(self, track: Track, times: list[int], of_camera: bool) -> list[Pose | None]:
        return [None if payload is None else read_pose(payload.data, of_camera)
                for payload in self.frames(track, times, "poses")]

    def deformations(self, track: Track, graph: Graph) -> list[Frame | None]:
        self.budget.take(BYTES_OF_A_NODE * len(graph.nodes) * len(self.times))
        reader = Deformations(graph)
        frames: list[Frame | None] = []
        for payload in self.frames(track, self.times, "deformations"):
            if payload is None:
                reader.before = None
            lost = payload is None or (self.whole_parts and reader.before is None and not payload.key)
            frames.append(None if lost else reader.read(payload.data, payload.key))
        return frames

    def field(self, track: Track) -> Field | None:
        payloads = track.payloads
        if self.whole_parts and not (payloads and payloads[0].key):
            return None
        _require(bool(payloads) and all(payload.time == self.times[0] for payload in payloads), "time of a field")
        _require([payload.key for payload in payloads] == [True] + [False] * (len(payloads) - 1), "key flags of a field")
        read = read_field([payload.data for payload in payloads], self.budget, self.whole_parts)
        _require(self.whole_parts or read.whole(), "a field lacks a level")
        return read

    def only(self, track: Track) -> bytes | None:
        """The one payload of a track at the first frame's time."""
        if not track.payloads and self.whole_parts:
            return None
        _require([(p.key, p.time) for p in track.payloads] == [(True, self.times[0])], "not one payload at the first frame")
        return track.payloads[0].data

    def layer(self, description: dict[str, Any]) -> Layer:
        layer = Layer(description["name"], description["label"], description["kind"], away=description.get("away", []))
        layer.field = self.field(self.track(description["field_track"], "FIELD"))
        if layer.kind != "still":
            track = self.track(description["motion_track"], "MOTION")
            if layer.kind == "rigid":
                layer.poses = self.poses(track, self.times, False)
            elif track.private or not self.whole_parts:
                layer.graph = read_graph(track.private)
                layer.deformations = self.deformations(track, layer.graph)
        if "confidence_track" in description:
            payload = self.only(self.track(description["confidence_track"], "CONFIDENCE"))
            if payload is not None and layer.field is not None:
                layer.confidence = read_confidence(payload, layer.field.occupancy, self.budget)
        if "joints_track" in description:
            payload = self.only(self.track(description["joints_track"], "JOINTS"))
            layer.joints = None if payload is None else read_joints(payload, len(self.times), self.budget)
        if "births_track" in description:
            payload = self.only(self.track(description["births_track"], "BIRTHS"))
            if payload is not None and layer.graph is not None:
                layer.births = read_births(payload, layer.graph.nodes, len(self.times), self.budget)
        return layer


def read_clip(data: bytes, whole_parts: bool = False) -> Clip:
    """The clip that a file holds. What is cut or damaged is refused, or passed over if whole parts are asked for."""
    file = matroska.read(data, may_be_cut=whole_parts)
    _require(file.tags.get("KINORA_KIND") == "clip" and file.tags.get("KINORA_VERSION") == "1", "not recognised as a clip")
    attachments = _attachments(file, whole_parts)
    for name in ("clip.json", "calibration.json"):
        _require(name in attachments, f"no {name}")
    description = _json(attachments["clip.json"], "clip.json")
    _require(description.get("version") == 1, "version of clip.json")
    _check_timeline(description)
    _check_layers(description)
    calibration = _json(attachments["calibration.json"], "calibration.json")
    _check_calibration(calibration)
    metadata = attachments.get("metadata.json", b"{}")
    if "metadata.json.zst" in attachments:
        metadata = decompress(attachments["metadata.json.zst"], 16 * MEBIBYTE)
    times = description["times_ns"]
    budget = Budget(len(data))
    reading = _Reading(_tracks(file, whole_parts), times, budget, whole_parts)
    camera = description["camera"]
    poses = reading.poses(reading.track(camera["track"], "CAMERA"), times if camera["moves"] else times[:1], True)
    _require(any(pose is not None for pose in poses), "no pose of the camera")
    layers = [reading.layer(layer) for layer in description["layers"]]
    return Clip(times, calibration, _json(metadata, "metadata.json"), poses, layers, budget.taken)
