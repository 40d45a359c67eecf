#!/usr/bin/env python3
"""Makes the ROS 1 bags of this folder with ROS's own writer (Debian: python3-rosbag python3-sensor-msgs python3-tf2-msgs).

usage: make_bags.py FOLDER
"""
import binascii
import pathlib
import struct
import sys
import zlib

import genpy
import rosbag
from geometry_msgs.msg import Transform, TransformStamped
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Float32
from tf2_msgs.msg import TFMessage

WIDTH, HEIGHT, FRAMES = 16, 12, 3


def color(frame):
    return bytes((7 * u + 13 * v + 50 * c + 11 * frame) % 256
                 for v in range(HEIGHT) for u in range(WIDTH) for c in range(3))


def depth(frame):
    return [0 if (u + v + frame) % 7 == 0 else 1000 + 10 * u + 3 * v + 100 * frame
            for v in range(HEIGHT) for u in range(WIDTH)]


def png(bits, kind, rows):
    """A PNG without filters; `rows` are bytes, 16-bit values big-endian."""
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", binascii.crc32(name + data))
    head = struct.pack(">IIBBBBB", WIDTH, HEIGHT, bits, kind, 0, 0, 0)
    packed = zlib.compress(b"".join(b"\0" + row for row in rows))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


def image(frame, encoding, data, step, frame_id, late=0.0):
    message = Image(height=HEIGHT, width=WIDTH, encoding=encoding, step=step, data=data)
    message.header.stamp = genpy.Time.from_sec(1600000000.25 + frame / 32 + late)
    message.header.frame_id = frame_id
    return message


def camera(frame_id, fx=20.0):
    message = CameraInfo(height=HEIGHT, width=WIDTH, distortion_model="plumb_bob", D=[0.1, -0.2, 0.001, 0.002, 0.05],
                         K=[fx, 0, 7.5, 0, 21.0, 5.5, 0, 0, 1])
    message.header.frame_id = frame_id
    return message


def times(frame):
    return genpy.Time.from_sec(1600000100.0 + frame / 32)


def aligned(path):
    with rosbag.Bag(path, "w", compression="lz4") as bag:
        for i in range(FRAMES):
            def write(topic, message):
                bag.write(topic, message, times(i))
            write("/camera/infra1/image_rect_raw", image(i, "mono8", bytes(WIDTH * HEIGHT), WIDTH, "infra1"))
            write("/camera/depth/image_rect_raw", image(i, "16UC1", bytes(2 * WIDTH * HEIGHT), 2 * WIDTH, "depth"))
            write("/camera/color/image_raw", image(i, "rgb8", color(i), 3 * WIDTH, "color"))
            write("/camera/color/camera_info", camera("color"))
            write("/camera/aligned_depth_to_color/image_raw",
                  image(i, "16UC1", struct.pack(f"<{WIDTH * HEIGHT}H", *depth(i)), 2 * WIDTH, "color", 0.004))
            write("/camera/aligned_depth_to_color/camera_info", camera("color"))


def librealsense(path):
    """The topics of a recording of the RealSense SDK."""
    with rosbag.Bag(path, "w") as bag:
        start = times(0)
        bag.write("/device_0/sensor_0/option/Depth_Units/value", Float32(0.00025), start)
        for stream, fx in (("sensor_0/Depth_0", 18.0), ("sensor_1/Color_0", 20.0)):
            bag.write(f"/device_0/{stream}/info/camera_info", camera("0", fx), start)
            transform = Transform()
            transform.rotation.w = 1
            transform.translation.x = 0.015 if "Color" in stream else 0.0
            bag.write(f"/device_0/{stream}/tf/0", transform, start)
        for i in range(FRAMES):
            bag.write("/device_0/sensor_0/Depth_0/image/data",
                      image(i, "mono16", struct.pack(f"<{WIDTH * HEIGHT}H", *depth(i)), 2 * WIDTH, "0"), times(i))
            bag.write("/device_0/sensor_1/Color_0/image/data", image(i, "rgb8", color(i), 3 * WIDTH, "0"), times(i))


def compressed(path):
    """Compressed images of two cameras that a transform relates."""
    with rosbag.Bag(path, "w", compression="bz2") as bag:
        transform = TransformStamped(child_frame_id="depth")
        transform.header.frame_id = "link"
        transform.transform.rotation.w = 1
        transform.transform.translation.x = 0.01
        other = TransformStamped(child_frame_id="color")
        other.header.frame_id = "link"
        other.transform.rotation.w = 1
        other.transform.translation.x = 0.04
        bag.write("/tf_static", TFMessage([transform, other]), times(0))
        for i in range(FRAMES):
            rows = [color(i)[3 * WIDTH * v:3 * WIDTH * (v + 1)] for v in range(HEIGHT)]
            message = CompressedImage(format="rgb8; png compressed ", data=png(8, 2, rows))
            message.header = image(i, "", b"", 0, "color").header
            bag.write("/camera/color/image_raw/compressed", message, times(i))
            values = struct.pack(f">{WIDTH * HEIGHT}H", *depth(i))
            rows = [values[2 * WIDTH * v:2 * WIDTH * (v + 1)] for v in range(HEIGHT)]
            message = CompressedImage(format="16UC1; compressedDepth", data=struct.pack("<Iff", 0, 0, 0) + png(16, 0, rows))
            message.header = image(i, "", b"", 0, "depth").header
            bag.write("/camera/depth/image_raw/compressedDepth", message, times(i))
            bag.write("/camera/color/camera_info", camera("color"), times(i))
            bag.write("/camera/depth/camera_info", camera("depth", 18.0), times(i))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    aligned(folder / "aligned_lz4.bag")
    librealsense(folder / "librealsense.bag")
    compressed(folder / "compressed_bz2.bag")


if __name__ == "__main__":
    main()
