#!/usr/bin/env python3
"""Plants includes in a small tree and checks that include_rule.py allows or reports each."""
import pathlib
import tempfile
import unittest

from include_rule import LOOK, MAKE, PLAY, RULES, seen_from, violations

TREE = [
    "src/core/image.h", "src/host/plugin_table.h", "src/ingest/frame/frame.h", "src/motion/motion.h",
    "src/motion/skinning/blend.h", "src/tracking/view/projected_layer.h", "src/tracking/rigid/icp.h",
    "src/tracking/solver/pcg.h", "src/tracking/deforming/tracker.h", "src/fields/model/field.h",
    "src/fields/training/trainer.h", "src/fields/rendering/renderer.h", "src/clip/clip.h",
    "src/clip/coding/range_coder.h", "src/encode/pipeline.h", "src/player/player.h", "src/evaluate/ground_truth_comparison.h",
    "src/bake/surface.h", "src/cli/info.h", "include/kinora/plugin.h", "formats/png/png.h", "formats/mp4/mp4.h",
    "formats/common/files.h",
]


class IncludeRule(unittest.TestCase):
    def violations_of(self, path, include):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            for name in TREE:
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text("#pragma once\n#include <vector>\n")
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(f"// a comment first\n#include {include}\n")
            return violations(root)

    def test_allows_what_the_table_gives(self):
        for path, include in [
            ("src/tracking/rigid/icp.cpp", '"core/image.h"'),
            ("src/tracking/rigid/icp.cpp", '"motion/motion.h"'),
            ("src/tracking/deforming/tracker.cpp", '"tracking/rigid/icp.h"'),
            ("src/motion/motion.cpp", '"motion/skinning/blend.h"'),
            ("src/clip/clip.cpp", '"clip/coding/range_coder.h"'),
            ("src/cli/encode.cpp", '"player/player.h"'),
            ("src/cli/convert.cpp", '"bake/surface.h"'),
            ("src/bake/surface.cpp", '"clip/clip.h"'),
            ("src/evaluate/ground_truth_comparison.cpp", '"ingest/frame/frame.h"'),
            ("src/host/loader.cpp", '"kinora/plugin.h"'),
            ("formats/png/reader.cpp", '"png.h"'),
            ("formats/png/reader.cpp", '"core/image.h"'),
            ("formats/png/reader.cpp", '"common/files.h"'),
            ("formats/table.cpp", '"png/png.h"'),
            ("formats/png/reader.cpp", '<kinora/plugin.h>'),
            ("src/core/parallel.cpp", "<oneapi/tbb/parallel_for.h>"),
            ("src/fields/rendering/ray_marching_simd.cpp", "<hwy/highway.h>"),
            ("src/fields/rendering/march.cpp", "<Eigen/Core>"),
        ]:
            self.assertEqual(self.violations_of(path, include), [], f"{path} includes {include}")

    def test_reports_every_forbidden_direction(self):
        for path, include in [
            ("src/core/image.cpp", '"ingest/frame/frame.h"'),
            ("src/core/image.cpp", '"kinora/plugin.h"'),
            ("src/motion/skinning/blend.cpp", '"motion/motion.h"'),
            ("src/motion/motion.cpp", '"tracking/view/projected_layer.h"'),
            ("src/clip/coding/range_coder.cpp", '"clip/clip.h"'),
            ("src/clip/coding/range_coder.cpp", '"fields/model/field.h"'),
            ("src/fields/rendering/renderer.cpp", '"fields/training/trainer.h"'),
            ("src/tracking/rigid/icp.cpp", '"fields/model/field.h"'),
            ("src/tracking/rigid/icp.cpp", '"../solver/pcg.h"'),
            ("src/tracking/view/projected_layer.cpp", '"tracking/deforming/tracker.h"'),
            ("src/ingest/frame/frame.cpp", "<clip/clip.h>"),
            ("src/player/player.cpp", '"cli/info.h"'),
            ("src/player/player.cpp", '"ingest/frame/frame.h"'),
            ("src/player/player.cpp", '"encode/pipeline.h"'),
            ("src/bake/surface.cpp", '"player/player.h"'),
            ("src/encode/pipeline.cpp", '"player/player.h"'),
            ("src/host/table.cpp", '"formats/png/png.h"'),
            ("formats/png/reader.cpp", '"ingest/frame/frame.h"'),
            ("formats/png/reader.cpp", '"../mp4/mp4.h"'),
            ("formats/common/files.cpp", '"png/png.h"'),
            ("formats/table.cpp", '"ingest/frame/frame.h"'),
            ("include/kinora/player.h", '"core/image.h"'),
            ("src/tracking/rigid/icp.cpp", '"no/such/file.h"'),
            ("src/tracking/rigid/icp.cpp", "<tbb/parallel_for.h>"),
            ("src/fields/rendering/march.cpp", "<hwy/highway.h>"),
        ]:
            found = self.violations_of(path, include)
            self.assertEqual(len(found), 1, f"{path} includes {include}: {found}")
            self.assertIn(f"{path}:2:", found[0])

    def test_reports_a_folder_that_is_no_room(self):
        found = self.violations_of("src/tracking/misc/icp.cpp", '"core/image.h"')
        self.assertEqual(len(found), 1)
        self.assertIn("src/tracking/misc/icp.cpp:1: tracking/misc is no room", found[0])

    def test_the_play_wing_sees_nothing_of_the_others(self):
        for room in PLAY:
            self.assertLessEqual(seen_from(room), PLAY.keys() | {"include/kinora"}, room)

    def test_the_make_wing_does_not_look(self):
        for room in MAKE:
            self.assertTrue(seen_from(room).isdisjoint(LOOK), room)

    def test_no_room_sees_itself(self):
        for room in RULES:
            self.assertNotIn(room, seen_from(room))


if __name__ == "__main__":
    unittest.main()
