// Numbers and tables as a person reads them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace kinora::cli {

/// "832 B", "12.4 kB", "3.07 MB": powers of 1000, three digits.
std::string format_bytes(std::size_t bytes);

/// Rows of cells in aligned columns, two spaces apart; columns of numbers are aligned right.
class Table {
public:
  explicit Table(std::vector<std::string> head) { rows_.push_back(std::move(head)); }
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  /// Each line is indented by two spaces and ends with a line feed.
  std::string str() const;

private:
  std::vector<std::vector<std::string>> rows_;
};

} // namespace kinora::cli
