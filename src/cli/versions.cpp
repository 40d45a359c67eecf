#include "cli/versions.h"

#include <CLI/CLI.hpp>
#include <Eigen/Core>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace kinora::cli {

std::string version_text() {
  return fmt::format("kinora {}\n"
                     "CLI11 {}\n"
                     "Eigen {}.{}.{}\n"
                     "fmt {}.{}.{}\n"
                     "nlohmann-json {}.{}.{}\n"
                     "{}",
                     KINORA_VERSION, CLI11_VERSION, EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION,
                     FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100, NLOHMANN_JSON_VERSION_MAJOR,
                     NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH, KINORA_LIBRARY_VERSIONS);
}

} // namespace kinora::cli
