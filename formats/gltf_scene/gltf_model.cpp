#include "gltf_scene/gltf_model.h"

#include <algorithm>
#include <cstring>

#include "common/files.h"
#include "core/error.h"
#include "core/image_codec.h"

namespace kinora::formats {
namespace fs = std::filesystem;

namespace {

/// Required extensions whose absence of support changes nothing, or that the accessors understand.
constexpr const char* kKnownExtensions[] = {"KHR_mesh_quantization", "KHR_materials_unlit"};

bool decode(tinygltf::Image* image, const int number, std::string* error, std::string* /*warning*/, int /*width*/,
            int /*height*/, const unsigned char* bytes, int size, void* /*user*/) {
  try {
    const std::span data(reinterpret_cast<const std::byte*>(bytes), static_cast<std::size_t>(std::max(size, 0)));
    const ColorImage color = decode_color(data, "picture " + std::to_string(number));
    image->width = color.width();
    image->height = color.height();
    image->component = color.channels();
    image->bits = 8;
    image->pixel_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
    image->image.assign(color.values().begin(), color.values().end());
    return true;
  } catch (const Error& problem) {
    *error += problem.what();
    return false;
  }
}

/// Whether a path lies in the folder that `user` points to.
bool is_inside(const std::string& path, void* user) {
  const fs::path& folder = *static_cast<const fs::path*>(user);
  std::error_code error;
  const fs::path inside = fs::weakly_canonical(path, error).lexically_relative(folder);
  return !error && !inside.empty() && *inside.begin() != "..";
}

bool exists_inside(const std::string& path, void* user) {
  std::error_code ignored;
  return is_inside(path, user) && fs::is_regular_file(path, ignored);
}

bool read_inside(std::vector<unsigned char>* out, std::string* error, const std::string& path, void* user) {
  try {
    if (!is_inside(path, user)) throw Error(ErrorCode::kCorruptInput, path + ": lies outside of the file's folder");
    const std::vector<std::byte> bytes = read_file(path);
    const auto* const first = reinterpret_cast<const unsigned char*>(bytes.data());
    out->assign(first, first + bytes.size());
    return true;
  } catch (const Error& problem) {
    *error += problem.what();
    return false;
  }
}

/// One line of what the library says.
std::string sentence(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  while (!text.empty() && (text.back() == ' ' || text.back() == '.')) text.pop_back();
  return text.empty() ? "no reason given" : text;
}

} // namespace

tinygltf::Model load_gltf_model(const fs::path& path) {
  const auto fail = [&path](const std::string& problem) {
    throw Error(ErrorCode::kCorruptInput, path.string() + ": " + problem);
  };
  const std::vector<std::byte> bytes = read_file(path);
  std::error_code ignored;
  fs::path folder = fs::weakly_canonical(fs::absolute(path), ignored).parent_path();
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(decode, nullptr);
  loader.SetFsCallbacks(
      {exists_inside, [](const std::string& name, void*) { return name; }, read_inside,
       [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) { return false; }, &folder});
  tinygltf::Model model;
  std::string error;
  std::string warning;
  bool loaded = false;
  try {
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    const auto size = static_cast<unsigned>(bytes.size());
    const bool binary = bytes.size() >= 4 && std::memcmp(data, "glTF", 4) == 0;
    loaded = binary ? loader.LoadBinaryFromMemory(&model, &error, &warning, data, size, folder.string())
                    : loader.LoadASCIIFromString(&model, &error, &warning, reinterpret_cast<const char*>(data), size,
                                                 folder.string());
  } catch (const std::exception& problem) {
    error = problem.what();
  }
  if (!loaded) fail("cannot be read as glTF 2.0 (" + sentence(error) + ")");
  for (const std::string& extension : model.extensionsRequired)
    if (std::ranges::find(kKnownExtensions, extension) == std::end(kKnownExtensions))
      fail("needs the extension " + extension + ", which is not read; export it without");
  return model;
}

} // namespace kinora::formats
