// What folders hold: one file of a capture, or of the truth beside it, is the input; the others stay as they are.
#include <fmt/format.h>
#include <zip.h>
#include <zlib.h>

#include "azure_kinect/kinect_calibration.h"
#include "core/error.h"
#include "core/image_codec.h"
#include "evaluate/ground_truth.h"
#include "evaluate/ground_truth_tracks.h"
#include "formats/sample_capture.h"
#include "fuzz/fuzzer.h"
#include "host/plugin_table.h"
#include "ingest/capture/capture.h"
#include "record3d/lzfse.h"
#include "stray_scanner/stray_reader.h"

namespace kinora::fuzz {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;

constexpr int kFrames = 3;

void read_capture(const fs::path& folder) {
  static const host::PluginTable plugins = host::PluginTable::builtin();
  Progress progress;
  const auto capture = ingest::Capture::open(plugins, folder, {}, progress);
  while (capture->next()) {
  }
}

/// A capture whose file `name` is the input.
struct Folder {
  TemporaryFolder folder;
  const char* name;

  template <class Write> Folder(const char* fuzzed, const Write& write_capture) : name(fuzzed) {
    write_capture(folder);
  }
  void read_with(std::span<const std::byte> input) const {
    folder.write(name, input);
    read_capture(folder.path());
  }
};

std::vector<Bytes> texts(std::initializer_list<const char*> list) {
  std::vector<Bytes> seeds;
  for (const char* text : list) seeds.push_back(bytes_of(text));
  return seeds;
}

void write_tum(const TemporaryFolder& folder) { test::write_tum(folder, kFrames); }

void read_tum_list(std::span<const std::byte> input) {
  static const Folder folder("rgb.txt", write_tum);
  folder.read_with(input);
}
std::vector<Bytes> tum_lists() {
  return texts({"# time file\n100.000000 rgb/100.000000.png\n100.033333 rgb/100.033333.png\n"
                "100.066667 rgb/100.066667.png\n"});
}

void read_associations(std::span<const std::byte> input) {
  static const Folder folder("associations.txt", write_tum);
  folder.read_with(input);
}
std::vector<Bytes> associations() {
  return texts({"100.0 rgb/100.000000.png 100.005 depth/100.005000.png\n"
                "100.03 rgb/100.033333.png 100.038 depth/100.038333.png\n",
                "100.005 depth/100.005000.png 100.0 rgb/100.000000.png\n"});
}

void read_trajectory(std::span<const std::byte> input) {
  static const Folder folder("groundtruth.txt", write_tum);
  folder.read_with(input);
}
std::vector<Bytes> trajectories() {
  return texts({"# t x y z qx qy qz qw\n100.0 0 0 0 0 0 0 1\n100.03 1 0 0 0 0 0 1\n100.07 2 0 0 0 0.6 0 0.8\n"});
}

void read_calibration(std::span<const std::byte> input) {
  static const Folder folder("intrinsics.json", write_tum);
  folder.read_with(input);
}
std::vector<Bytes> calibrations() {
  return texts(
      {test::kSampleIntrinsics,
       R"({"fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5, "depth_scale_m": 0.001, "distortion": [0.1, -0.2, 0, 0, 1],
                 "depth_registered_to_color": true})",
       R"({"width": 16, "height": 12, "intrinsic_matrix": [20, 0, 0, 0, 20, 0, 7.5, 5.5, 1], "depth_scale": 1000})"});
}

void read_camera_matrix(std::span<const std::byte> input) {
  static const Folder folder("camera-intrinsics.txt",
                             [](const TemporaryFolder& made) { test::write_3dmatch(made, kFrames); });
  folder.read_with(input);
}
std::vector<Bytes> camera_matrices() {
  return texts({"2.0e+001 0 7.5\n0 20 5.5\n0 0 1\n", "20 0 7.5 0\n0 20 5.5 0\n0 0 1 0\n0 0 0 1\n"});
}

void read_labels_json(std::span<const std::byte> input) {
  static const Folder folder("labels.json", [](const TemporaryFolder& made) { test::write_numbered(made, kFrames); });
  folder.read_with(input);
}
std::vector<Bytes> labels_json() {
  return texts({R"({"2": {"name": "box", "kind": "rigid"}, "3": {"name": "anna", "kind": "deforming"}, "0": {}})"});
}

