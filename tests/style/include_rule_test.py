#!/usr/bin/env python3
"""Plants includes in a small tree and checks that include_rule.py allows or reports each."""
import pathlib
import tempfile
import unittest

from include_rule import violations

TREE = [
    "src/core/image.h", "src/host/plugin_table.h", "src/ingest/frame.h", "src/tracking/motion.h",
    "src/fields/field.h", "src/encode/clip.h", "src/player/player.h", "src/bake/surface.h", "src/cli/info.h",
    "include/kinora/plugin.h", "formats/png/png.h", "formats/mp4/mp4.h", "formats/common/files.h",
]


class IncludeRule(unittest.TestCase):
    def violations_of(self, path, include):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            for name in TREE:
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text("#pragma once\n#include <vector>\n")
            (root / path).write_text(f"// a comment first\n#include {include}\n")
            return violations(root)

    def test_allows_rooms_to_the_left(self):
        for path, include in [
            ("src/tracking/icp.cpp", '"core/image.h"'),
            ("src/tracking/icp.cpp", '"tracking/motion.h"'),
            ("src/cli/encode.cpp", '"player/player.h"'),
            ("src/cli/convert.cpp", '"bake/surface.h"'),
            ("src/bake/surface.cpp", '"encode/clip.h"'),
            ("src/host/loader.cpp", '"kinora/plugin.h"'),
            ("formats/png/reader.cpp", '"png.h"'),
            ("formats/png/reader.cpp", '"core/image.h"'),
            ("formats/png/reader.cpp", '"common/files.h"'),
            ("formats/table.cpp", '"png/png.h"'),
            ("formats/png/reader.cpp", '<kinora/plugin.h>'),
            ("src/core/parallel.cpp", "<oneapi/tbb/parallel_for.h>"),
            ("src/fields/render_simd.cpp", "<hwy/highway.h>"),
            ("src/fields/render.cpp", "<Eigen/Core>"),
        ]:
            self.assertEqual(self.violations_of(path, include), [], f"{path} includes {include}")

    def test_reports_every_forbidden_direction(self):
        for path, include in [
            ("src/core/image.cpp", '"ingest/frame.h"'),
            ("src/core/image.cpp", '"kinora/plugin.h"'),
            ("src/tracking/icp.cpp", '"fields/field.h"'),
            ("src/tracking/icp.cpp", '"../fields/field.h"'),
            ("src/ingest/reader.cpp", "<encode/clip.h>"),
            ("src/player/player.cpp", '"cli/info.h"'),
            ("src/bake/surface.cpp", '"player/player.h"'),
            ("src/player/player.cpp", '"bake/surface.h"'),
            ("src/host/table.cpp", '"formats/png/png.h"'),
            ("formats/png/reader.cpp", '"ingest/frame.h"'),
            ("formats/png/reader.cpp", '"../mp4/mp4.h"'),
            ("formats/common/files.cpp", '"png/png.h"'),
            ("formats/table.cpp", '"ingest/frame.h"'),
            ("include/kinora/player.h", '"core/image.h"'),
            ("src/tracking/icp.cpp", '"no/such/file.h"'),
            ("src/tracking/icp.cpp", "<tbb/parallel_for.h>"),
            ("src/fields/render.cpp", "<hwy/highway.h>"),
        ]:
            found = self.violations_of(path, include)
            self.assertEqual(len(found), 1, f"{path} includes {include}: {found}")
            self.assertIn(f"{path}:2:", found[0])


if __name__ == "__main__":
    unittest.main()
