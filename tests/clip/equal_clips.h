// That two clips are the same to the bit (times to the nanosecond that files keep).
#pragma once

#include <gtest/gtest.h>

#include "clip/clip.h"

namespace kinora::clip::testing {

inline void expect_equal_deformations(const motion::Motion& a, const motion::Motion& b) {
  ASSERT_EQ(a.graph() == nullptr, b.graph() == nullptr);
  if (!a.graph()) return;
  EXPECT_EQ(a.graph()->nodes(), b.graph()->nodes());
  EXPECT_EQ(a.graph()->weight_radius(), b.graph()->weight_radius());
  EXPECT_EQ(a.graph()->influence_radius(), b.graph()->influence_radius());
  ASSERT_EQ(a.deformations().size(), b.deformations().size());
  for (std::size_t f = 0; f < a.deformations().size(); ++f) {
    EXPECT_EQ(a.health(f), b.health(f));
    for (std::size_t i = 0; i < a.graph()->nodes().size(); ++i) {
      const DualQuaternion& x = a.deformations()[f].node_to_world[i];
      const DualQuaternion& y = b.deformations()[f].node_to_world[i];
      EXPECT_EQ(x.real.coeffs(), y.real.coeffs());
      EXPECT_EQ(x.dual.coeffs(), y.dual.coeffs());
    }
  }
}

inline void expect_equal(const Clip& a, const Clip& b) {
  ASSERT_EQ(a.times.size(), b.times.size());
  for (std::size_t i = 0; i < a.times.size(); ++i) EXPECT_NEAR(a.times[i], b.times[i], 0.5e-9 + 1e-15);
  EXPECT_EQ(a.capture_frames, b.capture_frames);
  EXPECT_EQ(a.held_out, b.held_out);
  EXPECT_EQ(a.intrinsics, b.intrinsics);
  EXPECT_EQ(a.metadata, b.metadata);
  ASSERT_EQ(a.camera_to_world.size(), b.camera_to_world.size());
  for (std::size_t i = 0; i < a.camera_to_world.size(); ++i) {
    EXPECT_EQ(a.camera_to_world[i].matrix(), b.camera_to_world[i].matrix());
  }
  ASSERT_EQ(a.layers.size(), b.layers.size());
  for (std::size_t l = 0; l < a.layers.size(); ++l) {
    const Layer& x = a.layers[l];
    const Layer& y = b.layers[l];
    EXPECT_EQ(x.name, y.name);
    EXPECT_EQ(x.label, y.label);
    EXPECT_EQ(x.presence, y.presence);
    EXPECT_EQ(x.births, y.births);
    EXPECT_EQ(x.field.table, y.field.table);
    EXPECT_EQ(x.field.density_net, y.field.density_net);
    EXPECT_EQ(x.field.color_net, y.field.color_net);
    EXPECT_EQ(x.field.occupancy.words(), y.field.occupancy.words());
    ASSERT_EQ(x.confidence.has_value(), y.confidence.has_value());
    if (x.confidence) {
      EXPECT_EQ(x.confidence->levels(), y.confidence->levels());
    }
    ASSERT_EQ(x.joints.has_value(), y.joints.has_value());
    if (x.joints) {
      EXPECT_EQ(x.joints->names, y.joints->names);
      EXPECT_EQ(x.joints->positions, y.joints->positions);
    }
    ASSERT_EQ(x.motion.kind(), y.motion.kind());
    ASSERT_EQ(x.motion.poses().size(), y.motion.poses().size());
    for (std::size_t i = 0; i < x.motion.poses().size(); ++i) {
      EXPECT_EQ(x.motion.poses()[i].canonical_to_world.matrix(), y.motion.poses()[i].canonical_to_world.matrix());
      EXPECT_EQ(x.motion.poses()[i].health, y.motion.poses()[i].health);
    }
    expect_equal_deformations(x.motion, y.motion);
  }
}

} // namespace kinora::clip::testing
