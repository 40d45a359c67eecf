#include "rgbd_folder/listing.h"

#include <map>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/numbering.h"
#include "core/error.h"
#include "formats/sample_capture.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

int confidence_of(void (*probe)(const char*, KinoraProbe*), const fs::path& path) {
  KinoraProbe answer{};
  probe(path.c_str(), &answer);
  EXPECT_NE(answer.reason[0], '\0');
  return answer.confidence;
}

TEST(NumberInName, TakesTheNumberThatCountsFrames) {
  EXPECT_EQ(number_in_name("000012"), 12);
  EXPECT_EQ(number_in_name("color_000012"), 12);
  EXPECT_EQ(number_in_name("000012_shirt2"), 12);
  EXPECT_EQ(number_in_name("cam2_000012"), 12);
  EXPECT_EQ(number_in_name("frame-000012.color"), 12);
  EXPECT_EQ(number_in_name("thumbs"), std::nullopt);
  EXPECT_EQ(number_in_name("1234567890123456789"), std::nullopt);
}

TEST(Listing, EachLayoutIsSureOfItsOwnFolderAndOfNoOther) {
  const TemporaryFolder numbered, tum, match, none;
  write_numbered(numbered, 2);
  write_tum(tum, 2);
  write_3dmatch(match, 2);
  EXPECT_GE(confidence_of(probe_numbered, numbered.path()), 50);
  EXPECT_GE(confidence_of(probe_tum, tum.path()), 50);
  EXPECT_GE(confidence_of(probe_3dmatch, match.path()), 50);
  EXPECT_EQ(confidence_of(probe_tum, numbered.path()), 0);
  EXPECT_EQ(confidence_of(probe_3dmatch, numbered.path()), 0);
  EXPECT_EQ(confidence_of(probe_numbered, match.path()), 0);
  EXPECT_GT(confidence_of(probe_tum, tum.path()), confidence_of(probe_numbered, tum.path()));
  for (const auto probe : {probe_numbered, probe_tum, probe_3dmatch}) {
    EXPECT_EQ(confidence_of(probe, none.path()), 0);
    EXPECT_EQ(confidence_of(probe, none.path() / "absent"), 0);
    EXPECT_EQ(confidence_of(probe, tum.path() / "rgb.txt"), 0);
  }
}

TEST(Listing, NumberedFramesKeepTheirDistanceInTime) {
  const TemporaryFolder folder;
  write_numbered(folder, 2);
  folder.write("color/000060.png", color_bytes(3));
  folder.write("depth/000060.png", depth_bytes(3));
  const Listing listing = list_numbered(folder.path());
  ASSERT_EQ(listing.frames.size(), 3U);
  EXPECT_DOUBLE_EQ(listing.frames[2].time, 2.0);
}

constexpr const char* kOpen3dLog =
    "# of two frames\n0 0 1\n1.00000000 0.00000000 0.00000000 0.00000000\n0 1 0 0\n0 0 1 0\n"
    "0 0 0 1\n1 1 2\n0.6 0 0.8 0.5\n0 1 0 -0.25\n-0.8 0 0.6 2\n0 0 0 1\n";

TEST(Listing, Open3dsTrajectoryHasAPoseForEachNumberedFrame) {
  const TemporaryFolder folder;
  write_numbered(folder, 2);
  for (const char* name : {"scene/trajectory.log", "trajectory.log"}) {
    folder.write(name, kOpen3dLog);
    const Listing listing = list_numbered(folder.path());
    EXPECT_TRUE(listing.has_poses);
    EXPECT_TRUE(listing.warnings.empty());
    EXPECT_TRUE(listing.frames[0].camera_to_world.value().isApprox(SE3::Identity()));
    const SE3 second = listing.frames[1].camera_to_world.value();
    EXPECT_TRUE(second.translation().isApprox(Eigen::Vector3d(0.5, -0.25, 2)));
    EXPECT_TRUE((second.linear() * Eigen::Vector3d::UnitZ()).isApprox(Eigen::Vector3d(0.8, 0, 0.6)));
  }
}

TEST(Listing, Open3dsTrajectoryOfOtherFramesIsNotUsed) {
  const TemporaryFolder folder;
  write_numbered(folder, 3);
  folder.write("trajectory.log", kOpen3dLog);
  const Listing listing = list_numbered(folder.path());
  EXPECT_FALSE(listing.has_poses);
  ASSERT_EQ(listing.warnings.size(), 1U);
  EXPECT_NE(listing.warnings[0].find("has 2 poses for 3 frames"), std::string::npos) << listing.warnings[0];
  for (const char* damaged : {"0 0 1 1 0 0 0", "0 0 1\n1 0 0 x\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
                              "0 0 1\n2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"}) {
    folder.write("trajectory.log", damaged);
    EXPECT_THROW((void)list_numbered(folder.path()), Error) << damaged;
  }
}

