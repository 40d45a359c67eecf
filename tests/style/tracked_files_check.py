#!/usr/bin/env python3
"""Checks what may be in the repository: no large files outside of samples, no machine paths, nothing unfinished.

usage: tracked_files_check.py ROOT
"""
import pathlib
import re
import sys

from tracked_files import tracked_files

LARGEST = 1_000_000  # bytes
SAMPLES_LARGEST = 24_000_000  # bytes of all samples together
MAY_BE_LARGE = ("samples/", "tests/conformance/")
# Written so that this file does not match itself.
FORBIDDEN = {
    "a path of somebody's machine": re.compile(r"(?<![\w.])/(home|work|root|Users)[/]\w|/tmp[/]bash"),
    "unfinished work": re.compile(r"\b(TO[D]O|FIX[M]E|XX[X])\b"),
}


def problems(root):
    found = []
    samples = 0
    for name in tracked_files(root):
        path = pathlib.Path(root) / name
        size = path.stat().st_size
        samples += size if name.startswith("samples/") else 0
        if size > LARGEST and not name.startswith(MAY_BE_LARGE):
            found.append(f"{name}: {size} bytes; more than {LARGEST} belong into samples/ or tests/conformance/")
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(lines, 1):
            for what, pattern in FORBIDDEN.items():
                if pattern.search(line):
                    found.append(f"{name}:{number}: {what}: {line.strip()[:100]}")
    if samples > SAMPLES_LARGEST:
        found.append(f"samples/: {samples} bytes; at most {SAMPLES_LARGEST}")
    return found


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = problems(sys.argv[1])
    for line in found:
        print(line)
    if found:
        sys.exit(f"{len(found)} things that should not be in the repository")


if __name__ == "__main__":
    main()
