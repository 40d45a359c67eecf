// NumPy's archives of arrays: `.npz`, a ZIP file of `.npy` members.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "ingest/files/npy_array.h"

struct zip;

namespace kinora::ingest {

/// Safe for untrusted input. Not thread-safe.
class NpzArchive {
public:
  /// Of one array, unpacked. What a member says to unpack to counts, and it must unpack to just that.
  static constexpr std::size_t kMaxBytes = std::size_t{16} << 20U;

  /// Throws Error: kCorruptInput if the file is no ZIP archive.
  explicit NpzArchive(const std::filesystem::path& path);

  bool has(const std::string& name) const;
  /// Member `name`.npy. Throws Error(kCorruptInput), naming file and member, if it is not there, too large, packed
  /// otherwise than by deflation, damaged, or no array of finite numbers (parse_npy).
  NpyArray read(const std::string& name) const;

private:
  struct Discard {
    void operator()(zip* archive) const;
  };
  std::string path_;
  std::unique_ptr<zip, Discard> archive_;
};

} // namespace kinora::ingest
