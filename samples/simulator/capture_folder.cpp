#include "capture_folder.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include <fmt/format.h>
#include <jpeglib.h>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/image_codec.h"
#include "text_file.h"

namespace kinora::simulator {
namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using Vec = Eigen::Vector3d;

constexpr double kStart = 1000; ///< seconds: the first time stamp
constexpr int kNovelEvery = 10;
constexpr int kTracks = 200;
constexpr std::uint64_t kSeed = 2;

void write(const fs::path& path, std::span<const std::byte> bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) throw Error(ErrorCode::kUnwritableOutput, path.string() + ": cannot be written");
}
void write(const fs::path& path, const std::string& text) { write(path, std::as_bytes(std::span(text))); }

Bytes encode_jpeg(const ColorImage& image, int quality) {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &buffer, &size);
  jpeg.image_width = static_cast<JDIMENSION>(image.width());
  jpeg.image_height = static_cast<JDIMENSION>(image.height());
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg.optimize_coding = TRUE;
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  for (int v = 0; v < image.height(); ++v) {
    auto* row = const_cast<std::uint8_t*>(image.pixel(0, v)); // NOLINT: libjpeg reads it
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  const auto* begin = reinterpret_cast<const std::byte*>(buffer);
  Bytes bytes(begin, begin + size);
  jpeg_destroy_compress(&jpeg);
  std::free(buffer); // NOLINT: libjpeg's memory
  return bytes;
}

DepthImage16 millimetres(const DepthImage& depth) {
  DepthImage16 units(depth.width(), depth.height());
  std::transform(depth.values().begin(), depth.values().end(), units.data(),
                 [](float z) { return static_cast<std::uint16_t>(std::lround(1000.0 * static_cast<double>(z))); });
  return units;
}

std::string row_major(const SE3& pose) {
  std::string text;
  for (int i = 0; i < 16; ++i) text += fmt::format(" {:.9f}", pose.matrix()(i / 4, i % 4));
  return text;
}

struct NamedCamera {
  std::string name;
  Camera camera;
};

/// The capture's, then three turned about what it looks at.
std::vector<NamedCamera> cameras_of(const Camera& capture) {
  std::vector<NamedCamera> cameras{{"cam0_capture", capture}};
  const Vec eye = capture.camera_to_world.translation();
  const auto turned = [&](double degrees, double height) {
    const Eigen::AngleAxisd about(degrees * std::numbers::pi / 180, Vec::UnitY());
    return camera_at(about * eye + Vec(0, height, 0), {0, 0.95, 0});
  };
  cameras.push_back({"cam1_p20", turned(20, 0)});
  cameras.push_back({"cam2_m40", turned(-40, 0)});
  cameras.push_back({"cam3_raised", turned(-15, 0.9)});
  return cameras;
}

Json json_of(const NamedCamera& named) {
  const Intrinsics& k = named.camera.intrinsics;
  Json matrix = Json::array();
  for (int r = 0; r < 4; ++r) {
    Json row = Json::array();
    for (int c = 0; c < 4; ++c) row.push_back(named.camera.camera_to_world.matrix()(r, c));
    matrix.push_back(std::move(row));
  }
  return {{"name", named.name}, {"width", k.width}, {"height", k.height}, {"fx", k.fx},
          {"fy", k.fy},         {"cx", k.cx},       {"cy", k.cy},         {"camera_to_world", std::move(matrix)}};
}

