#!/usr/bin/env python3
"""Builds samples/plugin and samples/camera_plugin as their authors would, outside of the tree and against an installed
Kinora, and uses them; of the cameras the simulated one, the others are compiled against stubs of their SDKs.

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


def build_with_cmake(sample, prefix, build, *more):
    run("cmake", "-S", sample, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_INSTALL_PREFIX={prefix}", *more)
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
    options = [f["options"] for f in json.loads(run(kinora, "formats", "--json", *more))["formats"] if f["name"] == "raw-depth"]
    if [(o["name"], o["type"], o["default"]) for o in options[0]] != [("fps", "number", "30")]:
        sys.exit(f"kinora formats does not tell the sample's option: {options}")
    if json.loads(run(kinora, "info", capture, "--json", "-O", "fps=12", *more)).get("frames_per_second") != 12:
        sys.exit("the sample is not given its option")
    expect_refusal(2, "type number", kinora, "info", capture, "-O", "fps=fast", *more)


def check_missing(kinora, sample, capture, folder):
    """With its plugin.json alone, the error names what to install."""
    folder.mkdir(parents=True)
    shutil.copy(sample / "plugin.json", folder)
    for command in ("probe", "info"):
        done = subprocess.run([kinora, command, capture, "--plugin-dir", folder.parent], capture_output=True, text=True)
        if done.returncode != 6 or "could have been read by the format raw-depth" not in done.stderr:
            sys.exit(f"kinora {command} does not say which plugin is missing: {done.returncode} {done.stderr}")


def expect_refusal(code, sentence, *words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != code or sentence not in done.stderr:
        sys.exit(f"{' '.join(map(str, words))}: exit code {done.returncode}, not {code}: {done.stderr}")


def check_cameras(root, prefix, folder):
    sample = folder / "camera"
    shutil.copytree(root / "samples/camera_plugin", sample)
    for sdk in ("realsense", "k4a"):
        run("cc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-I", prefix / "include",
            "-I", root / "tests/samples/sdk_stubs", sample / f"{sdk}.c")
    build_with_cmake(sample, prefix, folder / "camera_build", "-DCAMERA=simulated")
    kinora = prefix / "bin/kinora"
    run(kinora, "record", "simulated:0", folder / "live.mkv", "-O", "seconds=0.11")
    if json.loads(run(kinora, "info", folder / "live.mkv", "--json"))["frames"] != 4:
        sys.exit("the simulated camera was not recorded for as long as it was asked for")
    expect_refusal(1, "is complete up to there", kinora, "record", "simulated:0", folder / "silent.mkv")
    expect_refusal(6, "there is no such camera", kinora, "record", "simulated:7", folder / "none.mkv")


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
        check_cameras(pathlib.Path(sys.argv[1]), prefix, folder)


if __name__ == "__main__":
    main()