TEST(Listing, NumberedFramesWithoutPartnerAreListedWithTheReason) {
  const TemporaryFolder folder;
  write_numbered(folder, 4);
  folder.remove("color/000001.png");
  folder.remove("depth/000002.png");
  const Listing listing = list_numbered(folder.path());
  ASSERT_EQ(listing.frames.size(), 4U);
  EXPECT_TRUE(listing.frames[0].problem.empty());
  EXPECT_NE(listing.frames[1].problem.find("no colour image"), std::string::npos);
  EXPECT_NE(listing.frames[2].problem.find("no depth image"), std::string::npos);
}

TEST(Listing, FoldersOfColorMayHaveAnyOfTheUsualNames) {
  for (const char* name : {"color", "rgb", "colour", "image", "images"}) {
    const TemporaryFolder folder;
    write_numbered(folder, 1);
    fs::rename(folder.path() / "color", folder.path() / "moved");
    fs::rename(folder.path() / "moved", folder.path() / name);
    EXPECT_EQ(list_numbered(folder.path()).frames.size(), 1U) << name;
  }
}

TEST(Listing, MasksOfSeveralThingsBelongToOneFrame) {
  const TemporaryFolder folder;
  write_numbered(folder, 2);
  folder.write("mask/000001_shirt.png", encode_png(sample_color(16, 12, 1)));
  folder.write("mask/000001_ball.png", encode_png(sample_color(16, 12, 1)));
  const Listing listing = list_numbered(folder.path());
  EXPECT_TRUE(listing.frames[0].masks.empty());
  EXPECT_EQ(listing.frames[1].masks.size(), 2U);
}

TEST(Listing, TumPairsAreNearestInTimeAndUseEachDepthOnce) {
  const TemporaryFolder folder;
  folder.write("intrinsics.json", kSampleIntrinsics);
  folder.write("rgb.txt", "1.000 rgb/a.png\n1.010 rgb/b.png\n1.100 rgb/c.png\n1.200 rgb/d.png\n");
  folder.write("depth.txt", "1.008 depth/x.png\n1.115 depth/y.png\n1.221 depth/z.png\n");
  const Listing listing = list_tum(folder.path());
  ASSERT_EQ(listing.frames.size(), 4U);
  EXPECT_NE(listing.frames[0].problem.find("no depth image within 20 ms"), std::string::npos);
  EXPECT_EQ(listing.frames[1].depth.filename(), "x.png");
  EXPECT_EQ(listing.frames[2].depth.filename(), "y.png");
  EXPECT_FALSE(listing.frames[3].problem.empty());
}

TEST(Listing, TumFramesOutOfOrderAreTakenInOrderOfTimeWithAWarning) {
  const TemporaryFolder folder;
  folder.write("intrinsics.json", kSampleIntrinsics);
  folder.write("associations.txt", "2.0 rgb/b.png 2.0 depth/b.png\n1.0 rgb/a.png 1.0 depth/a.png\n"
                                   "2.0 rgb/c.png 2.0 depth/c.png\n");
  const Listing listing = list_tum(folder.path());
  ASSERT_EQ(listing.frames.size(), 2U);
  EXPECT_EQ(listing.frames[0].color.filename(), "a.png");
  EXPECT_EQ(listing.frames[1].color.filename(), "b.png");
  ASSERT_EQ(listing.warnings.size(), 2U);
  EXPECT_NE(listing.warnings[0].find("out of order"), std::string::npos);
  EXPECT_NE(listing.warnings[1].find("repeat"), std::string::npos);
}

TEST(Listing, AssociationsMayNameDepthFirst) {
  const TemporaryFolder folder;
  folder.write("intrinsics.json", kSampleIntrinsics);
  folder.write("associations.txt", "1.01 depth/a.png 1.0 rgb/a.png\n");
  const Listing listing = list_tum(folder.path());
  EXPECT_EQ(listing.frames.at(0).color, folder.path() / "rgb/a.png");
  EXPECT_EQ(listing.frames.at(0).time, 1.0);
}