void read_pose_file(std::span<const std::byte> input) {
  static const Folder folder("frames/frame-000151.pose.txt",
                             [](const TemporaryFolder& made) { test::write_3dmatch(made, kFrames); });
  folder.read_with(input);
}
std::vector<Bytes> pose_files() {
  return texts({" 1.0e+000\t 0\t 0\t 1e-002\t\r\n 0\t 1\t 0\t 0\t\r\n 0\t 0\t 1\t 0\t\r\n 0\t 0\t 0\t 1\t\r\n"});
}

void read_trajectory_log(std::span<const std::byte> input) {
  static const Folder folder("trajectory.log", [](const TemporaryFolder& made) { test::write_numbered(made, 1); });
  folder.read_with(input);
}
std::vector<Bytes> trajectory_logs() {
  return texts({"# Open3D's\n0 0 1\n0.6 0 0.8 0.5\n0 1 0 -0.25\n-0.8 0 0.6 2\n0 0 0 1\n"});
}

constexpr const char* kYaml =
    "%YAML:1.2\nload_directory: \"./\"\nintrinsics:\n  f_u: 20\n  f_v: 21.5\n  pp_x: 7.5\n  pp_y: 5.5\n  width: 16\n"
    "  height: 12\ncamera2world_pose: !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: d\n  data: [1., 0, 0, 0,\n 0, 1., "
    "0, "
    "0,\n 0, 0, 1., 0,\n 0, 0, 0, 1.]\nimage_name_pre: \"{}_\"\nload_index: 9\nn_leading_zeros: 0\nimage_name_post: "
    "\"\"\nload_image_type: \"png\"\n";

void write_m3t(const TemporaryFolder& folder) {
  folder.write("depth.yaml", fmt::format(fmt::runtime(kYaml), "d") + "depth_scale: 0.001\n");
  for (int i = 0; i < kFrames; ++i) {
    folder.write(fmt::format("c_{}.png", 9 + i), test::color_bytes(i));
    folder.write(fmt::format("d_{}.png", 9 + i), test::depth_bytes(i));
  }
}

void read_yaml(std::span<const std::byte> input) {
  static const Folder folder("color.yaml", write_m3t);
  folder.read_with(input);
}
std::vector<Bytes> yaml_files() { return {bytes_of(fmt::format(fmt::runtime(kYaml), "c"))}; }

// ---- pictures

void decode_picture(std::span<const std::byte> input) {
  int refused = 0;
  std::string problem;
  const auto attempt = [&](const auto& decode) {
    try {
      decode(input, "fuzz");
    } catch (const Error& error) {
      ++refused;
      problem = error.what();
    }
  };
  attempt(decode_color);
  attempt(decode_depth16);
  attempt(decode_labels);
  if (refused == 3) throw Error(ErrorCode::kCorruptInput, problem);
}
std::vector<Bytes> pictures() {
  return {test::color_bytes(1),
          test::depth_bytes(1),
          test::jpeg_of(test::sample_color(24, 20)),
          test::jpeg_of(test::sample_color(24, 20), true),
          encode_png(test::sample_color(16, 12, 1)),
          encode_png(test::sample_color(16, 12, 4))};
}

// ---- the truth

void write_truth(const TemporaryFolder& folder) {
  test::write_numbered(folder, 1);
  folder.write("gt/object_pose.txt", "0 1000.0 1 0 0 0.5 0 1 0 0 0 0 1 2 0 0 0 1\n");
  folder.write("gt/object_mesh.obj", "v 0 0 0\nv 1 2 3\n");
}

void read_truth(const char* name, const TemporaryFolder& folder, std::span<const std::byte> input) {
  folder.write(name, input);
  (void)evaluate::GroundTruth::read(folder.path());
}

void read_cameras(std::span<const std::byte> input) {
  static const Folder truth("cameras.json", write_truth);
  read_truth("cameras.json", truth.folder, input);
}
std::vector<Bytes> cameras() {
  return texts({R"({"cameras": [{"name": "a", "width": 16, "height": 12, "fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5,
    "camera_to_world": [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}, {"name": "b", "width": 16,
    "height": 12, "fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5,
    "camera_to_world": [[0, 0, 1, 5], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]}]})"});
}

void read_object_poses(std::span<const std::byte> input) {
  static const Folder truth("gt/object_pose.txt", write_truth);
  read_truth("gt/object_pose.txt", truth.folder, input);
}
std::vector<Bytes> object_poses() {
  return texts({"# frame time matrix\n0 1000.0 1 0 0 0.5 0 1 0 0 0 0 1 2 0 0 0 1\n"
                "4 1000.1 1 0 0 0.6 0 1 0 0 0 0 1 2 0 0 0 1\r\n"});
}

