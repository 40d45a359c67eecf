#include "ingest/segmentation/network_segmenter.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "ingest/onnx/tiny_network.h"

namespace kinora::ingest {
namespace {

using kinora::test::TemporaryFolder;
using kinora::test::onnx::convolution;

Frame red_and_green() {
  Frame frame;
  frame.color = ColorImage(64, 32, 3, 10);
  for (int v = 0; v < 32; ++v) {
    for (int u = 0; u < 20; ++u) frame.color.at(u, v, 0) = 220;
    for (int u = 40; u < 64; ++u) frame.color.at(u, v, 1) = 220;
  }
  return frame;
}

TEST(NetworkSegmenter, TakesOneClassForForeground) {
  const TemporaryFolder folder;
  folder.write("net.onnx", convolution(1, {1, 0, 0}, {0}));
  const auto segmenter = make_network_segmenter(folder.path() / "net.onnx");
  Frame frame = red_and_green();
  segmenter->label(frame);
  for (int v = 0; v < 32; ++v)
    for (int u = 0; u < 64; ++u) EXPECT_EQ(frame.labels.at(u, v), u < 20 ? 1 : 0) << u << " " << v;
}

TEST(NetworkSegmenter, TakesTheLargestOfSeveralClassesForTheLabel) {
  const TemporaryFolder folder;
  folder.write("net.onnx", convolution(3, {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0.5F, 0, 0}));
  const auto segmenter = make_network_segmenter(folder.path() / "net.onnx");
  Frame frame = red_and_green();
  segmenter->label(frame);
  EXPECT_EQ(frame.labels.at(5, 5), 1);
  EXPECT_EQ(frame.labels.at(30, 5), 0);
  EXPECT_EQ(frame.labels.at(50, 5), 2);
  ASSERT_TRUE(segmenter->labels().contains(2));
  EXPECT_EQ(segmenter->labels().at(2).name, "object");
}

void expect_corrupt(const std::filesystem::path& path) {
  try {
    make_network_segmenter(path);
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
    EXPECT_NE(std::string(error.what()).find(path.filename().string()), std::string::npos);
  }
}

TEST(NetworkSegmenter, SaysWhichFileIsNoNetwork) {
  const TemporaryFolder folder;
  folder.write("text.onnx", std::string("this is no network"));
  folder.write("empty.onnx", std::string());
  folder.write("cut.onnx", convolution(1, {1, 0, 0}, {0}).substr(0, 60));
  for (const char* name : {"text.onnx", "empty.onnx", "cut.onnx", "missing.onnx"}) expect_corrupt(folder.path() / name);
}

} // namespace
} // namespace kinora::ingest
