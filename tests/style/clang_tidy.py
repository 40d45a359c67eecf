#!/usr/bin/env python3
"""Runs the checks of .clang-tidy on every source that a build folder compiles, and on the header of the same name.

clangd runs them: it looks at a file's own declarations alone, and is four times as fast as clang-tidy, which walks
through everything that is included. It takes nothing that a source uses from the precompiled header: what a source
uses is to be included by it or by a header that it includes. Highway's sources are read for one instruction set.

usage: clang_tidy.py ROOT BUILD [--jobs N]

A file that was clean is not looked at again until it, a header of ours that it includes, its compiler flags, the
configuration or the version of clang-tidy changes. What was clean is remembered in $KINORA_TIDY_CACHE, or else in
$XDG_CACHE_HOME/kinora-tidy (normally ~/.cache/kinora-tidy), as empty files named by hash: it serves all checkouts.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]', re.MULTILINE)
# Flags that change what clang reads; the rest is for g++ alone.
KEPT_FLAGS = re.compile(r"-(D|U|std=|m|O|fPIC|fPIE|pthread).*")
FLAGS_WITH_VALUE = ("-I", "-isystem")
ONE_INSTRUCTION_SET = "-DHWY_COMPILE_ONLY_STATIC"
FINDING = re.compile(r"E\[[\d:.]+\] (\[.*\] Line .*)")


def cache_folder():
    default = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "kinora-tidy"
    folder = pathlib.Path(os.environ.get("KINORA_TIDY_CACHE") or default)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def kept_flags(entry):
    """The flags of one entry of compile_commands.json that clang needs, without those of the precompiled header."""
    words = shlex.split(entry["command"])[1:]
    flags = []
    for i, word in enumerate(words):
        if word in FLAGS_WITH_VALUE:
            flags += [word, words[i + 1]]
        elif word.startswith(FLAGS_WITH_VALUE) or KEPT_FLAGS.fullmatch(word):
            flags.append(word)
    return flags


def folders(flags):
    """Those of the flags that tell where headers are."""
    return [f for f in flags if f in FLAGS_WITH_VALUE or f.startswith(("/", *FLAGS_WITH_VALUE))]


class Headers:
    """Contents of the repository's files and of what they include, read once."""

    def __init__(self, root):
        self.root = root
        self.texts = {}
        self.direct = {}

    def text(self, path):
        if path not in self.texts:
            self.texts[path] = path.read_text(encoding="utf-8")
        return self.texts[path]

    def includes(self, path):
        if path not in self.direct:
            folders = (path.parent, *(self.root / f for f in ("src", "include", "formats", "tests", "")))
            found = []
            for name in INCLUDE.findall(self.text(path)):
                candidates = (folder / name for folder in folders)
                found += [c.resolve() for c in candidates if c.is_file()][:1]
            self.direct[path] = found
        return self.direct[path]

    def closure(self, path):
        seen, waiting = set(), [path]
        while waiting:
            current = waiting.pop()
            if current not in seen:
                seen.add(current)
                waiting += self.includes(current)
        return sorted(seen)


class Precompiled:
    """One clang precompiled header per set of flags, made when it is first needed."""

    def __init__(self, header, header_flags, folder):
        self.header = header
        self.libraries = folders(header_flags)
        self.folder = folder
        self.made = {}

    def flags(self, flags):
        language = tuple(f for f in flags if not f.startswith(("-D", "-I")))
        if language not in self.made:
            name = hashlib.sha256(" ".join(language).encode()).hexdigest()[:16]
            output = self.folder / f"{name}.pch"
            command = ["clang++-14", "-w", "-x", "c++-header", *language, *self.libraries, str(self.header)]
            subprocess.run([*command, "-o", str(output)], check=True)
            self.made[language] = output
        return ["-include-pch", str(self.made[language])]


def check(path, database):
    """What is wrong with a file, one line each; nothing if it is clean."""
    command = ["clangd-14", f"--check={path}", "--check-lines=1-1", f"--compile-commands-dir={database}", "--log=error"]
    result = subprocess.run(command, check=False, capture_output=True, text=True)
    found = [m.group(1) for m in map(FINDING.match, result.stderr.splitlines()) if m]
    if result.returncode != 0 and not found:
        found = [result.stderr]
    return found


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    root, build = arguments.root.resolve(), arguments.build.resolve()

    version = subprocess.run(["clangd-14", "--version"], check=True, capture_output=True, text=True).stdout
    headers = Headers(root)
    pch_header = root / "cmake/pch.h"
    common = [version, ONE_INSTRUCTION_SET, headers.text(root / ".clang-tidy"), headers.text(pch_header)]
    cache = cache_folder()

    entries = {pathlib.Path(e["file"]).resolve(): e for e in json.loads((build / "compile_commands.json").read_text())}
    compiled = [p for p in sorted(entries) if p.suffix == ".cpp" and root in p.parents and build not in p.parents]
    files = {path: kept_flags(entries[path]) for path in compiled}
    for path in compiled:
        for header in headers.includes(path):
            if header.suffix == ".h" and header.stem == path.stem:
                files.setdefault(header, files[path])

    folder = build / "style"
    folder.mkdir(exist_ok=True)
    precompiled = Precompiled(pch_header, kept_flags(entries[build / "pch.cpp"]), folder)
    waiting = []
    for path, flags in files.items():
        portable = " ".join(flags).replace(str(build), "<build>").replace(str(root), "<root>")
        contents = [headers.text(p) for p in headers.closure(path)]
        key = hashlib.sha256("\0".join([*common, portable, *contents]).encode()).hexdigest()
        if not (cache / key).exists():
            waiting.append((path, cache / key))
    commands = [
        {"directory": str(root), "file": str(path), "arguments": ["clang++-14", "-w", ONE_INSTRUCTION_SET, *files[path],
         *precompiled.flags(files[path]), "-c", str(path)]}
        for path, _ in waiting
    ]
    (folder / "compile_commands.json").write_text(json.dumps(commands))

    print(f"clang-tidy: {len(files)} files, {len(files) - len(waiting)} were clean before and did not change", flush=True)
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for (path, mark), found in zip(waiting, pool.map(lambda job: check(job[0], folder), waiting)):
            if found:
                failed += 1
                print(f"{path.relative_to(root)} is not clean:", *found, sep="\n  ", flush=True)
            else:
                mark.touch()
    if failed:
        sys.exit(f"{failed} files are not clean")


if __name__ == "__main__":
    main()