/// Points that stay on the person's skin and clothes.
class Tracks {
public:
  explicit Tracks(const Scene& scene) {
    Random random(kSeed, 1);
    const auto& faces = scene.human().faces();
    const auto& rest = scene.human().rest();
    std::vector<double> area_until;
    double area = 0;
    for (const auto& face : faces) {
      const auto corner = [&](std::size_t i) { return rest[static_cast<std::size_t>(face[i])]; };
      area += (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm();
      area_until.push_back(area);
    }
    for (int i = 0; i < kTracks; ++i) {
      const auto found = std::lower_bound(area_until.begin(), area_until.end(), area * random.uniform_double());
      const double a = std::sqrt(random.uniform_double());
      const double b = random.uniform_double();
      points_.push_back({faces[static_cast<std::size_t>(found - area_until.begin())], {1 - a, a * (1 - b), a * b}});
    }
  }

  void add(int frame, const HumanPose& person, const Camera& camera, const DepthImage& depth) {
    const SE3 world_to_camera = camera.camera_to_world.inverse();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto vertex = [&](std::size_t k) { return person.vertices[static_cast<std::size_t>(points_[i].face[k])]; };
      const Vec& w = points_[i].weights;
      const Vec p = world_to_camera * Vec(w[0] * vertex(0) + w[1] * vertex(1) + w[2] * vertex(2));
      const Eigen::Vector2d at = camera.intrinsics.project(p);
      const int u = static_cast<int>(std::lround(at.x()));
      const int v = static_cast<int>(std::lround(at.y()));
      const bool visible = depth.contains(u, v) && std::abs(static_cast<double>(depth.at(u, v)) - p.z()) < 0.012;
      text_ += fmt::format("{},{},{:.5f},{:.5f},{:.5f},{}\n", frame, i, p.x(), p.y(), p.z(), visible ? 1 : 0);
    }
  }
  const std::string& text() const { return text_; }

private:
  struct Point {
    std::array<int, 3> face;
    Vec weights;
  };
  std::vector<Point> points_;
  std::string text_ = "frame,id,x_m,y_m,z_m,visible\n";
};

/// The text files that grow by a frame at a time.
struct Lists {
  std::string colors = "# time file\n";
  std::string depths = "# time file\n";
  std::string pairs;
  std::string object_poses = "# frame time object_to_camera (16 numbers, row by row)\n";
  std::string joints;
};

void add_truth(const Scene& scene, int frame, const HumanPose& person, Lists& lists) {
  const SE3 world_to_camera = scene.parameters().camera.camera_to_world.inverse();
  const double time = frame / kFramesPerSecond;
  for (const Thing& thing : scene.parameters().things)
    if (thing.label == 2)
      lists.object_poses += fmt::format("{} {:.6f}{}\n", frame, kStart + time,
                                        row_major(world_to_camera * thing.pose(time, scene.human(), person)));
  if (frame == 0) {
    lists.joints = "frame";
    for (const std::string& name : scene.human().bone_names()) lists.joints += fmt::format(",{0}_x,{0}_y,{0}_z", name);
    lists.joints += "\n";
  }
  lists.joints += std::to_string(frame);
  for (const Vec& joint : person.joints)
    for (const double x : Vec(world_to_camera * joint)) lists.joints += fmt::format(",{:.4f}", x);
  lists.joints += "\n";
}

void write_novel(const Scene& scene, const std::vector<Surface>& surfaces, int frame, const NamedCamera& camera,
                 const fs::path& folder) {
  const View view = render(surfaces, scene.parameters().light, camera.camera);
  write(folder / "rgb" / fmt::format("{:06}.jpg", frame), encode_jpeg(expose(view.light), 92));
  write(folder / "depth" / fmt::format("{:06}.png", frame), encode_png16(millimetres(view.depth)));
  ColorImage labels(view.labels.width(), view.labels.height(), 1);
  std::copy(view.labels.values().begin(), view.labels.values().end(), labels.data());
  write(folder / "mask" / fmt::format("{:06}.png", frame), encode_png(labels));
}

