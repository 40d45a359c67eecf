#!/usr/bin/env python3
"""Makes sample.r3d with Apple's LZFSE encoder (the program `lzfse` of github.com/lzfse/lzfse) and ffmpeg.

usage: make_r3d.py LZFSE FOLDER
"""
import json
import pathlib
import struct
import subprocess
import sys
import zipfile

WIDTH, HEIGHT, FRAMES = 64, 48, 3


def depth(frame):
    """Metres as floats: packed in blocks with entropy coding."""
    out = []
    for v in range(HEIGHT):
        for u in range(WIDTH):
            out.append(float("nan") if (u + v + frame) % 7 == 0 else
                       1 + 0.01 * u + 0.003 * v + 0.1 * frame + 0.001 * ((31 * u + 17 * v) % 5))
    return struct.pack(f"<{WIDTH * HEIGHT}f", *out)


def confidence(frame):
    """So few bytes that they are packed with LZVN."""
    return bytes((u // 9 + v // 5 + frame) % 3 for v in range(HEIGHT) for u in range(WIDTH))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)

    def pack(data):
        return subprocess.run([sys.argv[1], "-encode"], input=data, capture_output=True, check=True).stdout
    metadata = {
        "w": 2 * WIDTH, "h": 2 * HEIGHT, "dw": WIDTH, "dh": HEIGHT, "fps": 60,
        "K": [100, 0, 0, 0, 101, 0, 63.5, 47.5, 1],
        "poses": [[0, 0, 0, 1, 0.1 * i, 0, 0] for i in range(FRAMES)],
        "frameTimestamps": [10 + i / 60 for i in range(FRAMES)]}
    with zipfile.ZipFile(pathlib.Path(sys.argv[2]) / "sample.r3d", "w", zipfile.ZIP_DEFLATED) as archive:
        def write(name, data):
            archive.writestr(zipfile.ZipInfo(name), data)
        write("metadata", json.dumps(metadata))
        for i in range(FRAMES):
            jpeg = subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i", f"color=0x{40 * i:02x}8040:s={2 * WIDTH}x{2 * HEIGHT}",
                                   "-frames:v", "1", "-f", "mjpeg", "-"], capture_output=True, check=True).stdout
            write(f"rgbd/{i}.jpg", jpeg)
            write(f"rgbd/{i}.depth", pack(depth(i)))
            write(f"rgbd/{i}.conf", pack(confidence(i)))


if __name__ == "__main__":
    main()