void read_object_mesh(std::span<const std::byte> input) {
  static const Folder truth("gt/object_mesh.obj", write_truth);
  read_truth("gt/object_mesh.obj", truth.folder, input);
}
std::vector<Bytes> object_meshes() { return texts({"# box\nv 0 0 0\nv 1 2 3\nvt 9 9\nf 1 2 1\n"}); }

constexpr const char* kTracks = "frame,id,x_m,y_m,z_m,visible\n4,7,0.5,1,2,1\n5,7,0.5,1.5,2,0\n4,8,1e-3,-1,2,1\n";

/// As text and packed: zlib reads both.
void read_tracks(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("gt/tracks.csv.gz", input);
  (void)evaluate::read_ground_truth_tracks(folder.path());
}
std::vector<Bytes> tracks() {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.gz";
  const gzFile file = gzopen(path.c_str(), "wb");
  gzputs(file, kTracks);
  gzclose(file);
  std::ifstream packed(path, std::ios::binary);
  return {bytes_of(kTracks), bytes_of({std::istreambuf_iterator<char>(packed), {}})};
}

constexpr const char* kTransforms = R"({"w": 16, "h": 12, "fl_x": 20, "cx": 8, "cy": 6, "frames": [
{"file_path": "color/000000.png", "depth_file_path": "depth/000000.png", "time": 0,
 "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]},
{"file_path": "color/000001", "depth_path": "depth/000001.png", "time": 0.1,
 "transform_matrix": [[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0]]}]})";

void read_transforms(std::span<const std::byte> input) {
  static const Folder folder("transforms.json",
                             [](const TemporaryFolder& made) { test::write_numbered(made, kFrames); });
  folder.read_with(input);
}
std::vector<Bytes> transforms() { return texts({kTransforms}); }

constexpr const char* kOdometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n50.0, 000000, 0, 0, 0, 0, 0, 0.6, 0.8\n"
                                  "50.1, 000001, 0.1, 0, 0, 0, 0, 0.6, 0.8\n";

void read_odometry(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("odometry.csv", input);
  std::vector<std::string> warnings;
  for (const formats::StrayPose& pose : formats::read_odometry(folder.path() / "odometry.csv", warnings))
    require(pose.camera_to_world.matrix().allFinite(), "a pose is not finite");
}
std::vector<Bytes> odometries() { return texts({kOdometry, "0,0,0,0,0,0,1\n0.1,0,0,0,0,0,1\n"}); }

void read_stray_matrix(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write("camera_matrix.csv", input);
  Intrinsics camera = formats::read_camera_matrix(folder.path() / "camera_matrix.csv");
  camera.width = 1920;
  camera.height = 1440;
  camera.validate("fuzz");
}
std::vector<Bytes> stray_matrices() {
  return texts(
      {"1400.5,0,958.5\n0,1401,720.25\n0,0,1\n", "1.4e+03, 0.0, 957.5\r\n0.0, 1.4e+03, 721.5\r\n0.0, 0.0, 1.0\r\n"});
}

// ---- logs of robots

/// A log of ROS is one file; the seeds are those that foreign programs made.
void read_log(const char* name, std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  folder.write(name, input);
  read_capture(folder.path() / name);
}
std::vector<Bytes> samples_called(std::initializer_list<const char*> names) {
  std::vector<Bytes> seeds;
  for (const char* name : names) {
    std::ifstream file(fs::path(KINORA_ROS_SAMPLES) / name, std::ios::binary);
    seeds.push_back(bytes_of({std::istreambuf_iterator<char>(file), {}}));
  }
  return seeds;
}
void read_bag(std::span<const std::byte> input) { read_log("a.bag", input); }
std::vector<Bytes> bags() { return samples_called({"aligned_lz4.bag", "compressed_bz2.bag", "librealsense.bag"}); }
void read_mcap(std::span<const std::byte> input) { read_log("a.mcap", input); }
std::vector<Bytes> mcaps() { return samples_called({"plain.mcap", "lz4.mcap", "zstd.mcap"}); }

// ---- Record3D

void read_lzfse(std::span<const std::byte> input) {
  constexpr std::size_t kBytes = 12288; // depth of the sample, and a few bytes that are stored
  (void)formats::unpack_lzfse(input, kBytes, "fuzz");
}
std::vector<Bytes> lzfse_files() {
  std::vector<Bytes> seeds;
  zip_t* const archive = zip_open(KINORA_RECORD3D_SAMPLE, ZIP_RDONLY, nullptr);
  for (const char* name : {"rgbd/0.depth", "rgbd/1.depth"}) {
    zip_file_t* const file = zip_fopen(archive, name, 0);
    Bytes bytes(1 << 16);
    bytes.resize(static_cast<std::size_t>(zip_fread(file, bytes.data(), bytes.size())));
    zip_fclose(file);
    seeds.push_back(std::move(bytes));
  }
  zip_discard(archive);
  return seeds;
}

