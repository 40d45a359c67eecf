#!/usr/bin/env python3
"""Checks that clang-format would change no tracked C++ file.

usage: format_check.py ROOT
"""
import subprocess
import sys

from tracked_files import tracked_files


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    root = sys.argv[1]
    files = [f for f in tracked_files(root) if f.endswith((".h", ".cpp", ".c"))]
    result = subprocess.run(["clang-format-14", "--dry-run", "-Werror", *files], cwd=root, check=False,
                            capture_output=True, text=True)
    print(result.stdout + result.stderr, end="")
    if result.returncode != 0:
        sys.exit("some files are not formatted; run: clang-format-14 -i $(git ls-files '*.h' '*.cpp' '*.c')")
    print(f"{len(files)} files are formatted")


if __name__ == "__main__":
    main()
