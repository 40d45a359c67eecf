#!/usr/bin/env python3
"""Checks who includes whom: every room and sub-room sees itself, what RULES gives it, and what these see in turn.

usage: include_rule.py ROOT    Prints one line per violation; exits 1 if there are any.
"""
import functools
import pathlib
import re
import sys

# A room or sub-room -> what it may include besides itself. What a room of the list sees is seen with it.
PLAY = {  # what a player needs: builds alone, natively and for WebAssembly
    "core": [],
    "container": ["core"],
    "motion/skinning": ["core"],
    "motion": ["motion/skinning"],
    "fields/model": ["core"],
    "fields/network": ["fields/model"],
    "fields/rendering": ["fields/network", "motion"],
    "clip/coding": ["core"],
    "clip/payloads": ["clip/coding", "container", "fields/network", "motion"],
    "clip": ["clip/payloads"],
    "player": ["clip", "fields/rendering", "include/kinora"],
    "player/gl": ["fields/rendering"],
    "player/http": ["container"],
    "libav": ["core"],
    "sound": ["container", "include/kinora", "libav"],
    "player/window": ["player", "sound"],
}
MAKE = {  # from a capture to a clip
    "recording": ["container", "include/kinora", "libav"],  # what its file holds, and reading it
    "host": ["core", "include/kinora"],
    "ingest/frame": ["core"],
    "ingest/onnx": ["core"],
    "ingest/files": ["core"],
    "ingest/depth": ["ingest/frame"],
    "ingest/capture": ["ingest/depth", "host"],
    "record": ["recording", "core"],
    "ingest/opencv": ["core"],
    "ingest/images": ["ingest/frame", "ingest/opencv"],
    "ingest/calibration": ["ingest/capture", "ingest/images"],
    "ingest/segmentation": ["ingest/calibration", "ingest/onnx"],
    "ingest/joints": ["ingest/segmentation"],
    "tracking/view": ["ingest/frame"],
    "tracking/tsdf": ["tracking/view", "motion"],
    "tracking/model": ["tracking/tsdf"],
    "tracking/lost": ["motion"],
    "tracking/rigid": ["tracking/tsdf", "tracking/lost"],
    "tracking/camera": ["tracking/rigid"],
    "tracking/body": ["tracking/rigid", "ingest/files"],
    "tracking/solver": ["tracking/model"],
    "tracking/deforming": ["tracking/body", "tracking/solver"],
    "fields/sampling": ["ingest/frame", "fields/network", "motion"],
    "fields/training": ["fields/sampling"],
    "fields/planning": ["fields/training", "fields/rendering"],
    "encode/live": ["encode"],
    "encode": ["clip", "fields/planning", "ingest/joints", "tracking/camera", "tracking/deforming"],
}
LOOK = {  # at what was made
    "evaluate": ["player", "ingest/joints"],
    "bake": ["clip", "fields/network", "motion/skinning", "host"],
    "cli": ["encode/live", "evaluate", "bake", "record", "sound", "player/http", "player/window"],
}
FORMATS = {
    "include/kinora": [],  # what is installed stands alone
    "formats/common": ["core", "include/kinora"],
    "formats/kinora_clip": ["formats/common", "player"],
    "formats/kinora_recording": ["formats/common", "record", "sound"],
    "formats/video": ["formats/common", "libav"],
    "formats/video_pair": ["formats/common", "sound"],
    "formats/*": ["formats/common"],  # one folder per format; none sees another
    "formats": ["formats/*", "formats/kinora_clip", "formats/kinora_recording", "formats/video_pair"],  # the table of the formats that come with Kinora
}
RULES = PLAY | MAKE | LOOK | FORMATS

# Libraries that one place alone may know: include prefix -> files (below the root) that may use it.
ONE_USER = {
    "tbb/": re.compile(r"src/core/parallel\w*\.cpp"),
    "oneapi/": re.compile(r"src/core/parallel\w*\.cpp"),
    "httplib.h": re.compile(r"src/player/http/.*"),
    "GLFW/": re.compile(r"src/player/window/glfw_window\.cpp"),
    "SDL.h": re.compile(r"src/player/window/sdl_loudspeaker\.cpp"),
    "imgui": re.compile(r"src/player/window/(glfw_window|panel)\.cpp"),
    "libav": re.compile(r"(formats/(mp4|video)/.*|src/libav/.*|src/sound/libav.*|src/recording/ffv1_module\.cpp)"),
    "libfreenect": re.compile(r"formats/freenect/.*"),
    "OpenNI.h": re.compile(r"(formats/openni/.*|tests/formats/oni_samples/.*)"),
    "tiny_gltf.h": re.compile(r"formats/gltf_scene/gltf_library\.h"),
    "OpenEXR/": re.compile(r"(formats/exr/.*|tests/formats/exr_test\.cpp)"),
    "Imath/": re.compile(r"(formats/exr/.*|tests/formats/exr_test\.cpp)"),
    "opencv2/": re.compile(r"src/ingest/(onnx/onnx|opencv/opencv|segmentation/network|joints/network)_\w+\.(cpp|h)"),
    "hwy/": re.compile(r"(src|tests|bench)/.*_simd\w*\.(cpp|h)"),
}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]', re.MULTILINE)


@functools.cache
def seen_from(room):
    """All rooms that a room of RULES may include, itself not among them."""
    return set(RULES[room]).union(*(seen_from(other) for other in RULES[room]))


def rule_of(room):
    if room.startswith("formats/") and room not in RULES:
        return "formats/*"
    return room


def may_see(own_room, target_room):
    """Is the room of the including file allowed to include a file of the other room?"""
    if own_room == target_room:
        return True
    return rule_of(own_room) in RULES and rule_of(target_room) in seen_from(rule_of(own_room))


def room_of(path, root):
    """src/core/a.h -> core; src/fields/model/a.h -> fields/model; formats/png/a.h -> formats/png; include/kinora/a.h"""
    return path.relative_to(root).parent.as_posix().removeprefix("src/")


def resolve(name, including, root):
    """The file of ours that an #include means, or None."""
    for folder in (including.parent, root / "src", root / "include", root / "formats", root):
        candidate = (folder / name).resolve()
        if candidate.is_file() and root in candidate.parents:
            return candidate
    return None


def violations(root):
    found = []
    files = [p for top in ("src", "formats", "include") for p in sorted((root / top).rglob("*"))]
    for path in (p for p in files if p.suffix in (".h", ".cpp")):
        own_room = room_of(path, root)
        own_name = path.relative_to(root).as_posix()
        text = path.read_text(encoding="utf-8")
        if rule_of(own_room) not in RULES:
            found.append(f"{own_name}:1: {own_room} is no room of tests/style/include_rule.py")
            continue
        for match in INCLUDE.finditer(text):
            where = f"{own_name}:{text.count(chr(10), 0, match.start(2)) + 1}"
            name = match.group(2)
            for prefix, users in ONE_USER.items():
                if name.startswith(prefix) and not users.fullmatch(own_name):
                    found.append(f"{where}: only {users.pattern} may include <{name}>")
            target = resolve(name, path, root)
            if target is None:
                if match.group(1) == '"':
                    found.append(f'{where}: "{name}" is no file of ours; write foreign headers in angle brackets')
                continue
            if not may_see(own_room, room_of(target, root)):
                found.append(f"{where}: {own_room} may not include {target.relative_to(root).as_posix()}")
    return found


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = violations(pathlib.Path(sys.argv[1]).resolve())
    for line in found:
        print(line)
    if found:
        sys.exit(f"{len(found)} includes against the table in tests/style/include_rule.py")


if __name__ == "__main__":
    main()
