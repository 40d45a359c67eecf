#include "usd/usd_text.h"

#include <cerrno>
#include <cstring>

#include <Eigen/Geometry>

#include "common/number_text.h"
#include "core/error.h"
#include "core/linear_light.h"

namespace kinora::formats {
namespace {

constexpr int kPositionDecimals = 4; ///< a tenth of a millimetre
constexpr int kTransformDecimals = 7;
constexpr int kTextureDecimals = 5;
constexpr int kColorDecimals = 4;

template <class Vector> void append_vector(std::string& text, const Vector& vector, int decimals) {
  text += '(';
  for (Eigen::Index i = 0; i < vector.size(); ++i) {
    if (i > 0) text += ", ";
    append_number(text, vector[i], decimals);
  }
  text += ')';
}

/// [a, b, …] of what `append(text, i)` appends.
template <class Append> std::string list_of(std::size_t count, const Append& append) {
  std::string text = "[";
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) text += ", ";
    append(text, i);
  }
  return text + "]";
}

std::string list_of_points(const std::vector<Eigen::Vector3f>& points) {
  return list_of(points.size(),
                 [&](std::string& text, std::size_t i) { append_vector(text, points[i], kPositionDecimals); });
}

std::string extent_of(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3f low = points.front();
  Eigen::Vector3f high = points.front();
  for (const Eigen::Vector3f& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return list_of_points({low, high});
}

std::string text_of(const Eigen::Vector3d& vector) {
  std::string text;
  append_vector(text, vector, kTransformDecimals);
  return text;
}

/// w x y z of all transforms, each in the hemisphere of the one before so that tools interpolate the short way.
std::vector<std::string> rotations_of(const BlendedMesh& mesh) {
  std::vector<std::string> rotations;
  Eigen::Vector4d last(1, 0, 0, 0);
  for (std::size_t i = 0; i < mesh.times().size(); ++i) {
    const Eigen::Quaterniond q(mesh.transform(i).linear());
    Eigen::Vector4d values(q.w(), q.x(), q.y(), q.z());
    if (values.dot(last) < 0) values = -values;
    std::string text;
    append_vector(text, values, kTransformDecimals);
    rotations.push_back(std::move(text));
    last = values;
  }
  return rotations;
}

/// `text` with every NAME and every TEXTURE replaced.
std::string filled(std::string text, const std::string& name, const std::string& texture) {
  for (const auto& [word, value] : {std::pair<std::string_view, const std::string&>{"TEXTURE", texture},
                                    std::pair<std::string_view, const std::string&>{"NAME", name}}) {
    std::size_t at = 0;
    while ((at = text.find(word, at)) != std::string::npos) {
      text.replace(at, word.size(), value);
      at += value.size();
    }
  }
  return text;
}

// It shines by itself: light is in the colours already.
constexpr const char* kTexturedSurface = R"(    def Material "NAME_material"
    {
        token outputs:surface.connect = </clip/NAME_material/surface.outputs:surface>

        def Shader "surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0, 0, 0)
            color3f inputs:emissiveColor.connect = </clip/NAME_material/color.outputs:rgb>
            float inputs:roughness = 1
            token outputs:surface
        }

        def Shader "color"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @@@TEXTURE@@@
            float2 inputs:st.connect = </clip/NAME_material/st.outputs:result>
            token inputs:sourceColorSpace = "sRGB"
            token inputs:wrapS = "clamp"
            token inputs:wrapT = "clamp"
            float3 outputs:rgb
        }

        def Shader "st"
        {
            uniform token info:id = "UsdPrimvarReader_float2"
            string inputs:varname = "st"
            float2 outputs:result
        }
    }
)";

constexpr const char* kPlainSurface = R"(    def Material "NAME_material"
    {
        token outputs:surface.connect = </clip/NAME_material/surface.outputs:surface>

        def Shader "surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0, 0, 0)
            color3f inputs:emissiveColor.connect = </clip/NAME_material/color.outputs:result>
            float inputs:roughness = 1
            token outputs:surface
        }

        def Shader "color"
        {
            uniform token info:id = "UsdPrimvarReader_float3"
            string inputs:varname = "displayColor"
            float3 outputs:result
        }
    }
)";

constexpr const char* kMesh = R"(
    def Mesh "NAME" (
        prepend apiSchemas = ["MaterialBindingAPI"]
    )
    {
        rel material:binding = </clip/NAME_material>
)";

} // namespace

std::string usd_name(const std::string& name, std::set<std::string>& taken) {
  std::string made;
  for (const char c : name) {
    const bool allowed = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    made += allowed ? c : '_';
  }
  if (made.empty() || (made[0] >= '0' && made[0] <= '9')) made.insert(made.begin(), '_');
  std::string unique = made;
  for (int number = 2; !taken.insert(unique).second; ++number) unique = made + "_" + std::to_string(number);
  return unique;
}

