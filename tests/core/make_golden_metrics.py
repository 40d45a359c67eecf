#!/usr/bin/env python3
"""Makes golden_metrics.h: what the reference script of the image metrics says about pictures made by a formula.

usage: make_golden_metrics.py REFERENCE.py | clang-format-14 > golden_metrics.h   (Debian: python3-opencv, python3-numpy)

REFERENCE.py is a file with compare(render, truth, mask) -> dict of the fields of kinora::ImageMetrics.
pictures() is the twin of the one in metrics_test.cpp: change both or neither.
"""
import importlib.util
import sys

import numpy as np

# name, width, height, channels of the render, mask, noise added to the render, alpha
CASES = [
    ("rgba_with_mask", 64, 48, 4, "disc", 8, "mixed"),
    ("rgba_without_mask", 64, 48, 4, "none", 8, "mixed"),
    ("rgb_with_mask", 64, 48, 3, "disc", 20, "mixed"),
    ("rgb_without_mask", 64, 48, 3, "none", 60, "mixed"),
    ("box_cut_by_the_border", 33, 21, 4, "corner", 8, "mixed"),
    ("tiny_rgba_with_mask", 5, 4, 4, "disc", 8, "mixed"),
    ("tiny_rgba_without_mask", 5, 4, 4, "none", 8, "mixed"),
    ("tiny_rgb_without_mask", 5, 4, 3, "none", 8, "mixed"),
    ("three_rows", 40, 3, 4, "disc", 8, "mixed"),
    ("identical_without_mask", 24, 24, 3, "none", 0, "mixed"),
    ("identical_inside_mask", 24, 24, 4, "disc", 0, "as_mask"),
    ("nothing_drawn", 24, 24, 4, "disc", 8, "half"),
]


def noise(seed, i):
    x = (i * 747796405 + seed * 2891336453) % 2**32
    x ^= x >> 16
    x = x * 2246822519 % 2**32
    x ^= x >> 13
    return x >> 24


def pictures(width, height, channels, mask_kind, amplitude, alpha_kind):
    """render HxWx3|4, truth HxWx3, mask HxW; all uint8"""
    render = np.zeros((height, width, channels), np.uint8)
    truth = np.zeros((height, width, 3), np.uint8)
    mask = np.zeros((height, width), np.uint8)
    for v in range(height):
        for u in range(width):
            i = v * width + u
            dx, dy = 2 * u - width, 2 * v - height
            if mask_kind == "disc":
                mask[v, u] = 2 if 4 * (dx * dx + dy * dy) < (width * width + height * height) // 2 else 0
            else:
                mask[v, u] = 1 if u + v < 4 else 0
            for c in range(3):
                value = (u * 5 + v * 3 + c * 40 + noise(1 + c, i) % 32) % 256
                truth[v, u, c] = value
                render[v, u, c] = min(max(value + noise(5 + c, i) % (2 * amplitude + 1) - amplitude, 0), 255)
            if channels == 4:
                if alpha_kind == "mixed":
                    render[v, u, 3] = (0, 127, 128, 255, noise(9, i))[noise(8, i) % 5]
                elif alpha_kind == "as_mask":
                    render[v, u, 3] = 255 if mask[v, u] else 0
                else:
                    render[v, u, 3] = 127
    return render, truth, mask


def main():
    spec = importlib.util.spec_from_file_location("reference", sys.argv[1])
    reference = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reference)
    fields = ["psnr_box", "ssim_box", "psnr_full", "ssim_full", "psnr_inside", "mae_box", "iou"]
    print("// Made by make_golden_metrics.py from the reference script of the image metrics: do not edit.")
    print("#pragma once\n")
    print('#include "core/metrics.h"\n')
    print("namespace kinora {\n")
    print("struct GoldenMetrics {")
    print("const char* name; int width; int height; int channels; const char* mask; int amplitude; const char* alpha;")
    print("ImageMetrics expected;};\n")
    print("// clang-format off")
    print("constexpr GoldenMetrics kGoldenMetrics[] = {")
    for name, width, height, channels, mask_kind, amplitude, alpha_kind in CASES:
        render, truth, mask = pictures(width, height, channels, mask_kind, amplitude, alpha_kind)
        result = reference.compare(render, truth, None if mask_kind == "none" else mask)
        numbers = ", ".join(f"{result[f]:.6f}" for f in fields)
        print(f'    {{"{name}", {width}, {height}, {channels}, "{mask_kind}", {amplitude}, "{alpha_kind}",')
        print(f"     {{{numbers}}}}},")
    print("};")
    print("// clang-format on\n")
    print("} // namespace kinora")


if __name__ == "__main__":
    main()
