// An output beside which its format may put further files, such as textures.
#pragma once

#include <optional>

#include "cli/output_file.h"
#include "cli/staged_files.h"
#include "kinora/plugin.h"

namespace kinora::cli {

/// Nothing is seen under its name until commit().
class OutputWithFiles {
public:
  /// As OutputFile. Throws Error(kUnwritableOutput); kUsage.
  OutputWithFiles(const std::filesystem::path& path, const KinoraFormat& format, bool overwrite,
                  const std::vector<std::filesystem::path>& inputs);

  /// Where the format is to write.
  std::filesystem::path writing_path() const;
  /// Moves all to its place, the output itself last. Returns the bytes of all files, as far as they can be told.
  /// Throws Error(kUnwritableOutput) for a file that is there and must stay.
  std::uintmax_t commit();

private:
  bool overwrite_;
  OutputFile output_;
  std::filesystem::path path_;
  std::optional<StagedFiles> files_; ///< for formats that put files beside the output
};

} // namespace kinora::cli
