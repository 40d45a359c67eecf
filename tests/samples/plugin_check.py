#!/usr/bin/env python3
"""Builds samples/plugin as its author would, outside of the tree and against an installed Kinora, and uses it.

usage: plugin_check.py ROOT BUILD
"""
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile


def run(*words, **more):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def write_capture(path, frames):
    pixels = 16 * 12
    with open(path, "wb") as file:
        file.write(b"RAWDEPTH" + struct.pack("<IIIf", 16, 12, frames, 20.0))
        for frame in range(frames):
            file.write(bytes([100 + frame]) * pixels + struct.pack("<H", 1500) * pixels)


def build_with_cmake(sample, prefix, build):
    run("cmake", "-S", sample, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_INSTALL_PREFIX={prefix}")
    run("cmake", "--build", build)
    run("cmake", "--install", build)


def build_with_pkg_config(sample, prefix, folder):
    environment = dict(os.environ, PKG_CONFIG_PATH=str(prefix / "lib/pkgconfig"))
    flags = run("pkg-config", "--cflags", "kinora-plugin", env=environment).split()
    folder.mkdir(parents=True)
    run("cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", *flags, sample / "raw_depth.c",
        "-o", folder / "raw_depth.so")
    shutil.copy(sample / "plugin.json", folder)


def check_use(kinora, capture, *more):
    answer = json.loads(run(kinora, "probe", capture, "--json", *more))
    best = answer["formats"][0]
    if (best["name"], best["confidence"], answer["problem"]) != ("raw-depth", 100, None):
        sys.exit(f"the sample's file is not recognised: {answer}")
    if "raw-depth" not in run(kinora, "formats", *more):
        sys.exit("kinora formats does not list the sample")
    if json.loads(run(kinora, "info", capture, "--json", *more)).get("frames") != 3:
        sys.exit("kinora info does not read the sample's file")


def check_missing(kinora, sample, capture, folder):
    """With its plugin.json alone, the error names what to install."""
    folder.mkdir(parents=True)
    shutil.copy(sample / "plugin.json", folder)
    for command in ("probe", "info"):
        done = subprocess.run([kinora, command, capture, "--plugin-dir", folder.parent], capture_output=True, text=True)
        if done.returncode != 6 or "could have been read by the format raw-depth" not in done.stderr:
            sys.exit(f"kinora {command} does not say which plugin is missing: {done.returncode} {done.stderr}")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        prefix = folder / "prefix"
        run("cmake", "--install", sys.argv[2], "--prefix", prefix)
        sample = folder / "sample"
        shutil.copytree(pathlib.Path(sys.argv[1]) / "samples/plugin", sample)
        write_capture(folder / "a.raw", 3)
        check_missing(prefix / "bin/kinora", sample, folder / "a.raw", folder / "absent/raw_depth")
        build_with_pkg_config(sample, prefix, folder / "mine/raw_depth")
        check_use(prefix / "bin/kinora", folder / "a.raw", "--plugin-dir", folder / "mine")
        build_with_cmake(sample, prefix, folder / "build")
        check_use(prefix / "bin/kinora", folder / "a.raw")


if __name__ == "__main__":
    main()
