#include "openvdb/vdb_writer.h"

#include <mutex>
#include <sstream>

#include <Eigen/Core>
#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include "common/files.h"
#include "core/error.h"
#include "core/random.h"
#include "openvdb/level_set.h"

namespace kinora::formats {
namespace {

constexpr float kLargestHalf = 65504;

/// Files with the places of grids inside, so that readers need not load all of them; into any stream.
class SeekableArchive : public openvdb::io::Archive {
public:
  std::string bytes_of(const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const {
    std::ostringstream stream(std::ios::binary);
    write(stream, grids, true, metadata);
    return stream.str();
  }
};

/// OpenVDB puts a random identifier into each file: here it is made of the contents, so that equal volumes give equal
/// files. It stands after the magic number, three versions and a flag (openvdb/io/Archive.cc, writeHeader).
void settle_identifier(std::string& file) {
  constexpr std::size_t kOffset = 8 + 4 + 8 + 1;
  constexpr std::size_t kLength = 36;
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || c == '-'; };
  if (file.size() < kOffset + kLength ||
      !std::all_of(file.begin() + kOffset, file.begin() + kOffset + kLength, is_digit))
    throw Error(ErrorCode::kMissingComponent, "this version of OpenVDB writes a header that Kinora does not know");
  std::fill_n(file.begin() + kOffset, kLength, '0');
  std::uint64_t hash = 0;
  for (const char c : file) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3ULL;
  const std::string pattern = "xxxxxxxx-xxxx-4xxx-8xxx-xxxxxxxxxxxx"; // RFC 9562, version 4
  std::uint64_t digits = 0;
  for (std::size_t i = 0; i < kLength; ++i) {
    if (i % 16 == 0) digits = mix64(hash + i);
    file[kOffset + i] = pattern[i] == 'x' ? "0123456789abcdef"[digits & 15] : pattern[i];
    digits >>= 4;
  }
}

/// A volume in the axes and lengths of a file: the numbers of voxels are turned with the world, so that a transform
/// which only scales and shifts stays one.
class PlacedVolume {
public:
  /// Throws Error(kUsage) if the volume's transform has no inverse.
  PlacedVolume(const KinoraVolume& volume, const VdbSettings& settings, const std::string& location)
      : given(volume), half_floats(settings.half_floats), rotation_(settings.axes.rotation().cast<int>()) {
    Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
    turn.topLeftCorner<3, 3>() = settings.axes.rotation();
    Eigen::Matrix4d world =
        turn * Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(volume.voxel_to_world);
    world.topRows<3>() *= settings.axes.per_metre;
    world = (world * turn.transpose()).eval();
    openvdb::Mat4d matrix; // OpenVDB's vectors are rows
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) matrix(c, r) = world(r, c);
    }
    if (!(std::abs(matrix.det()) > 0) || !std::isfinite(matrix.det()))
      throw Error(ErrorCode::kUsage, location + ": the transform of the volume has no inverse");
    transform = openvdb::math::Transform::createLinearTransform(matrix);
  }

  openvdb::Coord voxel(std::size_t i) const {
    const Eigen::Vector3i v = rotation_ * Eigen::Map<const Eigen::Vector3i>(given.voxels + 3 * i);
    return {v.x(), v.y(), v.z()};
  }

  const KinoraVolume& given;
  bool half_floats;
  openvdb::math::Transform::Ptr transform;

private:
  Eigen::Matrix3i rotation_;
};

template <class Grid, class Value>
typename Grid::Ptr grid_of(const char* name, const PlacedVolume& volume, const Value& value) {
  typename Grid::Ptr grid = Grid::create();
  auto accessor = grid->getAccessor();
  for (std::size_t i = 0; i < volume.given.voxel_count; ++i) accessor.setValue(volume.voxel(i), value(i));
  openvdb::tools::prune(grid->tree());
  grid->setName(name);
  grid->setTransform(volume.transform->copy());
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setSaveFloatAsHalf(volume.half_floats);
  grid->addStatsMetadata();
  return grid;
}

