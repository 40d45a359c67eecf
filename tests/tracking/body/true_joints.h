// Where a synthetic capture's gt/joints.csv says that the person's joints are.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinora::tracking::testing {

/// Positions in the capture camera, metres, by frame and the rig's name of the joint.
using TrueJoints = std::map<int, std::map<std::string, Eigen::Vector3d>>;

/// Empty if there is no such file.
inline TrueJoints read_true_joints(const std::filesystem::path& capture) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    return cells;
  };
  TrueJoints joints;
  std::ifstream file(capture / "gt" / "joints.csv");
  std::string line;
  if (!std::getline(file, line)) return joints;
  const std::vector<std::string> header = split(line);
  while (std::getline(file, line)) {
    const std::vector<std::string> cells = split(line);
    for (std::size_t i = 1; i + 2 < cells.size(); i += 3) {
      const std::string name = header[i].substr(0, header[i].size() - 2); // without _x
      joints[std::stoi(cells[0])][name] = {std::stod(cells[i]), std::stod(cells[i + 1]), std::stod(cells[i + 2])};
    }
  }
  return joints;
}

} // namespace kinora::tracking::testing
