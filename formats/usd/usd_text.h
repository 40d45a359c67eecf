// The text of a USD layer, written piece by piece: it is never whole in memory.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <string_view>

#include "common/blended_mesh.h"
#include "common/usd_layer.h"

namespace kinora::formats {

/// Letters, digits and '_', not beginning with a digit, and not among `taken`, to which it is added.
std::string usd_name(const std::string& name, std::set<std::string>& taken);

class UsdText {
public:
  /// Begins the file. Time codes are kept to a thousandth. Throws Error(kUnwritableOutput).
  UsdText(std::filesystem::path path, const UsdLayer& layer);

  /// A mesh and its material. `texture`: the file of its texture beside this one; empty if it has colours.
  void add(const BlendedMesh& mesh, const std::string& name, const std::string& texture);
  /// Throws Error(kUnwritableOutput), also when the disk is full.
  void finish();

private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void put(std::string_view text);
  void put_surface(const BlendedMesh& mesh);
  void put_colors(const BlendedMesh& mesh, bool textured);
  void put_motion(const BlendedMesh& mesh);
  void put_visibility(const BlendedMesh& mesh);
  void put_sample(double seconds, std::string_view value);
  [[noreturn]] void fail() const;

  std::filesystem::path path_;
  double rate_;
  std::unique_ptr<std::FILE, Close> file_;
};

} // namespace kinora::formats