/// Readers interpolate between voxels. Each unset voxel beside set ones takes the mean of those, so that colour does
/// not fade to black where density does.
void dilate_colors(const PlacedVolume& volume, openvdb::Vec3SGrid& colors) {
  const auto sums = openvdb::Vec3SGrid::create();
  const auto counts = openvdb::FloatGrid::create();
  {
    const auto set = colors.getConstAccessor();
    auto sum = sums->getAccessor();
    auto count = counts->getAccessor();
    for (std::size_t i = 0; i < volume.given.voxel_count; ++i) {
      const openvdb::Coord from = volume.voxel(i);
      for (int k = 0; k < 27; ++k) {
        const openvdb::Coord to = from.offsetBy(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        if (set.isValueOn(to)) continue;
        sum.setValue(to, sum.getValue(to) + set.getValue(from));
        count.setValue(to, count.getValue(to) + 1);
      }
    }
  }
  const auto count = counts->getConstAccessor();
  auto out = colors.getAccessor();
  for (auto sum = sums->cbeginValueOn(); sum; ++sum)
    out.setValue(sum.getCoord(), *sum / count.getValue(sum.getCoord()));
}

const KinoraVolumeChannel* channel_of(const KinoraVolume& volume, std::string_view name, int components) {
  for (std::size_t i = 0; i < volume.channel_count; ++i) {
    const KinoraVolumeChannel& channel = volume.channels[i];
    if (channel.name == name && channel.components == components && channel.values != nullptr) return &channel;
  }
  return nullptr;
}

openvdb::FloatGrid::Ptr density_of(const PlacedVolume& volume, const VdbSettings& settings,
                                   const std::string& location) {
  // An empty volume has no values to point to.
  const KinoraVolumeChannel* density = channel_of(volume.given, "density", 1);
  if (density == nullptr && volume.given.voxel_count > 0)
    throw Error(ErrorCode::kUsage, location + ": the volume has no channel \"density\"");
  const float limit = settings.half_floats ? kLargestHalf : std::numeric_limits<float>::max();
  const auto metres = static_cast<float>(1 / settings.axes.per_metre);
  return grid_of<openvdb::FloatGrid>(settings.names.density, volume,
                                     [&](std::size_t i) { return std::min(density->values[i] * metres, limit); });
}

openvdb::Vec3SGrid::Ptr colors_of(const PlacedVolume& volume, const char* name, const KinoraVolumeChannel* color) {
  auto colors = grid_of<openvdb::Vec3SGrid>(name, volume, [&](std::size_t i) {
    const float* c = color->values + 3 * i;
    return openvdb::Vec3s(c[0], c[1], c[2]);
  });
  dilate_colors(volume, *colors);
  colors->addStatsMetadata();
  colors->setVectorType(openvdb::VEC_INVARIANT); // not turned with the volume
  return colors;
}

openvdb::GridCPtrVec grids_of(const KinoraVolume& given, const VdbSettings& settings, const std::string& location) {
  const PlacedVolume volume(given, settings, location);
  const auto density = density_of(volume, settings, location);
  openvdb::GridCPtrVec grids;
  if (settings.fog) grids.push_back(density);
  if (settings.surface) {
    const auto surface = level_set_of(*density);
    surface->setName(settings.names.surface);
    surface->setSaveFloatAsHalf(settings.half_floats);
    surface->addStatsMetadata();
    grids.push_back(surface);
  }
  const KinoraVolumeChannel* color = channel_of(given, "color", 3);
  if (color != nullptr || given.voxel_count == 0) grids.push_back(colors_of(volume, settings.names.color, color));
  return grids;
}

} // namespace

VdbWriter::VdbWriter(std::filesystem::path path, const VdbSettings& settings)
    : path_(std::move(path)), settings_(settings) {
  write_file(path_, {});
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

void VdbWriter::write(const KinoraVolume& volume) {
  if (written_) throw Error(ErrorCode::kUsage, path_.string() + ": an OpenVDB file holds one volume");
  std::string bytes;
  try {
    openvdb::MetaMap metadata;
    for (const auto& [name, value] : facts_) metadata.insertMeta(name, openvdb::StringMetadata(value));
    metadata.insertMeta("axes", openvdb::StringMetadata(settings_.axes.text()));
    metadata.insertMeta("creator", openvdb::StringMetadata("Kinora"));
    metadata.insertMeta("name", openvdb::StringMetadata(volume.name));
    metadata.insertMeta("frame", openvdb::Int64Metadata(volume.frame));
    metadata.insertMeta("time", openvdb::DoubleMetadata(volume.time));
    bytes = SeekableArchive().bytes_of(grids_of(volume, settings_, path_.string()), metadata);
  } catch (const openvdb::Exception& error) {
    throw Error(ErrorCode::kFailure, path_.string() + ": OpenVDB cannot store the volume: " + error.what());
  }
  settle_identifier(bytes);
  write_file(path_, std::as_bytes(std::span(bytes)));
  written_ = true;
}

void VdbWriter::finish() const {
  if (!written_) throw Error(ErrorCode::kFailure, path_.string() + ": no volume was written");
}

} // namespace kinora::formats
