#!/usr/bin/env python3
"""Checks that an installation holds the tool and the public headers, and nothing else.

usage: install_check.py ROOT BUILD
"""
import pathlib
import subprocess
import sys
import tempfile


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    headers = pathlib.Path(sys.argv[1]) / "include"
    expected = {"bin/kinora"} | {f"include/{p.relative_to(headers).as_posix()}" for p in headers.rglob("*.h")}
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(["cmake", "--install", sys.argv[2], "--prefix", folder], check=True, stdout=subprocess.DEVNULL)
        prefix = pathlib.Path(folder)
        found = {p.relative_to(prefix).as_posix() for p in prefix.rglob("*") if not p.is_dir()}
        for name in sorted(found - expected):
            print(f"installed, but not public: {name}")
        for name in sorted(expected - found):
            print(f"public, but not installed: {name}")
        if found != expected:
            sys.exit(1)
        subprocess.run([str(prefix / "bin/kinora"), "--version"], check=True)


if __name__ == "__main__":
    main()
