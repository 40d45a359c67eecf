// OpenVDB files, read back by OpenVDB.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <set>

#include <openvdb/openvdb.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "host/plugin_table.h"
#include "host/volume_writer.h"

namespace kinora::formats {
namespace {

using namespace kinora::test;

/// Voxels of 2 cm in a block of 5 × 4 × 3, y and z up to 3 and 2.
host::Volume block() {
  host::Volume volume;
  volume.name = "kinora";
  volume.frame = 7;
  volume.time = 0.25;
  volume.voxel_to_world.topLeftCorner<3, 3>() *= 0.02;
  volume.voxel_to_world(2, 3) = 2; // 2 m ahead
  for (int i = 0; i < 60; ++i) {
    volume.voxels.push_back({i % 5, i / 5 % 4, i / 20});
    volume.density.push_back(10.0F + static_cast<float>(i));
    volume.color.push_back({0.5F, static_cast<float>(i) / 64, 0});
  }
  return volume;
}

class OpenVdbTest : public testing::Test {
protected:
  static void SetUpTestSuite() { openvdb::initialize(); }

  fs::path write(const host::Volume& volume, const std::string& name, const host::Options& options = {}) {
    host::write_volume(table_.find("openvdb"), folder_.path() / name, options, volume);
    return folder_.path() / name;
  }
  static openvdb::GridPtrVecPtr grids_of(const fs::path& path) {
    openvdb::io::File file(path.string());
    file.open();
    return file.getGrids();
  }
  template <class Grid> static typename Grid::Ptr grid_of(const fs::path& path, const std::string& name) {
    openvdb::io::File file(path.string());
    file.open();
    return openvdb::gridPtrCast<Grid>(file.readGrid(name));
  }

