#include "ingest/files/body_mesh.h"

#include <cstdint>
#include <fstream>
#include <map>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zip.h>

#include "core/error.h"
#include "formats/sample_capture.h"
#include "fuzz/mutate.h"
#include "ingest/files/npz_archive.h"
#include "npy_bytes.h"

namespace kinora::ingest {
namespace {

using testing::npy;
using Bytes = std::vector<std::byte>;
using Members = std::map<std::string, Bytes>;

constexpr std::size_t kVertices = 23; // one at each joint, and one above
constexpr std::size_t kJoints = 24;   // as SMPL has them

Eigen::Vector3d place_of(std::size_t vertex) {
  const auto i = static_cast<double>(vertex);
  return {0.01 * i, 0.08 * i - 0.9, 0.02};
}

std::string shape_of(std::size_t rows, std::size_t columns) { return fmt::format("({}, {})", rows, columns); }

Members model() {
  std::vector<double> vertices;
  std::vector<float> weights(kVertices * kJoints);
  std::vector<double> regressor(kJoints * kVertices);
  std::vector<std::uint32_t> tree(2 * kJoints);
  for (std::size_t i = 0; i < kVertices; ++i) {
    for (const double x : place_of(i)) vertices.push_back(x);
    weights[i * kJoints + std::min(i, kBodyMeshJoints - 1)] = 0.75F;
    weights[i * kJoints + kJoints - 1] += 0.25F;
  }
  for (std::size_t j = 0; j < kJoints; ++j) {
    regressor[j * kVertices + std::min(j, kVertices - 1)] = 1;
    tree[j] = j < kBodyMeshJoints ? static_cast<std::uint32_t>(kBodyMeshParents.at(j)) : 20;
    tree[kJoints + j] = static_cast<std::uint32_t>(j);
  }
  return {{"v_template.npy", npy("<f8", shape_of(kVertices, 3), vertices)},
          {"weights.npy", npy("<f4", shape_of(kVertices, kJoints), weights)},
          {"J_regressor.npy", npy("<f8", shape_of(kJoints, kVertices), regressor)},
          {"kintree_table.npy", npy("<u4", shape_of(2, kJoints), tree)},
          {"f.npy", npy<std::uint32_t>("<u4", "(2, 3)", {0, 1, 2, 1, 2, 22})}};
}

class BodyMeshFile : public ::testing::Test {
protected:
  std::filesystem::path write(const Members& members, zip_int32_t method = ZIP_CM_DEFLATE) {
    std::filesystem::path path = folder_.path() / "body.npz";
    int error = 0;
    zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
    for (const auto& [name, bytes] : members) {
      zip_source_t* source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
      const zip_int64_t index = zip_file_add(archive, name.c_str(), source, 0);
      EXPECT_GE(index, 0);
      EXPECT_EQ(zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), method, 0), 0);
    }
    EXPECT_EQ(zip_close(archive), 0);
    return path;
  }

  std::filesystem::path write(const Bytes& bytes) {
    std::filesystem::path path = folder_.path() / "body.npz";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    return path;
  }

  // The error's sentence; empty if there is none.
  static std::string refusal(const std::filesystem::path& path) {
    try {
      read_body_mesh(path);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kCorruptInput);
      EXPECT_NE(std::string(error.what()).find(path.string()), std::string::npos) << error.what();
      return error.what();
    }
    return {};
  }

  std::string refusal_with(const std::string& name, const Bytes& bytes) {
    Members members = model();
    members[name + ".npy"] = bytes;
    std::string sentence = refusal(write(members));
    EXPECT_NE(sentence.find("array " + name), std::string::npos) << sentence;
    return sentence;
  }

  test::TemporaryFolder folder_;
};

TEST_F(BodyMeshFile, IsReadStoredOrDeflated) {
  for (const zip_int32_t method : {ZIP_CM_STORE, ZIP_CM_DEFLATE}) {
    const BodyMesh mesh = read_body_mesh(write(model(), method));
    ASSERT_EQ(mesh.vertices.size(), kVertices);
    EXPECT_EQ(mesh.vertices[22], place_of(22));
    EXPECT_EQ(mesh.joints[19], place_of(19));
    EXPECT_EQ(mesh.bone[7], 7U);
    EXPECT_EQ(mesh.faces[1], (std::array<std::size_t, 3>{1, 2, 22}));
  }
}

TEST_F(BodyMeshFile, IsReadBesideArraysThatAreNotNeeded) {
  Members members = model();
  members["posedirs.npy"] = Bytes(100);
  members["J_regressor_prior.npy"] =
      testing::npy_with_header("{'descr': '|O', 'fortran_order': False, 'shape': (), }", {});
  EXPECT_EQ(refusal(write(members)), "");
}

