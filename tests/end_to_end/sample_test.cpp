// The main job on a piece of the sample, as a user runs it: a capture becomes a clip, which is drawn, compared with the
// truth and converted. The bounds lie below what the chain reaches and above what it reaches when the person's tracker
// stands still (18 dB held out, 17 dB from novel cameras) or the trainer stops after a twentieth (15 dB and 15 dB).
// They are those of frames that are tracked: of frames that nothing sees 21.3 dB are reached here, 3 dB below trained
// ones.
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "support/source_folder.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

const Json& named(const Json& list, const std::string& name) {
  for (const Json& entry : list) {
    if (entry.at("name") == name) return entry;
  }
  throw std::runtime_error("no entry named " + name);
}

TEST(Sample, BecomesAClipThatHoldsFromTheSide) {
  const TemporaryFolder folder;
  const std::string sample = (source_folder() / "samples/carry_box").string();
  const std::string clip = (folder.path() / "clip.mkv").string();
  const Said encoded =
      run_kinora(folder, {"encode", sample, clip, "--preset", "fast", "--frames", "0:54:2", "--holdout-tracked", "5"});
  ASSERT_EQ(encoded.code, 0) << encoded.err;

  const Said evaluated = run_kinora(folder, {"eval", clip, "--against", sample, "--json"});
  ASSERT_EQ(evaluated.code, 0) << evaluated.err;
  const Json report = Json::parse(evaluated.out);
  const Json& held_out = report.at("foreground").at("held_out");
  EXPECT_GT(held_out.at("psnr_box").get<double>(), 21.5);
  EXPECT_GT(held_out.at("iou").get<double>(), 0.92);
  EXPECT_LT(std::abs(report.at("foreground").at("trained_minus_held_out_db").get<double>()), 1);
  EXPECT_GT(named(report.at("layers"), "background").at("held_out").at("psnr").get<double>(), 33);
  EXPECT_LT(named(report.at("layers"), "person").at("held_out").at("depth_error_median").get<double>(), 0.012);

  const Json& truth = report.at("ground_truth");
  double psnr = 0;
  double iou = 0;
  for (const Json& camera : truth.at("novel_cameras")) {
    const Json& foreground = named(camera.at("layers"), "foreground");
    psnr += foreground.at("psnr_box").get<double>() / static_cast<double>(truth.at("novel_cameras").size());
    iou += foreground.at("iou").get<double>() / static_cast<double>(truth.at("novel_cameras").size());
  }
  EXPECT_GT(psnr, 19.3);
  EXPECT_GT(iou, 0.86);
  EXPECT_LT(truth.at("object_pose").at("error_m_mean").get<double>(), 0.004);
  // Without any motion the points are 53 mm off.
  EXPECT_LT(truth.at("tracks").at("visible").at("error_m_mean").get<double>(), 0.012);
  EXPECT_EQ(truth.at("tracks").at("visible").at("missing"), 0);

  const std::string mesh = (folder.path() / "clip.glb").string();
  const Said converted = run_kinora(folder, {"convert", clip, mesh, "-O", "triangles=5000"});
  ASSERT_EQ(converted.code, 0) << converted.err;
  EXPECT_EQ(contents_of(mesh).substr(0, 4), "glTF");
}

} // namespace
} // namespace kinora::test