  TemporaryFolder folder_;
  host::PluginTable table_ = host::PluginTable::builtin();
};

TEST_F(OpenVdbTest, HoldsDensityAndColorAsFogVolumes) {
  const fs::path path = write(block(), "a.vdb");
  ASSERT_EQ(grids_of(path)->size(), 2U);
  const auto density = grid_of<openvdb::FloatGrid>(path, "density");
  const auto color = grid_of<openvdb::Vec3SGrid>(path, "Cd");
  EXPECT_EQ(density->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_EQ(color->getGridClass(), openvdb::GRID_FOG_VOLUME);
  EXPECT_TRUE(density->saveFloatAsHalf());
  EXPECT_EQ(density->activeVoxelCount(), 60U);
  EXPECT_EQ(color->activeVoxelCount(), 7U * 6 * 5); // one voxel further to every side
  EXPECT_FLOAT_EQ(density->background(), 0);
}

TEST_F(OpenVdbTest, ValuesLieWhereTheyBelongWithYUp) {
  const fs::path path = write(block(), "a.vdb");
  const auto density = grid_of<openvdb::FloatGrid>(path, "density");
  const auto color = grid_of<openvdb::Vec3SGrid>(path, "Cd");
  // Voxel (4, 3, 2) is the last of the block; in glTF's axes it is at x, -y, -z.
  const openvdb::Vec3d world(0.08, -0.06, -2.04);
  const openvdb::Coord coordinate = openvdb::Coord::round(density->worldToIndex(world));
  EXPECT_FLOAT_EQ(density->tree().getValue(coordinate), 69);
  EXPECT_NEAR(color->tree().getValue(coordinate).y(), 59.0 / 64, 1e-3);
  EXPECT_TRUE(density->transform().hasUniformScale());
  EXPECT_NEAR(density->voxelSize().x(), 0.02, 1e-12);
  const openvdb::CoordBBox box = density->evalActiveVoxelBoundingBox();
  EXPECT_EQ(box.dim(), openvdb::Coord(5, 4, 3));
  EXPECT_NEAR(density->indexToWorld(box.min()).y(), -0.06, 1e-12);
  EXPECT_NEAR(density->indexToWorld(box.max()).y(), 0, 1e-12);
}

TEST_F(OpenVdbTest, ColorDoesNotFadeBesideTheSurface) {
  host::Volume volume = block();
  for (auto& color : volume.color) color = {0.5F, 0.25F, 1};
  const auto color = grid_of<openvdb::Vec3SGrid>(write(volume, "a.vdb"), "Cd");
  for (auto value = color->cbeginValueOn(); value; ++value) EXPECT_EQ(*value, openvdb::Vec3s(0.5F, 0.25F, 1));
  // In glTF's axes the block reaches from 0 to 4, −3 and −2.
  EXPECT_TRUE(color->tree().isValueOn(openvdb::Coord(5, 1, 1)));
  EXPECT_FALSE(color->tree().isValueOn(openvdb::Coord(6, 1, 1)));
}

TEST_F(OpenVdbTest, MetadataNamesFrameAndTime) {
  openvdb::io::File file(write(block(), "a.vdb").string());
  file.open();
  const auto metadata = file.getMetadata();
  EXPECT_EQ(metadata->metaValue<std::int64_t>("frame"), 7);
  EXPECT_DOUBLE_EQ(metadata->metaValue<double>("time"), 0.25);
}

TEST_F(OpenVdbTest, TheUpAxisAndUnitsAreThoseAskedFor) {
  const fs::path path = folder_.path() / "z.vdb";
  host::write_volume(table_.find("openvdb"), path, {{"up", "z"}, {"units", "cm"}}, block(), {{"source", "clip.mkv"}});
  const auto density = grid_of<openvdb::FloatGrid>(path, "density");
  // Voxel (4, 3, 2) is at (0.08, 0.06, 2.04) m: right, forward, up of it in centimetres.
  const openvdb::Coord coordinate = openvdb::Coord::round(density->worldToIndex(openvdb::Vec3d(8, 204, -6)));
  EXPECT_NEAR(density->tree().getValue(coordinate), 0.69, 1e-3) << "extinction per centimetre";
  EXPECT_TRUE(density->transform().hasUniformScale());
  EXPECT_NEAR(density->voxelSize().x(), 2, 1e-9);
  openvdb::io::File file(path.string());
  file.open();
  EXPECT_EQ(file.getMetadata()->metaValue<std::string>("axes"), "centimetres, x right, y forward, z up");
  EXPECT_EQ(file.getMetadata()->metaValue<std::string>("source"), "clip.mkv");
}

TEST_F(OpenVdbTest, DensitiesBeyondHalfPrecisionStayFinite) {
  host::Volume volume = block();
  volume.density[3] = 1e6F;
  const auto half = grid_of<openvdb::FloatGrid>(write(volume, "half.vdb"), "density");
  const openvdb::Coord coordinate(3, 0, 0);
  EXPECT_FLOAT_EQ(half->tree().getValue(coordinate), 65504);
  const auto full = grid_of<openvdb::FloatGrid>(write(volume, "full.vdb", {{"precision", "float"}}), "density");
  EXPECT_FLOAT_EQ(full->tree().getValue(coordinate), 1e6F);
}

TEST_F(OpenVdbTest, EmptyVolumesAreFilesToo) {
  host::Volume volume = block();
  volume.voxels.clear();
  volume.density.clear();
  volume.color.clear();
  const fs::path path = write(volume, "empty.vdb", {{"content", "both"}});
  EXPECT_EQ(grid_of<openvdb::FloatGrid>(path, "density")->activeVoxelCount(), 0U);
  EXPECT_EQ(grid_of<openvdb::FloatGrid>(path, "surface")->activeVoxelCount(), 0U);
}

/// A ball of 20 cm around (0, 0, 2) in voxels of 2 cm: half of the light passes those on its surface.
host::Volume ball() {
  constexpr double kVoxel = 0.02;
  host::Volume volume = block();
  volume.voxels.clear();
  volume.density.clear();
  volume.color.clear();
  constexpr int kReach = 13;
  for (int z = -kReach; z <= kReach; ++z) {
    for (int y = -kReach; y <= kReach; ++y) {
      for (int x = -kReach; x <= kReach; ++x) {
        const double distance = kVoxel * std::sqrt(x * x + y * y + z * z) - 0.2;
        const double opacity = std::clamp(0.5 - distance / (2 * kVoxel), 0.0, 0.999);
        if (opacity == 0) continue;
        volume.voxels.push_back({x, y, z});
        volume.density.push_back(static_cast<float>(-std::log(1 - opacity) / kVoxel));
        volume.color.push_back({0.5F, 0.25F, 1});
      }
    }
  }
  return volume;
}

TEST_F(OpenVdbTest, LevelSetsHoldMetresToTheSurface) {
  const fs::path path = write(ball(), "ball.vdb", {{"content", "surface"}});
  const auto surface = grid_of<openvdb::FloatGrid>(path, "surface");
  EXPECT_EQ(surface->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_TRUE(surface->saveFloatAsHalf());
  EXPECT_NEAR(surface->background(), 0.06, 1e-4);
  const auto distance_at = [](const openvdb::Vec3d& world) {
    return (world - openvdb::Vec3d(0, 0, -2)).length() - 0.2;
  };
  std::size_t inside = 0;
  for (auto value = surface->cbeginValueOn(); value; ++value) {
    const double expected = distance_at(surface->indexToWorld(value.getCoord()));
    EXPECT_NEAR(*value, expected, std::abs(expected) < 0.02 ? 0.002 : 0.01)
        << value.getCoord(); // a tenth, half a voxel
    inside += *value < 0 ? 1U : 0U;
  }
  EXPECT_GT(inside, 1000U);
  EXPECT_NEAR(surface->tree().getValue(openvdb::Coord(0, 0, 0)), -0.06, 1e-4); // beyond the band
  EXPECT_NEAR(surface->tree().getValue(openvdb::Coord(40, 0, 0)), 0.06, 1e-4);
  EXPECT_EQ(grids_of(path)->size(), 2U); // and colour
}

TEST_F(OpenVdbTest, HollowsStayOutsideOfLevelSets) {
  host::Volume volume = ball();
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) {
    const auto& v = volume.voxels[i];
    if (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < 25) volume.density[i] = 0;
  }
  const auto surface = grid_of<openvdb::FloatGrid>(write(volume, "hollow.vdb", {{"content", "both"}}), "surface");
  EXPECT_GT(surface->tree().getValue(openvdb::Coord(0, 0, 0)), 0);
  EXPECT_LT(surface->tree().getValue(openvdb::Coord(7, 0, 0)), 0);
}

TEST_F(OpenVdbTest, GridsAreCalledAsTheProgramExpects) {
  const std::map<std::string, std::set<std::string>> expected = {{"houdini", {"density", "surface", "Cd"}},
                                                                 {"blender", {"density", "distance", "color"}},
                                                                 {"unreal", {"density", "surface", "color"}}};
  for (const auto& [program, names] : expected) {
    const auto grids = grids_of(write(block(), "named.vdb", {{"vdb-names", program}, {"content", "both"}}));
    std::set<std::string> found;
    for (const auto& grid : *grids) found.insert(grid->getName());
    EXPECT_EQ(found, names) << program;
  }
}

/// What OpenVDB's own program says of a file.
std::string printed(const fs::path& file) {
  std::string text;
  FILE* pipe = popen(("vdb_print -l '" + file.string() + "' 2>&1").c_str(), "r");
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  return pclose(pipe) == 0 ? text : "failed: " + text;
}

TEST_F(OpenVdbTest, VdbPrintReadsWhatIsWritten) {
  if (std::system("vdb_print -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "vdb_print is not installed";
  const std::string text = printed(write(ball(), "ball.vdb", {{"content", "both"}}));
  for (const char* word : {"Name: density", "Name: surface", "Name: Cd", "fog volume", "level set"})
    EXPECT_NE(text.find(word), std::string::npos) << word << " in " << text;
}

TEST_F(OpenVdbTest, SameVolumesGiveTheSameBytesAndOthersAnotherIdentifier) {
  const auto bytes = [](const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(stream)), {});
  };
  const std::string one = bytes(write(block(), "a.vdb"));
  EXPECT_EQ(one, bytes(write(block(), "b.vdb")));
  EXPECT_EQ(bytes(write(ball(), "a.vdb", {{"content", "both"}})), bytes(write(ball(), "b.vdb", {{"content", "both"}})));
  host::Volume other = block();
  other.frame = 8;
  EXPECT_NE(one.substr(21, 36), bytes(write(other, "c.vdb")).substr(21, 36));
}

TEST_F(OpenVdbTest, UnwritablePlacesAndImpossibleTransformsAreErrors) {
  const auto code_of = [&](const host::Volume& volume, const std::string& name) {
    try {
      write(volume, name);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode{};
  };
  EXPECT_EQ(code_of(block(), "absent/a.vdb"), ErrorCode::kUnwritableOutput);
  host::Volume flat = block();
  flat.voxel_to_world(0, 0) = 0;
  EXPECT_EQ(code_of(flat, "a.vdb"), ErrorCode::kUsage);
}

TEST_F(OpenVdbTest, AnIndexIsAUsdVolumeThatShowsFilesInTurn) {
  const fs::path path = folder_.path() / "clip.usda";
  std::vector<host::VolumeFile> files(3);
  for (std::size_t i = 0; i < files.size(); ++i)
    files[i] = {"clip_000" + std::to_string(i + 1) + ".vdb", 0.04 * static_cast<double>(i), host::box_of(block())};
  files[1].box.setEmpty();
  host::write_volume_index(table_.find("openvdb"), path,
                           {{"content", "both"}, {"vdb-names", "unreal"}, {"units", "cm"}}, files, 25,
                           {{"source", "clip.mkv"}});
  std::ifstream file(path);
  const std::string usd((std::istreambuf_iterator<char>(file)), {});
  constexpr const char* kFiles = "0: @@@./clip_0001.vdb@@@,\n                1: @@@./clip_0002.vdb@@@,\n"
                                 "                2: @@@./clip_0003.vdb@@@,";
  for (const char* part :
       {"#usda 1.0\n", "string source = \"clip.mkv\"", "metersPerUnit = 0.01\n", "upAxis = \"Y\"", "endTimeCode = 2\n",
        "timeCodesPerSecond = 25\n", "def Volume \"volume\"", "rel field:density = </clip/volume/density>",
        "rel field:surface = </clip/volume/surface>", "rel field:color = </clip/volume/color>",
        "token fieldClass = \"levelSet\"", "token fieldDataType = \"half3\"", "token fieldName = \"density\"", kFiles,
        // The block's outermost voxels reach half a voxel further; y and z point the other way.
        "0: [(-1, -7, -205), (9, 1, -199)],\n            2: [("})
    EXPECT_NE(usd.find(part), std::string::npos) << part << "\nis not in\n" << usd;
  EXPECT_THROW(host::write_volume_index(table_.find("openvdb"), "/dev/full", {}, files, 25, {}), Error);
}

} // namespace
} // namespace kinora::formats