void write_frame(const Scene& scene, int frame, const fs::path& folder, Lists& lists, Tracks& tracks) {
  const Scene::Parameters& given = scene.parameters();
  const double time = frame / kFramesPerSecond;
  Random random(kSeed, 100 + static_cast<std::uint64_t>(frame));
  const std::vector<Surface> surfaces = scene.surfaces_at(time);
  View view = render(surfaces, given.light, given.camera);
  if (given.sensor.colour_delay > 0)
    view.light = render(scene.surfaces_at(time - given.sensor.colour_delay), given.light, given.camera).light;
  const std::string stem = fmt::format("{:06}", frame);
  write(folder / "rgb" / (stem + ".jpg"),
        encode_jpeg(expose(view.light, time, given.sensor, random), given.sensor.jpeg_quality));
  write(folder / "depth" / (stem + ".png"),
        encode_png16(measure_depth(surfaces, given.camera, view.depth, given.sensor, random)));
  ColorImage labels(view.labels.width(), view.labels.height(), 1);
  std::copy(view.labels.values().begin(), view.labels.values().end(), labels.data());
  write(folder / "mask" / (stem + ".png"), encode_png(labels));
  lists.colors += fmt::format("{:.6f} rgb/{}.jpg\n", kStart + time, stem);
  lists.depths += fmt::format("{:.6f} depth/{}.png\n", kStart + time, stem);
  lists.pairs += fmt::format("{0:.6f} rgb/{1}.jpg {0:.6f} depth/{1}.png\n", kStart + time, stem);
  const HumanPose person = scene.person_at(time);
  add_truth(scene, frame, person, lists);
  tracks.add(frame, person, given.camera, view.depth);
  if (frame % kNovelEvery != 0) return;
  const std::vector<NamedCamera> cameras = cameras_of(given.camera);
  for (std::size_t i = 1; i < cameras.size(); ++i)
    write_novel(scene, surfaces, frame, cameras[i], folder / "novel" / cameras[i].name);
}

std::string obj_of(const Mesh& mesh) {
  std::string text;
  for (const Vec& v : mesh.vertices) text += fmt::format("v {:.6f} {:.6f} {:.6f}\n", v.x(), v.y(), v.z());
  for (const auto& face : mesh.faces) text += fmt::format("f {} {} {}\n", face[0] + 1, face[1] + 1, face[2] + 1);
  return text;
}

} // namespace

void write_capture(const Scene& scene, const fs::path& folder, int frames) {
  const Scene::Parameters& given = scene.parameters();
  Lists lists;
  Tracks tracks(scene);
  for (int frame = 0; frame < frames; ++frame) write_frame(scene, frame, folder, lists, tracks);
  write(folder / "rgb.txt", lists.colors);
  write(folder / "depth.txt", lists.depths);
  write(folder / "associations.txt", lists.pairs);
  const Intrinsics& k = given.camera.intrinsics;
  const Json intrinsics = {{"width", k.width},
                           {"height", k.height},
                           {"fx", k.fx},
                           {"fy", k.fy},
                           {"cx", k.cx},
                           {"cy", k.cy},
                           {"depth_factor", 1000},
                           {"depth_max_m", given.sensor.range},
                           {"fps", kFramesPerSecond}};
  write(folder / "intrinsics.json", intrinsics.dump(1) + "\n");
  Json cameras = Json::array();
  for (const NamedCamera& camera : cameras_of(given.camera)) cameras.push_back(json_of(camera));
  write(folder / "cameras.json", Json{{"cameras", std::move(cameras)}}.dump(1) + "\n");
  write(folder / "gt" / "joints.csv", lists.joints);
  Json parents;
  for (std::size_t b = 0; b < scene.human().bone_names().size(); ++b) {
    const int parent = scene.human().bone_parents()[b];
    parents[scene.human().bone_names()[b]] =
        parent < 0 ? Json(nullptr) : Json(scene.human().bone_names()[static_cast<std::size_t>(parent)]);
  }
  write(folder / "gt" / "joint_parents.json", parents.dump(1) + "\n");
  for (const Thing& thing : given.things) {
    if (thing.label != 2) continue;
    write(folder / "gt" / "object_pose.txt", lists.object_poses);
    write(folder / "gt" / "object_mesh.obj", obj_of(thing.mesh));
  }
  write_packed_text(folder / "gt" / "tracks.csv.gz", tracks.text());
}

} // namespace kinora::simulator