TEST_F(BodyMeshFile, IsRefusedWithoutAnArray) {
  for (const auto& [name, bytes] : model()) {
    Members members = model();
    members.erase(name);
    EXPECT_NE(refusal(write(members)).find("it is not there"), std::string::npos) << name;
  }
}

TEST_F(BodyMeshFile, IsRefusedWithShapesThatDoNotGoTogether) {
  EXPECT_NE(refusal_with("weights", npy<float>("<f4", "(2, 3)", {1, 0, 0, 1, 0, 0})).find("not (23, 24)"),
            std::string::npos);
  EXPECT_NE(refusal_with("J_regressor", npy<double>("<f8", "(3,)", {1, 2, 3})).find("its shape is (3)"),
            std::string::npos);
  EXPECT_NE(refusal_with("v_template", npy<double>("<f8", "(1, 2)", {1, 2})).find("not (any, 3)"), std::string::npos);
  EXPECT_NE(refusal_with("f", npy<std::int32_t>("<i4", "(0, 3)", {})).find("0 faces"), std::string::npos);
}

TEST_F(BodyMeshFile, IsRefusedWithASparseRegressor) {
  const Bytes object = testing::npy_with_header("{'descr': '|O', 'fortran_order': False, 'shape': (), }", Bytes(8));
  EXPECT_NE(refusal_with("J_regressor", object).find("pickled objects"), std::string::npos);
}

TEST_F(BodyMeshFile, IsRefusedWithContentsThatAreNoPerson) {
  std::vector<double> small(4 * 3, 0.1);
  EXPECT_NE(refusal_with("v_template", npy("<f8", "(4, 3)", small)).find("give metres"), std::string::npos);
  std::vector<std::uint32_t> chain(2 * kJoints);
  EXPECT_NE(refusal_with("kintree_table", npy("<u4", shape_of(2, kJoints), chain)).find("SMPL"), std::string::npos);
  std::vector<float> heavy(kVertices * kJoints, 1);
  EXPECT_NE(refusal_with("weights", npy("<f4", shape_of(kVertices, kJoints), heavy)).find("vertex 0"),
            std::string::npos);
  std::vector<double> far(kJoints * kVertices, 100);
  EXPECT_NE(refusal_with("J_regressor", npy("<f8", shape_of(kJoints, kVertices), far)).find("joint 0"),
            std::string::npos);
  for (const std::int32_t vertex : {-1, 23}) {
    EXPECT_NE(refusal_with("f", npy<std::int32_t>("<i4", "(1, 3)", {0, 1, vertex})).find("face 0"), std::string::npos);
  }
  EXPECT_NE(refusal_with("f", npy<float>("<f4", "(1, 3)", {0, 1, 0.5F})).find("face 0"), std::string::npos);
}

// Hardly any bytes that unpack to more than is ever read.
TEST_F(BodyMeshFile, IsRefusedBeforeItUnpacksToTooMuch) {
  EXPECT_NE(refusal_with("f", Bytes(NpzArchive::kMaxBytes + 1)).find("unpacks to more than 16 MiB"), std::string::npos);
}

TEST_F(BodyMeshFile, IsRefusedAtEveryTruncation) {
  const std::filesystem::path path = write(model());
  const std::uintmax_t size = std::filesystem::file_size(path);
  for (std::uintmax_t cut = size - 1; cut > 37; cut -= 37) {
    std::filesystem::resize_file(path, cut);
    EXPECT_NE(refusal(path), "") << cut;
  }
  std::filesystem::resize_file(path, 0);
  EXPECT_NE(refusal(path), "");
}

// Whatever is changed, it is refused as corrupt, or read as a body.
TEST_F(BodyMeshFile, SurvivesMutation) {
  for (const zip_int32_t method : {ZIP_CM_STORE, ZIP_CM_DEFLATE}) {
    std::ifstream file(write(model(), method), std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    const auto view = std::as_bytes(std::span(text));
    const Bytes whole(view.begin(), view.end());
    Random random(1);
    for (int i = 0; i < 1500; ++i) refusal(write(fuzz::mutate(whole, random)));
  }
  // Damage that the archive's checksums would hide from the reader.
  Random random(2);
  for (int i = 0; i < 1500; ++i) {
    Members members = model();
    auto member = members.begin();
    std::advance(member, random.below(static_cast<std::uint32_t>(members.size())));
    member->second = fuzz::mutate(member->second, random);
    refusal(write(members, ZIP_CM_STORE));
  }
}

} // namespace
} // namespace kinora::ingest