TEST(Listing, TumLinesThatAreNoneAreLeftOutWithTheirNumber) {
  const TemporaryFolder folder;
  folder.write("intrinsics.json", kSampleIntrinsics);
  folder.write("rgb.txt", "# list\nnan rgb/a.png\n1.0 rgb/b.png\n2.0\n");
  folder.write("depth.txt", "1.0 depth/b.png\n");
  const Listing listing = list_tum(folder.path());
  EXPECT_EQ(listing.frames.size(), 1U);
  ASSERT_EQ(listing.warnings.size(), 1U);
  EXPECT_NE(listing.warnings[0].find("rgb.txt, line 2 and 1 more: left out"), std::string::npos);
}

/// Pairs as the definition says: of all pairs within 20 ms the closest first, each image once.
std::map<std::size_t, std::size_t> closest_pairs(const std::vector<double>& colors, const std::vector<double>& depths) {
  std::map<std::size_t, std::size_t> pairs;
  std::set<std::size_t> used;
  while (true) {
    std::tuple<double, std::size_t, std::size_t> best{0.02, 0, 0};
    bool found = false;
    for (std::size_t c = 0; c < colors.size(); ++c) {
      if (pairs.contains(c)) continue;
      for (std::size_t d = 0; d < depths.size(); ++d) {
        if (used.contains(d) || std::abs(colors[c] - depths[d]) >= std::get<0>(best)) continue;
        best = {std::abs(colors[c] - depths[d]), c, d};
        found = true;
      }
    }
    if (!found) return pairs;
    pairs[std::get<1>(best)] = std::get<2>(best);
    used.insert(std::get<2>(best));
  }
}

