#!/usr/bin/env python3
"""Builds the examples of samples/player outside the tree against an installation, runs them on a clip, and compares
their picture with the one that `kinora render` draws.

usage: installed_check.py ROOT BUILD
"""
import os
import pathlib
import subprocess
import sys
import tempfile

FOREIGN = ("tbb", "opencv", "openvdb", "libav", "matroska", "ebml")


def run(*words, **more):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))} failed with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def raw(picture, into):
    run("ffmpeg", "-v", "error", "-y", "-i", picture, "-f", "rawvideo", "-pix_fmt", "rgba", into)
    return into.read_bytes()


def expect(true, sentence):
    if not true:
        sys.exit(sentence)


def check_library(prefix):
    library = prefix / "lib/libkinora_player.so"
    needed = [line for line in run("readelf", "-d", library).splitlines() if "NEEDED" in line]
    for line in needed:
        expect(not any(name in line.lower() for name in FOREIGN), f"the player's library needs what a player does not: {line}")
    size = library.stat().st_size
    expect(size <= 3_000_000, f"the player's library has {size} bytes; 3 MB are allowed")
    exported = run("nm", "-D", "--defined-only", library).split("\n")
    for line in filter(None, exported):
        expect("kinora_player_" in line, f"the player's library exports what is not in player.h: {line}")


def check_examples(prefix, folder, clip):
    examples = folder / "examples"
    run("cmake", "-S", folder / "source", "-B", examples, f"-DCMAKE_PREFIX_PATH={prefix}")
    run("cmake", "--build", examples)
    said = run(examples / "01_open_and_render", clip, folder / "example.pam")
    expect("3 frames" in said and "layer background: still" in said, f"01_open_and_render said: {said}")
    run(prefix / "bin/kinora", "render", clip, folder / "render.png", "--frames", "1:2")
    same = raw(folder / "example.pam", folder / "a.raw") == raw(folder / "render.png", folder / "b.raw")
    expect(same, "01_open_and_render draws another picture than kinora render")
    said = run(examples / "02_stream", clip)
    expect(said.count("picture") == 4 and said.rstrip().endswith("full"), f"02_stream said: {said}")
    expect("the last of frame 2" in run(examples / "03_from_c", clip), "03_from_c did not play to the end")
    said = run(examples / "04_follow", clip)
    expect("3 layers, 3 frames" in said and said.endswith("complete\n"), f"04_follow said: {said}")
    cut = folder / "cut.mkv"
    cut.write_bytes(clip.read_bytes()[:clip.stat().st_size * 7 // 8])
    said = run(examples / "04_follow", cut)
    expect("complete: " in said and "missing" in said, f"04_follow said of a clip that is cut short: {said}")
    missing = subprocess.run([examples / "03_from_c", folder / "none.mkv"], capture_output=True, text=True, check=False)
    expect(missing.returncode == 1 and "none.mkv does not exist" in missing.stderr, missing.stderr)


def check_pkg_config(prefix, folder, clip):
    environment = os.environ | {"PKG_CONFIG_PATH": str(prefix / "lib/pkgconfig")}
    flags = run("pkg-config", "--cflags", "--libs", "kinora-player", env=environment).split()
    program = folder / "plain_c"
    run("cc", "-std=c99", "-pedantic-errors", "-Wall", "-Werror", folder / "source/03_from_c.c", "-o", program, *flags)
    run(program, clip, env=os.environ | {"LD_LIBRARY_PATH": str(prefix / "lib")})


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    root, build = map(pathlib.Path, sys.argv[1:])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prefix = folder / "installed"
        run("cmake", "--install", build, "--prefix", prefix)
        run("cp", "-r", root / "samples/player", folder / "source")
        clip = folder / "clip.mkv"
        run(prefix / "bin/kinora", "encode", root / "samples/carry_box", clip, "--preset", "fast", "--frames", "0:3", "-q")
        check_library(prefix)
        check_examples(prefix, folder, clip)
        check_pkg_config(prefix, folder, clip)


if __name__ == "__main__":
    main()
