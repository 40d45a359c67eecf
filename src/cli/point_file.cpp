#include "cli/point_file.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::cli {
namespace {

constexpr std::string_view kHeader = "id,x,y,z";

[[noreturn]] void refuse(const std::string& location, std::size_t line, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}, line {}: {}", location, line, why));
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

NamedPoint point_of(std::string_view line, const std::string& location, std::size_t number) {
  const std::vector<std::string_view> cells = cells_of(line);
  if (cells.size() != 4) {
    refuse(location, number,
           fmt::format("{} values instead of the four of {}", line.empty() ? 0 : cells.size(), kHeader));
  }
  if (cells[0].empty() || cells[0].find('"') != std::string_view::npos) {
    refuse(location, number, "the id is empty or holds quotes");
  }
  NamedPoint point{std::string(cells[0]), {}};
  for (std::size_t a = 0; a < 3; ++a) {
    double value = 0;
    const std::string_view cell = cells[a + 1];
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value)) {
      refuse(location, number, fmt::format("\"{}\" is no number of metres", cell));
    }
    point.position[static_cast<Eigen::Index>(a)] = value;
  }
  return point;
}

} // namespace

std::vector<NamedPoint> parse_points(std::string_view text, const std::string& location) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3); // spreadsheets write a byte-order mark
  std::vector<NamedPoint> points;
  std::set<std::string> ids;
  for (std::size_t number = 1; !text.empty() || number == 1; ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (number == 1) {
      if (line != kHeader) refuse(location, 1, fmt::format("the first line must be {}", kHeader));
      continue;
    }
    points.push_back(point_of(line, location, number));
    if (!ids.insert(points.back().id).second)
      refuse(location, number, fmt::format("the id {} came before", points.back().id));
  }
  if (points.empty()) refuse(location, 2, "there is no point");
  return points;
}

std::vector<NamedPoint> read_points(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  if (!file) throw Error(ErrorCode::kCorruptInput, fmt::format("{} cannot be read; is it a file?", path.string()));
  return parse_points(text, path.string());
}

} // namespace kinora::cli