void read_r3d(std::span<const std::byte> input) { read_log("a.r3d", input); }
std::vector<Bytes> r3ds() {
  std::ifstream file(KINORA_RECORD3D_SAMPLE, std::ios::binary);
  return {bytes_of({std::istreambuf_iterator<char>(file), {}})};
}

/// What the archive says of its frames, in the sample's place; there it is packed, and would rarely be met.
void read_r3d_metadata(std::span<const std::byte> input) {
  static const TemporaryFolder folder;
  static const std::vector<Bytes> samples = r3ds();
  const fs::path path = folder.path() / "a.r3d";
  folder.write("a.r3d", samples.front());
  zip_t* const archive = zip_open(path.c_str(), 0, nullptr);
  zip_source_t* const source = zip_source_buffer(archive, input.data(), input.size(), 0);
  const zip_int64_t index = zip_file_add(archive, "metadata", source, ZIP_FL_OVERWRITE);
  require(index >= 0 && zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0) == 0 &&
              zip_close(archive) == 0,
          "the archive cannot be written");
  read_capture(path);
}
std::vector<Bytes> r3d_metadata() {
  return texts({R"({"w": 128, "h": 96, "dw": 64, "dh": 48, "fps": 60, "K": [100, 0, 0, 0, 101, 0, 63.5, 47.5, 1],
    "poses": [[0, 0, 0, 1, 0, 0, 0], [0, 0, 0.6, 0.8, 0.1, 0, 0], [0, 0, 0, 1, 0.2, 0, 0]],
    "frameTimestamps": [10, 10.01, 10.02]})",
                R"({"w": 128, "h": 96, "dw": 64, "dh": 48, "K": [100, 0, 0, 0, 101, 0, 63.5, 47.5, 1]})"});
}

void read_kinect_calibration(std::span<const std::byte> input) {
  (void)formats::read_kinect_calibration(input, 1280, 720, 640, 576, "fuzz");
}
std::vector<Bytes> kinect_calibrations() {
  return texts(
      {R"({"CalibrationInformation": {"Cameras": [{"Location": "CALIBRATION_CameraLocationD0", "MetricRadius": 1.7,
    "Intrinsics": {"ModelParameters": [0.5, 0.5, 0.49, 0.49, 5, 3, 0.1, 6, 5, 0.9, 0, 0, 0.0001, -0.0001]},
    "Rt": {"Rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "Translation": [0, 0, 0]}},
    {"Location": "CALIBRATION_CameraLocationPV0",
    "Intrinsics": {"ModelParameters": [0.5, 0.5, 0.48, 0.64, 0.5, -2.6, 1.5, 0.38, -2.4, 1.4, 0, 0, 0.0001, 0.0005]},
    "Rt": {"Rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "Translation": [-0.032, 0, 0]}}]}})"});
}

} // namespace

std::vector<Fuzzer> folder_fuzzers() {
  return {{"tum_list", tum_lists, read_tum_list, 100},
          {"associations", associations, read_associations, 100},
          {"trajectory", trajectories, read_trajectory, 100},
          {"calibration", calibrations, read_calibration, 200},
          {"camera_matrix", camera_matrices, read_camera_matrix, 200},
          {"labels_json", labels_json, read_labels_json, 200},
          {"pose_file", pose_files, read_pose_file, 100},
          {"trajectory_log", trajectory_logs, read_trajectory_log, 100},
          {"yaml", yaml_files, read_yaml, 200},
          {"picture", pictures, decode_picture, 3000},
          {"transforms", transforms, read_transforms, 200},
          {"cameras", cameras, read_cameras, 500},
          {"object_pose", object_poses, read_object_poses, 500},
          {"object_mesh", object_meshes, read_object_mesh, 500},
          {"tracks", tracks, read_tracks, 500},
          {"odometry", odometries, read_odometry, 300},
          {"stray_matrix", stray_matrices, read_stray_matrix, 500},
          {"ros_bag", bags, read_bag, 300},
          {"mcap", mcaps, read_mcap, 300},
          {"lzfse", lzfse_files, read_lzfse, 500},
          {"record3d", r3ds, read_r3d, 200},
          {"record3d_metadata", r3d_metadata, read_r3d_metadata, 200},
          {"kinect_calibration", kinect_calibrations, read_kinect_calibration, 300}};
}

} // namespace kinora::fuzz
