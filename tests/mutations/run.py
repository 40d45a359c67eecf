#!/usr/bin/env python3
"""Puts faults into the code, one at a time, and shows which tests notice.

usage: tests/mutations/run.py [--list] [--table FILE] [WORD...]

Those faults are tried whose name, file or test program holds one of the words (default: all of faults.toml). Prints a table, and puts its rows into FILE in
place of those of the same faults. Works on a worktree of its own in
build/mutations, with what is tracked here, changes included; builds only what a fault's tests need. First every test
that is to notice something has to pass without any fault. Exit code: 0 if every fault is noticed, 1 if one survives,
2 if a fault cannot be tried: its place is gone or not unique, it does not compile, or its filter matches no test.
"""
import argparse
import os
import pathlib
import signal
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
TREE = ROOT / "build/mutations"
BUILD = TREE / "build/release"  # where worktrees have it: compilations are shared with them
SECONDS_OF_A_TEST = 600
HEAD = ["| fault | in `src/` | noticed by |", "| --- | --- | --- |"]


class Unusable(Exception):
    """A fault that says nothing about the tests."""


@dataclass
class Fault:
    name: str
    file: str
    code: str
    fault: str
    tests: dict[str, str]  # program -> gtest filter

    def is_meant_by(self, word: str) -> bool:
        return any(word in part for part in (self.name, self.file, *self.tests))

    def mutated(self, text: str) -> str:
        count = text.count(self.code)
        if count != 1:
            raise Unusable(f"its place is {count} times in {self.file}")
        if self.code == self.fault:
            raise Unusable("it changes nothing")
        return text.replace(self.code, self.fault)


def read_faults() -> list[Fault]:
    table = tomllib.loads((pathlib.Path(__file__).parent / "faults.toml").read_text())
    faults = [Fault(**entry) for entry in table["faults"]]
    names = [fault.name for fault in faults]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        sys.exit(f"two faults have one name: {', '.join(sorted(twice))}")
    return faults


def run(*words, cwd=ROOT) -> str:
    return subprocess.run([str(w) for w in words], cwd=cwd, check=True, capture_output=True, text=True).stdout.strip()


def prepare_tree() -> None:
    """The worktree holds what is tracked here, as it is now."""
    commit = run("git", "stash", "create") or run("git", "rev-parse", "HEAD")
    if not (TREE / ".git").exists():
        run("git", "worktree", "prune")
        run("git", "worktree", "add", "--detach", TREE, commit)
    run("git", "checkout", "--force", "--detach", commit, cwd=TREE)
    if not (BUILD / "build.ninja").exists():
        run("cmake", "--preset", "release", "-DKINORA_BUILD_BENCH=OFF", cwd=TREE)


def build(targets) -> None:
    made = subprocess.run(["cmake", "--build", BUILD, "--target", *sorted(targets)], capture_output=True, text=True)
    if made.returncode != 0:
        raise Unusable("it does not compile:\n" + "\n".join(made.stdout.splitlines()[-15:]))


def failing_test(program: str, tests: str) -> str | None:
    """The first test that fails, or nothing."""
    words = [str(BUILD / "bin" / program), f"--gtest_filter={tests}", "--gtest_fail_fast", "--gtest_brief=1"]
    test = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, errors="replace",
                            start_new_session=True)
    try:
        said, _ = test.communicate(timeout=SECONDS_OF_A_TEST)
    except subprocess.TimeoutExpired:
        os.killpg(test.pid, signal.SIGKILL)  # with all that it has started
        test.wait()
        return f"{program} does not end"
    if "[==========] 0 tests" in said:
        raise Unusable(f"{program} has no test {tests}")
    if test.returncode == 0:
        return None
    failed = [line.split("]")[1].split("(")[0].split(",")[0].strip()
              for line in said.splitlines() if line.startswith("[  FAILED  ]")]
    return failed[0] if failed else f"{program} ends with {test.returncode}"


def noticed_by(fault: Fault) -> str | None:
    source = TREE / fault.file
    original = source.read_text()
    source.write_text(fault.mutated(original))
    try:
        build(fault.tests)
        for program, tests in fault.tests.items():
            failed = failing_test(program, tests)
            if failed:
                return failed
        return None
    finally:
        source.write_text(original)


def require_green(faults: list[Fault]) -> None:
    """All tests that are to notice something pass as the code is."""
    filters: dict[str, list[str]] = {}
    for fault in faults:
        fault.mutated((TREE / fault.file).read_text())
        for program, tests in fault.tests.items():
            if tests not in filters.setdefault(program, []):
                filters[program].append(tests)
    build(filters)
    for program, several in filters.items():
        for tests in several:
            failed = failing_test(program, tests)
            if failed:
                raise Unusable(f"{program}: {failed} fails without any fault")


def row(fault: Fault, result: str) -> str:
    return f"| {fault.name} | {pathlib.PurePath(fault.file).relative_to('src')} | {result} |"


def put_row(table: pathlib.Path, fault: Fault, new: str) -> None:
    """Rows stand in the order of faults.toml; those of faults that are no more go."""
    rows = {fault.name: new}
    text = table.read_text() if table.exists() else ""
    before = text.split("\n".join(HEAD))[0]
    for line in text.splitlines():
        rows.setdefault(line.split("|")[1].strip() if line.startswith("|") else "", line)
    ordered = [rows[known.name] for known in read_faults() if known.name in rows]
    table.write_text(before + "\n".join(HEAD + ordered) + "\n")


def main() -> int:
    parser = argparse.ArgumentParser(description="Which tests notice which faults.")
    parser.add_argument("--list", action="store_true", help="only check that every fault has its place")
    parser.add_argument("--table", type=pathlib.Path, help="a file that holds the table: its rows are renewed")
    parser.add_argument("words", nargs="*", metavar="WORD", help="part of a fault's name, file or test program")
    options = parser.parse_args()
    faults = [f for f in read_faults() if not options.words or any(f.is_meant_by(word) for word in options.words)]
    if options.list:
        bad = 0
        for fault in faults:
            try:
                fault.mutated((ROOT / fault.file).read_text())
                print(fault.name)
            except (Unusable, OSError) as problem:
                print(f"{fault.name}: {problem}")
                bad += 1
        return 2 if bad else 0
    try:
        prepare_tree()
        require_green(faults)
    except Unusable as problem:
        print(problem)
        return 2
    print("\n".join(HEAD), flush=True)
    survivors = unusable = 0
    for fault in faults:
        begin = time.monotonic()
        try:
            result = noticed_by(fault)
        except Unusable as problem:
            unusable += 1
            result = f"**not tried**: {problem}"
        if result is None:
            survivors += 1
            result = "**nothing**"
        print(f"{row(fault, result)} {time.monotonic() - begin:.0f} s", flush=True)
        if options.table:
            put_row(options.table, fault, row(fault, result))
    print(f"{len(faults)} faults, {survivors} survive, {unusable} could not be tried")
    return 2 if unusable else 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
