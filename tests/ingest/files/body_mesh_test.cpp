#include "ingest/files/body_mesh.h"

#include <cstdint>
#include <fstream>

#include <gtest/gtest.h>

#include "body_file.h"
#include "core/error.h"
#include "formats/sample_capture.h"
#include "fuzz/mutate.h"
#include "ingest/files/npz_archive.h"

namespace kinora::ingest {
namespace {

using testing::BodyFile;
using testing::kBodyFileJoints;
using testing::kBodyFileVertices;
using testing::npy;
using testing::place_of;
using testing::shape_of;
using testing::write_npz;
using Bytes = std::vector<std::byte>;

class BodyMeshFile : public ::testing::Test {
protected:
  std::filesystem::path write(const BodyFile& members, zip_int32_t method = ZIP_CM_DEFLATE) {
    std::filesystem::path path = folder_.path() / "body.npz";
    write_npz(path, members, method);
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
    BodyFile members = testing::body_file();
    members[name + ".npy"] = bytes;
    std::string sentence = refusal(write(members));
    EXPECT_NE(sentence.find("array " + name), std::string::npos) << sentence;
    return sentence;
  }

  test::TemporaryFolder folder_;
};

TEST_F(BodyMeshFile, IsReadStoredOrDeflated) {
  for (const zip_int32_t method : {ZIP_CM_STORE, ZIP_CM_DEFLATE}) {
    const BodyMesh mesh = read_body_mesh(write(testing::body_file(), method));
    ASSERT_EQ(mesh.vertices.size(), kBodyFileVertices);
    EXPECT_EQ(mesh.vertices[22], place_of(22));
    EXPECT_EQ(mesh.joints[19], place_of(19));
    EXPECT_EQ(mesh.bone[7], 7U);
    EXPECT_EQ(mesh.faces[1], (std::array<std::size_t, 3>{1, 2, 22}));
  }
}

TEST_F(BodyMeshFile, IsReadBesideArraysThatAreNotNeeded) {
  BodyFile members = testing::body_file();
  members["posedirs.npy"] = Bytes(100);
  members["J_regressor_prior.npy"] =
      testing::npy_with_header("{'descr': '|O', 'fortran_order': False, 'shape': (), }", {});
  EXPECT_EQ(refusal(write(members)), "");
}

TEST_F(BodyMeshFile, IsRefusedWithoutAnArray) {
  for (const auto& [name, bytes] : testing::body_file()) {
    BodyFile members = testing::body_file();
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
  std::vector<std::uint32_t> chain(2 * kBodyFileJoints);
  EXPECT_NE(refusal_with("kintree_table", npy("<u4", shape_of(2, kBodyFileJoints), chain)).find("SMPL"),
            std::string::npos);
  std::vector<float> heavy(kBodyFileVertices * kBodyFileJoints, 1);
  EXPECT_NE(refusal_with("weights", npy("<f4", shape_of(kBodyFileVertices, kBodyFileJoints), heavy)).find("vertex 0"),
            std::string::npos);
  std::vector<double> far(kBodyFileJoints * kBodyFileVertices, 100);
  EXPECT_NE(refusal_with("J_regressor", npy("<f8", shape_of(kBodyFileJoints, kBodyFileVertices), far)).find("joint 0"),
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
  const std::filesystem::path path = write(testing::body_file());
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
    std::ifstream file(write(testing::body_file(), method), std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    const auto view = std::as_bytes(std::span(text));
    const Bytes whole(view.begin(), view.end());
    Random random(1);
    for (int i = 0; i < 1500; ++i) refusal(write(fuzz::mutate(whole, random)));
  }
  // Damage that the archive's checksums would hide from the reader.
  Random random(2);
  for (int i = 0; i < 1500; ++i) {
    BodyFile members = testing::body_file();
    auto member = members.begin();
    std::advance(member, random.below(static_cast<std::uint32_t>(members.size())));
    member->second = fuzz::mutate(member->second, random);
    refusal(write(members, ZIP_CM_STORE));
  }
}

} // namespace
} // namespace kinora::ingest
