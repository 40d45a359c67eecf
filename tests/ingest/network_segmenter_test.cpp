// Networks are made here, byte by byte: one 1×1 convolution in ONNX's protobuf.
#include "ingest/network_segmenter.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "formats/sample_capture.h"

namespace kinora::ingest {
namespace {

using kinora::test::TemporaryFolder;

std::string varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 128; value >>= 7) bytes += static_cast<char>((value & 127) | 128);
  return bytes + static_cast<char>(value);
}
std::string number(int field, std::uint64_t value) {
  return varint(static_cast<std::uint64_t>(field) << 3) + varint(value);
}
std::string bytes(int field, const std::string& content) {
  return varint((static_cast<std::uint64_t>(field) << 3) | 2) + varint(content.size()) + content;
}

std::string tensor(const std::string& name, const std::vector<std::uint64_t>& sizes, const std::vector<float>& values) {
  std::string text;
  for (const std::uint64_t size : sizes) text += number(1, size);
  text += number(2, 1); // float
  text += bytes(8, name);
  return text + bytes(9, std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)));
}

std::string value_info(const std::string& name, std::uint64_t channels) {
  std::string shape;
  for (const std::uint64_t size : {std::uint64_t{1}, channels, std::uint64_t{32}, std::uint64_t{64}})
    shape += bytes(1, number(1, size));
  return bytes(1, name) + bytes(2, bytes(1, number(1, 1) + bytes(2, shape)));
}

/// scores = weights · RGB + biases, per pixel.
std::string convolution(std::uint64_t classes, const std::vector<float>& weights, const std::vector<float>& biases) {
  const std::string kernel = bytes(1, "kernel_shape") + number(8, 1) + number(8, 1) + number(20, 7);
  const std::string node =
      bytes(1, "x") + bytes(1, "w") + bytes(1, "b") + bytes(2, "y") + bytes(4, "Conv") + bytes(5, kernel);
  const std::string graph = bytes(1, node) + bytes(2, "g") + bytes(5, tensor("w", {classes, 3, 1, 1}, weights)) +
                            bytes(5, tensor("b", {classes}, biases)) + bytes(11, value_info("x", 3)) +
                            bytes(12, value_info("y", classes));
  return number(1, 6) + bytes(7, graph) + bytes(8, bytes(1, "") + number(2, 11));
}

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
