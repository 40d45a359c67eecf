// Short pieces of captures, encoded as a user does it: those that the simulator gave the faults of a sensor (depth in
// steps, flying pixels, lost edges, late colour, exposure that drifts), and real ones where these are there.
#include <nlohmann/json.hpp>

#include "cli/run_kinora.h"
#include "support/source_folder.h"

namespace kinora::test {
namespace {

using Json = nlohmann::json;

struct Piece {
  std::string folder;
  std::string frames;
  std::string part; ///< a layer, or "foreground"
  double psnr;      ///< of that part in held-out frames, dB, less what equal changes spread
};

Json report_of(const fs::path& capture, const Piece& piece) {
  const TemporaryFolder folder;
  const Said encoded = run_kinora(folder, {"encode", capture.string(), (folder.path() / "clip.mkv").string(),
                                           "--preset", "fast", "--frames", piece.frames, "--holdout", "5", "--json"});
  EXPECT_EQ(encoded.code, 0) << encoded.err;
  return encoded.code == 0 ? Json::parse(encoded.out) : Json();
}

/// In held-out frames.
double psnr_of(const std::string& part, const Json& evaluation) {
  if (part == "foreground") return evaluation.at("foreground").at("held_out").at("psnr_box");
  for (const Json& layer : evaluation.at("layers"))
    if (layer.at("name") == part) return layer.at("held_out").at("psnr");
  throw std::runtime_error("no layer " + part);
}

std::string name_of(const testing::TestParamInfo<Piece>& piece) { return piece.param.folder; }

class ShortCapture : public testing::TestWithParam<Piece> {
protected:
  static void expect_reached(const fs::path& capture) {
    const Json report = report_of(capture, GetParam());
    ASSERT_FALSE(report.is_null());
    EXPECT_EQ(report.at("capture").at("frames_used"), 12);
    EXPECT_EQ(report.at("capture").at("frames_held_out"), 2);
    EXPECT_GT(psnr_of(GetParam().part, report.at("evaluation")), GetParam().psnr);
  }
};

class SimulatedSensor : public ShortCapture {};

TEST_P(SimulatedSensor, IsEncodedWithItsFaults) { expect_reached(source_folder() / "samples" / GetParam().folder); }

INSTANTIATE_TEST_SUITE_P(All, SimulatedSensor,
                         testing::Values(Piece{"walk_pitcher", "0:12", "foreground", 18.2}, // 18.5
                                         Piece{"leap_ball", "0:12", "foreground", 19.8},    // 20.1
                                         Piece{"guard_crate", "0:12", "foreground", 23.9}), // 24.2
                         name_of);

class RealSensor : public ShortCapture {};

TEST_P(RealSensor, IsEncodedWithoutAFlag) {
  const fs::path capture = source_folder() / ".." / "shared" / "data" / GetParam().folder;
  if (!fs::exists(capture)) GTEST_SKIP() << capture.string() << " is not there";
  expect_reached(capture);
}

INSTANTIATE_TEST_SUITE_P(All, RealSensor,
                         testing::Values(Piece{"static_3dmatch50", "0:12", "background", 27.8},        // 28.2
                                         Piece{"squirrel_handling", "100:112", "background", 23.2},    // 23.6
                                         Piece{"depthkit_person_laptop", "0:12", "background", 18.4}), // 18.8
                         name_of);

} // namespace
} // namespace kinora::test
