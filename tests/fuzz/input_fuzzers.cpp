// What else a user may give to a command: cameras to draw from, a body, points to follow.
#include <zip.h>

#include "cli/point_file.h"
#include "clip/sample_clip.h"
#include "formats/sample_capture.h"
#include "fuzz/fuzzer.h"
#include "ingest/files/body_mesh.h"
#include "ingest/files/npy_array.h"
#include "ingest/files/npy_bytes.h"
#include "ingest/files/npz_archive.h"
#include "ingest/onnx/onnx_input.h"
#include "ingest/onnx/tiny_network.h"
#include "player/camera_file.h"

namespace kinora::fuzz {
namespace {

using test::TemporaryFolder;

void read_camera_file(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  static const clip::Clip clip = clip::testing::sample_clip(1, 4, true);
  folder.write("transforms.json", input);
  Progress progress;
  (void)player::read_camera_file(folder.path() / "transforms.json", clip, progress);
}
std::vector<Bytes> camera_files() {
  return {bytes_of(R"({"w": 64, "h": 48, "fl_x": 60, "fl_y": 60, "cx": 32, "cy": 24, "frames": [
    {"file_path": "a/0001.png", "frame": 2, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,2],[0,0,0,1]]},
    {"file_path": "b", "time": 0.01, "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,2],[0,0,0,1]]}]})"),
          bytes_of(R"({"w": 64, "h": 48, "camera_angle_x": 0.8, "k1": 0.1, "frames": [
    {"file_path": "a", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,2],[0,0,0,1]]}]})")};
}

void read_points(std::span<const std::byte> input) {
  (void)cli::parse_points({reinterpret_cast<const char*>(input.data()), input.size()}, "fuzz");
}
std::vector<Bytes> points() { return {bytes_of("id,x,y,z\na,0.5,1,2\nb 2,-1e-3,0,1\r\n")}; }

void read_npy(std::span<const std::byte> input) { (void)ingest::parse_npy(input, "fuzz"); }
std::vector<Bytes> npy_arrays() {
  return {ingest::testing::npy<double>("<f8", "(2, 3)", {1, 2, 3, 4, 5, 6}),
          ingest::testing::npy<std::int32_t>("<i4", "(2,)", {1, 2}),
          ingest::testing::npy_with_header("{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2), }", Bytes(8))};
}

/// The archive alone: what its arrays must be is body_mesh_test's.
void read_archive(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("a.npz", input);
  const ingest::NpzArchive archive(folder.path() / "a.npz");
  (void)archive.read("f");
}
std::vector<Bytes> archives() {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.npz";
  const Bytes array = ingest::testing::npy<std::uint32_t>("<u4", "(2, 3)", {0, 1, 2, 1, 2, 22});
  std::vector<Bytes> seeds;
  for (const zip_int32_t method : {ZIP_CM_STORE, ZIP_CM_DEFLATE}) {
    zip_t* zip = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
    const zip_int64_t added = zip_file_add(zip, "f.npy", zip_source_buffer(zip, array.data(), array.size(), 0), 0);
    zip_set_file_compression(zip, static_cast<zip_uint64_t>(added), method, 0);
    zip_close(zip);
    std::ifstream file(path, std::ios::binary);
    seeds.push_back(bytes_of({std::istreambuf_iterator<char>(file), {}}));
  }
  return seeds;
}

/// Of a network only what Kinora itself reads of it.
void read_network(std::span<const std::byte> input) {
  (void)ingest::onnx_picture_input({reinterpret_cast<const char*>(input.data()), input.size()});
}
std::vector<Bytes> networks() { return {bytes_of(test::onnx::convolution(2, {1, 2, 3, 4, 5, 6}, {0, 0}))}; }

} // namespace

std::vector<Fuzzer> input_fuzzers() {
  return {{"camera_file", camera_files, read_camera_file, 500},
          {"points", points, read_points, 2000},
          {"npy", npy_arrays, read_npy, 3000},
          {"npz", archives, read_archive, 500},
          {"network", networks, read_network, 3000}};
}

} // namespace kinora::fuzz
