#include "ingest/depth/registration_json.h"

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::ingest {
namespace {

nlohmann::json to_json(const Intrinsics& k) {
  return {{"width", k.width}, {"height", k.height}, {"fx", k.fx}, {"fy", k.fy}, {"cx", k.cx}, {"cy", k.cy}};
}

Intrinsics intrinsics_from(const nlohmann::json& json, const std::string& source) {
  const Intrinsics k{json.at("width").get<int>(), json.at("height").get<int>(), json.at("fx").get<double>(),
                     json.at("fy").get<double>(), json.at("cx").get<double>(),  json.at("cy").get<double>()};
  k.validate(source);
  return k;
}

} // namespace

nlohmann::json to_json(const RegistrationGeometry& geometry) {
  nlohmann::json matrix = nlohmann::json::array();
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) matrix.push_back(geometry.depth_to_color(r, c));
  }
  return {
      {"depth", to_json(geometry.depth)}, {"color", to_json(geometry.color)}, {"depth_to_color", std::move(matrix)}};
}

RegistrationGeometry registration_from_json(const nlohmann::json& json, const std::string& source) {
  try {
    RegistrationGeometry geometry{intrinsics_from(json.at("depth"), source), intrinsics_from(json.at("color"), source),
                                  SE3::Identity()};
    const auto values = json.at("depth_to_color").get<std::array<double, 16>>();
    const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(values.data());
    geometry.depth_to_color = rigid_from_matrix(matrix, source.c_str());
    return geometry;
  } catch (const nlohmann::json::exception& problem) {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", source, problem.what()));
  }
}

} // namespace kinora::ingest
