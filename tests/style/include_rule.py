#!/usr/bin/env python3
"""Checks who includes whom: rooms of src/ see only the rooms to their left, formats/ see include/kinora/ and src/core.

usage: include_rule.py ROOT    Prints one line per violation; exits 1 if there are any.
"""
import pathlib
import re
import sys

ROOMS = ["core", "container", "host", "ingest", "tracking", "fields", "encode", "player", "bake", "cli"]
# Libraries that one place alone may know: include prefix -> files (below the root) that may use it.
ONE_USER = {
    "tbb/": re.compile(r"src/core/parallel\w*\.cpp"),
    "oneapi/": re.compile(r"src/core/parallel\w*\.cpp"),
    "libav": re.compile(r"formats/mp4/.*"),
    "opencv2/": re.compile(r"src/ingest/(.*/)?(network|onnx|opencv)_\w+\.(cpp|h)"),
    "hwy/": re.compile(r"(src|tests|bench)/.*_simd\w*\.(cpp|h)"),
}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]', re.MULTILINE)


def may_see(own_room, target_room):
    """Is the room of the including file allowed to include a file of the other room?"""
    if own_room == target_room:
        return True
    if own_room == "kinora":
        return False  # what is installed stands alone
    if own_room == "formats":  # the table of the formats that come with Kinora
        return target_room in ("kinora", "core") or target_room.startswith("formats/")
    if own_room.startswith("formats/"):
        return target_room in ("kinora", "core", "formats/common")
    if target_room == "kinora":
        return own_room != "core"
    if target_room not in ROOMS or own_room not in ROOMS:
        return False
    if (own_room, target_room) == ("bake", "player"):
        return False  # they stand side by side
    return ROOMS.index(target_room) < ROOMS.index(own_room)


def room_of(path, root):
    """src/core/a.h -> core; formats/png/a.h -> formats/png; formats/a.cpp -> formats; include/kinora/a.h -> kinora"""
    parts = path.relative_to(root).parts
    if parts[0] == "src" and len(parts) > 2:
        return parts[1]
    if parts[0] == "formats":
        return "/".join(parts[: min(2, len(parts) - 1)])
    if parts[:2] == ("include", "kinora"):
        return "kinora"
    return None


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
            target_room = room_of(target, root)
            if own_room is None or target_room is None or not may_see(own_room, target_room):
                found.append(f"{where}: {own_room or own_name} may not include {target.relative_to(root).as_posix()}")
    return found


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = violations(pathlib.Path(sys.argv[1]).resolve())
    for line in found:
        print(line)
    if found:
        rule = " <- ".join(ROOMS)
        sys.exit(f"{len(found)} includes against the rule: {rule}; formats/ see include/kinora/ and src/core")


if __name__ == "__main__":
    main()