UsdText::UsdText(std::filesystem::path path, const UsdLayer& layer)
    : path_(std::move(path)), rate_(layer.rate), file_(std::fopen(path_.c_str(), "wb")) {
  if (!file_) fail();
  const double per_metre = layer.axes.per_metre;
  std::string text = usd_layer_head(layer);
  text += "def Xform \"clip\" (\n    kind = \"component\"\n)\n{\n    double xformOp:rotateX = ";
  text += layer.axes.z_up ? "-90" : "180";
  if (per_metre != 1) {
    text += "\n    double3 xformOp:scale = ";
    append_vector(text, Eigen::Vector3d(per_metre, per_metre, per_metre), kTransformDecimals);
  }
  text += "\n    uniform token[] xformOpOrder = [\"xformOp:rotateX\"";
  if (per_metre != 1) text += ", \"xformOp:scale\"";
  text += "]\n";
  put(text);
}

void UsdText::fail() const {
  throw Error(ErrorCode::kUnwritableOutput, path_.string() + " cannot be written: " + std::strerror(errno));
}

void UsdText::put(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size()) fail();
}

void UsdText::put_surface(const BlendedMesh& mesh) {
  put("        uniform token subdivisionScheme = \"none\"\n        int[] faceVertexCounts = ");
  put(list_of(mesh.faces.size(), [](std::string& text, std::size_t /*i*/) { text += '3'; }));
  put("\n        int[] faceVertexIndices = ");
  put(list_of(3 * mesh.faces.size(),
              [&](std::string& text, std::size_t i) { text += std::to_string(mesh.faces[i / 3][i % 3]); }));
  put("\n");
}

void UsdText::put_colors(const BlendedMesh& mesh, bool textured) {
  if (textured) {
    put("        texCoord2f[] primvars:st = ");
    put(list_of(mesh.texture_coordinates.size(), [&](std::string& text, std::size_t i) {
      const Eigen::Vector2f& t = mesh.texture_coordinates[i]; // from the lower left corner there
      append_vector(text, Eigen::Vector2f(t.x(), 1 - t.y()), kTextureDecimals);
    }));
  } else {
    put("        color3f[] primvars:displayColor = ");
    put(list_of(mesh.colors.size(), [&](std::string& text, std::size_t i) {
      Eigen::Vector3f linear;
      for (int c = 0; c < 3; ++c)
        linear[c] = linear_light(static_cast<float>(mesh.colors[i][static_cast<std::size_t>(c)]) / 255);
      append_vector(text, linear, kColorDecimals);
    }));
  }
  put(" (\n            interpolation = \"vertex\"\n        )\n");
}

/// One line of time samples.
void UsdText::put_sample(double seconds, std::string_view value) {
  put("            ");
  put(usd_time_code(seconds, rate_));
  put(": ");
  put(value);
  put(",\n");
}

void UsdText::put_motion(const BlendedMesh& mesh) {
  const std::vector<double>& times = mesh.times();
  if (mesh.motion() != MeshMotion::kBlended) {
    put("        float3[] extent = ");
    put(extent_of(mesh.positions));
    put("\n        point3f[] points = ");
    put(list_of_points(mesh.positions));
    put("\n");
    if (mesh.motion() == MeshMotion::kStill) return;
    put("        double3 xformOp:translate.timeSamples = {\n");
    for (std::size_t i = 0; i < times.size(); ++i) put_sample(times[i], text_of(mesh.transform(i).translation()));
    put("        }\n        quatf xformOp:orient.timeSamples = {\n");
    const std::vector<std::string> rotations = rotations_of(mesh);
    for (std::size_t i = 0; i < times.size(); ++i) put_sample(times[i], rotations[i]);
    put("        }\n        uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]\n");
    return;
  }
  put("        float3[] extent.timeSamples = {\n");
  for (std::size_t i = 0; i < times.size(); ++i) put_sample(times[i], extent_of(mesh.points(i)));
  put("        }\n        point3f[] points.timeSamples = {\n");
  for (std::size_t i = 0; i < times.size(); ++i) put_sample(times[i], list_of_points(mesh.points(i)));
  put("        }\n");
}

void UsdText::put_visibility(const BlendedMesh& mesh) {
  if (!mesh.is_ever_hidden()) return;
  put("        token visibility.timeSamples = {\n");
  for (std::size_t i = 0; i < mesh.times().size(); ++i)
    put_sample(mesh.times()[i], mesh.hidden(i) ? "\"invisible\"" : "\"inherited\"");
  put("        }\n");
}

void UsdText::add(const BlendedMesh& mesh, const std::string& name, const std::string& texture) {
  put(filled(kMesh, name, ""));
  put_surface(mesh);
  put_colors(mesh, !texture.empty());
  put_motion(mesh);
  put_visibility(mesh);
  put("    }\n\n");
  put(filled(texture.empty() ? kPlainSurface : kTexturedSurface, name, texture));
}

void UsdText::finish() {
  put("}\n");
  if (std::fflush(file_.get()) != 0 || std::ferror(file_.get()) != 0) fail();
  if (std::fclose(file_.release()) != 0) fail();
}

} // namespace kinora::formats