TEST(Listing, TumPairsAreThoseOfTheDefinitionForAnyTimes) {
  const TemporaryFolder folder;
  folder.write("intrinsics.json", kSampleIntrinsics);
  for (std::uint64_t round = 0; round < 50; ++round) {
    Random random(3, round);
    std::vector<double> times[2];
    for (auto& list : times) {
      for (std::uint32_t count = 1 + random.below(12); count > 0; --count) list.push_back(random.below(100'000) * 1e-6);
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
      std::string text;
      for (std::size_t i = 0; i < list.size(); ++i) text += fmt::format("{:.6f} images/{}.png\n", list[i], i);
      folder.write(&list == times ? "rgb.txt" : "depth.txt", text);
    }
    const auto expected = closest_pairs(times[0], times[1]);
    const Listing listing = list_tum(folder.path());
    ASSERT_EQ(listing.frames.size(), times[0].size());
    for (std::size_t c = 0; c < listing.frames.size(); ++c) {
      const auto pair = expected.find(c);
      EXPECT_EQ(listing.frames[c].depth.filename(), pair == expected.end() ? "" : fmt::format("{}.png", pair->second))
          << "round " << round << ", colour " << c;
    }
  }
}

TEST(Listing, ListsOfOneInstantTakeMemoryThatGrowsAsTheyDo) {
  const TemporaryFolder folder;
  folder.write("intrinsics.json", kSampleIntrinsics);
  std::string lists[2];
  constexpr int kCount = 30'000; // all within 20 ms: 900 million pairs to choose from
  for (int i = 0; i < kCount; ++i) {
    lists[0] += fmt::format("{:.7f} a{}\n", i * 5e-7, i);
    lists[1] += fmt::format("{:.7f} b{}\n", i * 5e-7 + 1e-7, i);
  }
  folder.write("rgb.txt", lists[0]);
  folder.write("depth.txt", lists[1]);
  const Listing listing = list_tum(folder.path());
  ASSERT_EQ(listing.frames.size(), static_cast<std::size_t>(kCount));
  EXPECT_EQ(listing.frames[777].depth.filename(), "b777");
}

TEST(Listing, ManyLinesThatAreNoneAreOneWarning) {
  const TemporaryFolder folder;
  write_tum(folder, 2);
  std::string noise;
  for (int i = 0; i < 100'000; ++i) noise += "x\n";
  folder.write("associations.txt", noise);
  const Listing listing = list_tum(folder.path());
  EXPECT_EQ(listing.frames.size(), 2U);
  EXPECT_EQ(listing.warnings.size(), 2U); // the lines, and that rgb.txt and depth.txt are used instead
}

TEST(Listing, TumDepthUnitIsAFiveThousandthUnlessTheCaptureSaysOtherwise) {
  const TemporaryFolder folder;
  write_tum(folder, 2);
  EXPECT_DOUBLE_EQ(list_tum(folder.path()).calibration.depth_unit.value(), 0.001);
  folder.remove("intrinsics.json");
  folder.write("intrinsics.txt", "20 0 7.5 0 20 5.5 0 0 1");
  EXPECT_DOUBLE_EQ(list_tum(folder.path()).calibration.depth_unit.value(), 0.0002);
}

TEST(Listing, TumPosesBelongToFramesByTimeAndFramesWithoutOneCannotBeUsed) {
  const TemporaryFolder folder;
  write_tum(folder, 4);
  folder.write("groundtruth.txt",
               "# t x y z qx qy qz qw\n100.000 0 0 0 0 0 0 1\n100.050 1 0 0 0 0 0 1\n100.110 2 0 0 0 0 0 1\n"
               "99.9 9 0 0 0 0 0 1\n");
  const Listing listing = list_tum(folder.path());
  EXPECT_TRUE(listing.has_poses);
  EXPECT_NEAR(listing.frames[1].camera_to_world->translation().x(), 2.0 / 3, 1e-4);
  EXPECT_TRUE(listing.frames[3].camera_to_world);
  folder.write("groundtruth.txt", "100.000 0 0 0 0 0 0 1\n100.033 1 0 0 0 0 0 1\n");
  const Listing half = list_tum(folder.path());
  EXPECT_TRUE(half.has_poses);
  EXPECT_NE(half.frames[3].problem.find("no pose"), std::string::npos);
}

TEST(Listing, TumPosesOfFewFramesAreNotUsedAtAll) {
  const TemporaryFolder folder;
  write_tum(folder, 4);
  folder.write("groundtruth.txt", "100.000 0 0 0 0 0 0 1\n");
  const Listing listing = list_tum(folder.path());
  EXPECT_FALSE(listing.has_poses);
  EXPECT_TRUE(listing.frames[3].problem.empty());
  ASSERT_EQ(listing.warnings.size(), 1U);
  EXPECT_NE(listing.warnings[0].find("no pose is used"), std::string::npos);
}

TEST(Listing, MatchFramesAreFoundOneFolderBelowWithIntrinsicsAbove) {
  const TemporaryFolder folder;
  write_3dmatch(folder, 3);
  const Listing above = list_3dmatch(folder.path());
  const Listing inside = list_3dmatch(folder.path() / "frames");
  EXPECT_EQ(above.frames.size(), 3U);
  EXPECT_EQ(inside.frames.size(), 3U);
  EXPECT_EQ(inside.calibration.intrinsics.fx, 20);
  EXPECT_TRUE(above.has_poses);
  EXPECT_NEAR(above.frames[2].time, 2 / 30.0, 1e-9);
}

TEST(Listing, MatchFramesWithoutPartnerAreListedWithTheReason) {
  const TemporaryFolder folder;
  write_3dmatch(folder, 4);
  folder.remove("frames/frame-000150.color.png");
  folder.remove("frames/frame-000151.depth.png");
  folder.remove("frames/frame-000152.pose.txt");
  const Listing listing = list_3dmatch(folder.path());
  ASSERT_EQ(listing.frames.size(), 4U);
  EXPECT_NE(listing.frames[0].problem.find("no colour image"), std::string::npos);
  EXPECT_NE(listing.frames[1].problem.find("no depth image"), std::string::npos);
  EXPECT_NE(listing.frames[2].problem.find("no .pose.txt"), std::string::npos);
  EXPECT_TRUE(listing.frames[3].problem.empty());
}

TEST(Listing, MatchFoldersWithoutAnyPoseHaveNone) {
  const TemporaryFolder folder;
  write_3dmatch(folder, 2);
  for (const char* number : {"150", "151"}) folder.remove(std::string("frames/frame-000") + number + ".pose.txt");
  const Listing listing = list_3dmatch(folder.path());
  EXPECT_FALSE(listing.has_poses);
  EXPECT_TRUE(listing.frames[0].problem.empty());
}

TEST(Listing, SecondImagesOfANumberAreLeftOutWithAWarning) {
  const TemporaryFolder folder;
  write_numbered(folder, 2);
  folder.write("color/1.png", color_bytes(0));
  const Listing listing = list_numbered(folder.path());
  EXPECT_EQ(listing.frames.size(), 2U);
  ASSERT_EQ(listing.warnings.size(), 1U);
  EXPECT_NE(listing.warnings[0].find("same number"), std::string::npos);
}

} // namespace
} // namespace kinora::formats
