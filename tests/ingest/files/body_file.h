// A body as SMPL's files hold one, of few vertices.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zip.h>

#include "ingest/files/body_mesh.h"
#include "ingest/files/npy_bytes.h"

namespace kinora::ingest::testing {

/// Members of an .npz file.
using BodyFile = std::map<std::string, std::vector<std::byte>>;

inline constexpr std::size_t kBodyFileVertices = 23; ///< one at each joint, and one above
inline constexpr std::size_t kBodyFileJoints = 24;   ///< as SMPL has them

inline Eigen::Vector3d place_of(std::size_t vertex) {
  const auto i = static_cast<double>(vertex);
  return {0.01 * i, 0.08 * i - 0.9, 0.02};
}

inline std::string shape_of(std::size_t rows, std::size_t columns) { return fmt::format("({}, {})", rows, columns); }

inline BodyFile body_file() {
  constexpr std::size_t kJoints = kBodyFileJoints;
  constexpr std::size_t kVertices = kBodyFileVertices;
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

inline void write_npz(const std::filesystem::path& path, const BodyFile& members, zip_int32_t method = ZIP_CM_DEFLATE) {
  int error = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &error);
  for (const auto& [name, bytes] : members) {
    zip_source_t* source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
    const zip_int64_t index = zip_file_add(archive, name.c_str(), source, 0);
    EXPECT_GE(index, 0);
    EXPECT_EQ(zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), method, 0), 0);
  }
  EXPECT_EQ(zip_close(archive), 0);
}

} // namespace kinora::ingest::testing
