// Whole files in and out of memory, and numbers out of text.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::formats {

/// All bytes of a regular file of at most 1 GiB. Throws Error(kCorruptInput) naming the path.
std::vector<std::byte> read_file(const std::filesystem::path& path);

/// The same as text.
std::string read_text(const std::filesystem::path& path);

/// Replaces the file. Throws Error(kUnwritableOutput) naming the path, also when the disk is full.
void write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);

/// Replaces a file piece by piece. Each call throws Error(kUnwritableOutput) naming the path.
class FileWriter {
public:
  explicit FileWriter(std::filesystem::path path);
  void write(std::span<const std::byte> bytes);
  /// All is written, as far as the system says.
  void finish();

private:
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

/// The words of a text, split at white space and commas. They point into `text`.
std::vector<std::string_view> split_words(std::string_view text);

/// The lines of a text without their ends. They point into `text`.
std::vector<std::string_view> split_lines(std::string_view text);

/// The whole word as a number, in the C locale ("7.0e-001", "nan", "-inf" too); nothing if it is none.
std::optional<double> parse_number(std::string_view word);

/// Regular files of a folder by name, in the order of their names; empty if there is no such folder.
std::vector<std::filesystem::path> list_files(const std::filesystem::path& folder);

/// ".jpg", ".jpeg" or ".png" in any case.
bool is_image_name(const std::filesystem::path& path);

} // namespace kinora::formats
