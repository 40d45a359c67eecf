#include "player/gl/gl_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <shader_sources.h>

#include "core/error.h"
#include "fields/network/field_batch.h"
#include "fields/rendering/projected_layer.h"
#include "fields/rendering/ray_marching.h"

namespace kinora::player::gl {
namespace {

using fields::DensityBricks;
using fields::FieldConfig;
using fields::ProjectedLayer;
constexpr int kRow = 2048; // texels in a row of a table, as in the shaders
constexpr int kMaxSide = 16384;
static_assert(FieldConfig::kHidden == 16 && FieldConfig::kColorHidden == 32 && FieldConfig::kVectors == 1 &&
              FieldConfig::kFeatures == 8 && fields::FieldLimits::kMaxLevels == 8);

/// Textures of a layer that do not change with time.
struct LayerTextures {
  fields::DrawableField field; // holds what is derived from it where it is
  GLuint index = 0, atlas = 0, cells = 0, table = 0, nets = 0;
  int atlas_bricks = 1;
  std::vector<std::array<GLint, 4>> levels;
};

/// Four weights to a texel, in the order in which shade.frag reads them.
std::vector<float> net_texels(const fields::DrawableField::Derived& layer) {
  const fields::Field& field = layer.field;
  constexpr int kColors = FieldConfig::kColorOutputs;
  std::vector<float> texels(field.density_net.begin(),
                            field.density_net.begin() + field.config.encoding_width() * FieldConfig::kHidden);
  texels.insert(texels.end(), layer.surface_matrix.begin(), layer.surface_matrix.end());
  const float* net = field.color_net.data();
  texels.insert(texels.end(), net + fields::kColorSecond, net + fields::kColorThird);
  for (int i = 0; i < FieldConfig::kColorHidden; ++i) {
    const float* row = net + fields::kColorThird + i * kColors;
    texels.insert(texels.end(), row, row + 4);
  }
  for (std::size_t i = 0; i < FieldConfig::kHidden; ++i) {
    const float* row = layer.vector_matrix.data() + 3 * i;
    texels.insert(texels.end(), {row[0], row[1], row[2], 0});
  }
  return texels;
}

/// All bricks side by side in a cube, nine samples along each side of one.
std::vector<std::uint8_t> atlas_of(const DensityBricks& bricks, int per_side) {
  constexpr int kLevels = DensityBricks::kLevels;
  const auto side = static_cast<std::size_t>(per_side) * std::size_t{kLevels};
  std::vector<std::uint8_t> atlas(side * side * side, 0);
  for (std::size_t b = 0; b < bricks.count(); ++b) {
    const auto n = static_cast<std::size_t>(per_side);
    const std::array<std::size_t, 3> first{b % n * kLevels, b / n % n * kLevels, b / (n * n) * kLevels};
    const std::uint16_t* pairs = bricks.pairs() + b * DensityBricks::kPairs;
    for (std::size_t z = 0; z < kLevels; ++z) {
      for (std::size_t y = 0; y < kLevels; ++y) {
        const std::size_t lower = std::min<std::size_t>(y, DensityBricks::kSide - 1);
        for (std::size_t x = 0; x < kLevels; ++x) {
          const int pair = pairs[(z * DensityBricks::kSide + lower) * kLevels + x];
          atlas[((first[2] + z) * side + first[1] + y) * side + first[0] + x] =
              static_cast<std::uint8_t>(y == lower ? pair & 255 : pair >> 8);
        }
      }
    }
  }
  return atlas;
}

} // namespace

class GlRenderer::State {
public:
  explicit State(const GetFunction& get) : gl_(get) {
    const auto text = [this](GLenum what) {
      const auto* value = reinterpret_cast<const char*>(gl_.GetString(what));
      return std::string(value == nullptr ? "" : value);
    };
    name_ = text(GL_RENDERER);
    is_es_ = text(GL_VERSION).find("OpenGL ES") != std::string::npos;
    rasterising_ = program(surfaces_vert, surfaces_frag);
    inside_ = program(inside_vert, surfaces_frag);
    shading_ = program(screen_vert, shade_frag);
    gl_.GenVertexArrays(1, &mesh_array_);
    gl_.GenVertexArrays(1, &empty_array_);
    gl_.GenBuffers(1, &vertices_);
    gl_.GenBuffers(1, &faces_);
    gl_.GenFramebuffers(static_cast<GLsizei>(framebuffers_.size()), framebuffers_.data());
    cell_corners_ = texture(GL_TEXTURE_2D, GL_NEAREST);
    bricks_there_ = texture(GL_TEXTURE_3D, GL_NEAREST);
  }
  ~State() {
    for (const GLuint p : {rasterising_, inside_, shading_}) gl_.DeleteProgram(p);
    for (const GLuint array : {mesh_array_, empty_array_}) gl_.DeleteVertexArrays(1, &array);
    for (const GLuint buffer : {vertices_, faces_}) gl_.DeleteBuffers(1, &buffer);
    gl_.DeleteFramebuffers(static_cast<GLsizei>(framebuffers_.size()), framebuffers_.data());
    for (const GLuint t : {cell_corners_, bricks_there_}) gl_.DeleteTextures(1, &t);
    delete_targets();
    for (auto& [derived, layer] : layers_) {
      for (const GLuint t : {layer.index, layer.atlas, layer.cells, layer.table, layer.nets}) gl_.DeleteTextures(1, &t);
    }
  }

  const std::string& name() const { return name_; }
  GLuint drawn() const { return drawn_; }

  void draw(std::span<const fields::PosedField> layers, const Camera& camera) {
    camera_ = camera;
    resize(camera.intrinsics.width, camera.intrinsics.height);
    std::vector<ProjectedLayer> views;
    views.reserve(layers.size());
    for (const fields::PosedField& posed : layers) {
      if (posed.field->derived().bricks.count() == 0) continue;
      upload(*posed.field);
      views.emplace_back(posed, camera);
    }
    gl_.Viewport(0, 0, width_, height_);
    gl_.CullFace(GL_BACK);
    gl_.FrontFace(GL_CCW);
    const std::array<float, 4> nothing{};
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[2]);
    gl_.ClearBufferfv(GL_COLOR, 0, nothing.data());
    for (int peel = 0; peel < kMaxSurfaces; ++peel) {
      find_surfaces(views, peel);
      shade(views, peel);
    }
    check("drawing");
  }

  ColorImage read() {
    ColorImage image(width_, height_, 4);
    std::vector<float> texels(4 * image.pixel_count());
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[2]);
    gl_.ReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, texels.data());
    check("reading the picture");
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        const int number = 4 * ((height_ - 1 - v) * width_ + u);
        const float* texel = texels.data() + number;
        if (!(texel[3] > 0)) continue;
        const float alpha = texel[3] > 1 - 2 * fields::kOpaque ? 1 : texel[3];
        std::uint8_t* out = image.pixel(u, v);
        const auto byte = [](float x) {
          return static_cast<std::uint8_t>(std::lround(255 * std::clamp(x, 0.0F, 1.0F)));
        };
        for (int c = 0; c < 3; ++c) out[c] = byte(texel[c] / texel[3]);
        out[3] = byte(alpha);
      }
    }
    return image;
  }

private:
  [[noreturn]] static void fail(const std::string& what) {
    throw Error(ErrorCode::kFailure, "OpenGL: " + what + "; draw by the CPU");
  }
  void check(const char* doing) {
    if (const GLenum error = gl_.GetError(); error != GL_NO_ERROR) {
      fail(std::string(doing) + " failed with " + (error == GL_OUT_OF_MEMORY ? "too little memory" : "error ") +
           (error == GL_OUT_OF_MEMORY ? "" : std::to_string(error)));
    }
  }

  GLuint shader(GLenum kind, const char* source) {
    const char* prefix =
        is_es_ ? "#version 300 es\nprecision highp float;\nprecision highp int;\n" : "#version 330 core\n";
    const std::array<const char*, 2> parts{prefix, source};
    const GLuint made = gl_.CreateShader(kind);
    gl_.ShaderSource(made, 2, parts.data(), nullptr);
    gl_.CompileShader(made);
    GLint good = 0;
    gl_.GetShaderiv(made, GL_COMPILE_STATUS, &good);
    if (good == 0) {
      std::array<char, 1024> log{};
      gl_.GetShaderInfoLog(made, static_cast<GLsizei>(log.size()), nullptr, log.data());
      fail(std::string("its compiler refuses a shader: ") + log.data());
    }
    return made;
  }
  GLuint program(const char* vertex, const char* fragment) {
    const GLuint made = gl_.CreateProgram();
    for (const GLuint part : {shader(GL_VERTEX_SHADER, vertex), shader(GL_FRAGMENT_SHADER, fragment)}) {
      gl_.AttachShader(made, part);
      gl_.DeleteShader(part);
    }
    GLuint number = 0;
    for (const char* attribute : {"a_corner", "a_position", "a_view_vector", "a_rotation"}) {
      gl_.BindAttribLocation(made, number++, attribute);
    }
    gl_.LinkProgram(made);
    GLint good = 0;
    gl_.GetProgramiv(made, GL_LINK_STATUS, &good);
    if (good == 0) {
      std::array<char, 1024> log{};
      gl_.GetProgramInfoLog(made, static_cast<GLsizei>(log.size()), nullptr, log.data());
      fail(std::string("shaders cannot be linked: ") + log.data());
    }
    return made;
  }

  GLuint texture(GLenum kind, GLint filter) {
    GLuint made = 0;
    gl_.GenTextures(1, &made);
    gl_.BindTexture(kind, made);
    gl_.TexParameteri(kind, GL_TEXTURE_MIN_FILTER, filter);
    gl_.TexParameteri(kind, GL_TEXTURE_MAG_FILTER, filter);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) gl_.TexParameteri(kind, axis, GL_CLAMP_TO_EDGE);
    if (kind == GL_TEXTURE_3D) gl_.TexParameteri(kind, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
    return made;
  }
  /// A table of texels of four numbers each in rows of kRow.
  template <class T> void fill_table(GLuint table, GLint format, GLenum layout, GLenum type, std::vector<T> values) {
    const std::size_t rows = std::max<std::size_t>(1, (values.size() / 4 + kRow - 1) / kRow);
    values.resize(4 * rows * kRow, T{});
    gl_.BindTexture(GL_TEXTURE_2D, table);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, format, kRow, static_cast<GLsizei>(rows), 0, layout, type, values.data());
  }

  void upload(const fields::DrawableField& field) {
    const auto& derived = field.derived();
    if (layers_.contains(&derived)) return;
    LayerTextures layer{field, 0, 0, 0, 0, 0, 1, {}};
    gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    const DensityBricks& bricks = derived.bricks;
    const int n = bricks.bricks_per_side();
    layer.index = texture(GL_TEXTURE_3D, GL_NEAREST);
    gl_.TexImage3D(GL_TEXTURE_3D, 0, GL_R32I, n, n, n, 0, GL_RED_INTEGER, GL_INT, bricks.index());
    while (static_cast<std::size_t>(layer.atlas_bricks) * layer.atlas_bricks * layer.atlas_bricks < bricks.count()) {
      ++layer.atlas_bricks;
    }
    const GLsizei side = DensityBricks::kLevels * layer.atlas_bricks;
    layer.atlas = texture(GL_TEXTURE_3D, GL_LINEAR);
    gl_.TexImage3D(GL_TEXTURE_3D, 0, GL_R8, side, side, side, 0, GL_RED, GL_UNSIGNED_BYTE,
                   atlas_of(bricks, layer.atlas_bricks).data());
    std::vector<std::int32_t> cells;
    for (const auto& of_brick : derived.proxy_mesh.cells_of_brick()) {
      cells.insert(cells.end(), of_brick.begin(), of_brick.end());
    }
    layer.cells = texture(GL_TEXTURE_2D, GL_NEAREST);
    fill_table(layer.cells, GL_RGBA32I, GL_RGBA_INTEGER, GL_INT, std::move(cells));
    layer.table = texture(GL_TEXTURE_2D, GL_NEAREST);
    fill_table(layer.table, GL_RGBA32F, GL_RGBA, GL_FLOAT,
               std::vector<float>(derived.field.table.begin(), derived.field.table.end()));
    layer.nets = texture(GL_TEXTURE_2D, GL_NEAREST);
    fill_table(layer.nets, GL_RGBA32F, GL_RGBA, GL_FLOAT, net_texels(derived));
    for (const fields::GridLevel& level : fields::grid_levels(derived.field.config)) {
      layer.levels.push_back(
          {level.resolution, static_cast<GLint>(level.offset), static_cast<GLint>(level.size), level.hashed ? 1 : 0});
    }
    check("loading a layer");
    layers_.emplace(&derived, std::move(layer));
  }

  void delete_targets() {
    for (auto& targets : surfaces_) gl_.DeleteTextures(static_cast<GLsizei>(targets.size()), targets.data());
    gl_.DeleteTextures(1, &depth_);
    gl_.DeleteTextures(1, &drawn_);
  }
  void resize(int width, int height) {
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
      throw Error(ErrorCode::kUsage, "a picture must have between 1 and 16384 pixels on each side");
    }
    if (width == width_ && height == height_) return;
    delete_targets();
    width_ = width;
    height_ = height;
    depth_ = texture(GL_TEXTURE_2D, GL_NEAREST);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, width, height, 0, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
    constexpr std::array<GLenum, 3> kTargets{GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    for (std::size_t side = 0; side < 2; ++side) {
      gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[side]);
      for (std::size_t i = 0; i < 3; ++i) {
        surfaces_[side][i] = texture(GL_TEXTURE_2D, GL_NEAREST);
        gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
        gl_.FramebufferTexture2D(GL_FRAMEBUFFER, kTargets[i], GL_TEXTURE_2D, surfaces_[side][i], 0);
      }
      gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_, 0);
      gl_.DrawBuffers(3, kTargets.data());
      check_framebuffer();
    }
    drawn_ = texture(GL_TEXTURE_2D, GL_NEAREST);
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, width, height, 0, GL_RGBA, GL_HALF_FLOAT, nullptr);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[2]);
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, drawn_, 0);
    check_framebuffer();
  }
  void check_framebuffer() {
    if (gl_.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      width_ = height_ = 0;
      fail("it cannot draw into textures of floats");
    }
  }

  void bind(GLuint program, const char* name, GLint unit, GLenum kind, GLuint texture) {
    gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl_.BindTexture(kind, texture);
    gl_.Uniform1i(gl_.GetUniformLocation(program, name), unit);
  }
  void set(GLuint program, const char* name, float value) {
    gl_.Uniform1f(gl_.GetUniformLocation(program, name), value);
  }
  void set(GLuint program, const char* name, int value) { gl_.Uniform1i(gl_.GetUniformLocation(program, name), value); }

  void find_surfaces(std::span<const ProjectedLayer> views, int peel) {
    const std::size_t side = static_cast<std::size_t>(peel) % 2;
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[side]);
    gl_.Enable(GL_DEPTH_TEST);
    gl_.DepthFunc(GL_LESS);
    gl_.DepthMask(GL_TRUE);
    gl_.Disable(GL_BLEND);
    const std::array<float, 4> nothing{};
    const float far = 1;
    for (GLint i = 0; i < 3; ++i) gl_.ClearBufferfv(GL_COLOR, i, nothing.data());
    gl_.ClearBufferfv(GL_DEPTH, 0, &far);
    for (std::size_t l = 0; l < views.size(); ++l) {
      const ProjectedLayer& view = views[l];
      send_cells(view);
      if (view.lacks_bricks()) send_bricks(view);
      gl_.Enable(GL_CULL_FACE);
      prepare(rasterising_, view, static_cast<int>(l), peel);
      const std::size_t faces = send_mesh(view);
      gl_.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(6 * faces), GL_UNSIGNED_INT, nullptr);
      if (!view.contains_camera()) continue;
      gl_.Disable(GL_CULL_FACE);
      prepare(inside_, view, static_cast<int>(l), peel);
      gl_.BindVertexArray(empty_array_);
      gl_.DrawArrays(GL_TRIANGLES, 0, 3);
    }
    gl_.Disable(GL_CULL_FACE);
  }

  void prepare(GLuint program, const ProjectedLayer& view, int number, int peel) {
    const LayerTextures& layer = layers_.at(&view.layer());
    gl_.UseProgram(program);
    const Intrinsics& k = camera_.intrinsics;
    const std::array<float, 4> intrinsics{static_cast<float>(k.fx), static_cast<float>(k.fy), static_cast<float>(k.cx),
                                          static_cast<float>(k.cy)};
    gl_.Uniform4fv(gl_.GetUniformLocation(program, "u_intrinsics"), 1, intrinsics.data());
    gl_.Uniform2f(gl_.GetUniformLocation(program, "u_size"), static_cast<float>(width_), static_cast<float>(height_));
    set(program, "u_bricks_per_side", view.layer().bricks.bricks_per_side());
    set(program, "u_atlas_bricks", layer.atlas_bricks);
    set(program, "u_step", view.step());
    set(program, "u_optical_length", view.optical_length());
    set(program, "u_resolution", static_cast<float>(view.layer().bricks.resolution()));
    set(program, "u_layer", number);
    set(program, "u_deforms", view.deforms() ? 1 : 0);
    set(program, "u_has_before", peel > 0 ? 1 : 0);
    if (program == inside_) {
      gl_.Uniform3fv(gl_.GetUniformLocation(program, "u_camera_position"), 1, view.camera_position().data());
      gl_.UniformMatrix3fv(gl_.GetUniformLocation(program, "u_camera_rotation"), 1, GL_FALSE,
                           view.camera_rotation().data());
      gl_.Uniform4fv(gl_.GetUniformLocation(program, "u_camera_layer_rotation"), 1, view.rotation().data());
    }
    bind(program, "u_brick_index", 0, GL_TEXTURE_3D, view.lacks_bricks() ? bricks_there_ : layer.index);
    bind(program, "u_atlas", 1, GL_TEXTURE_3D, layer.atlas);
    bind(program, "u_cells_of_brick", 2, GL_TEXTURE_2D, layer.cells);
    bind(program, "u_cell_corners", 3, GL_TEXTURE_2D, cell_corners_);
    bind(program, "u_drawn", 4, GL_TEXTURE_2D, drawn_);
    bind(program, "u_before", 5, GL_TEXTURE_2D, surfaces_[static_cast<std::size_t>(peel + 1) % 2][0]);
  }

  void send_cells(const ProjectedLayer& view) {
    std::vector<float> corners;
    if (view.deforms()) {
      const std::size_t cells = view.layer().proxy_mesh.cells().size();
      corners.reserve(32 * (cells + kRow));
      for (std::size_t cell = 0; cell < cells; ++cell) {
        for (std::size_t c = 0; c < 8; ++c) {
          const Eigen::Vector3f& at = view.corners()[view.posed()->corner(cell, c)];
          corners.insert(corners.end(), {at.x(), at.y(), at.z(), 1});
        }
      }
    }
    gl_.ActiveTexture(GL_TEXTURE0 + 3);
    fill_table(cell_corners_, GL_RGBA32F, GL_RGBA, GL_FLOAT, std::move(corners));
  }

  void send_bricks(const ProjectedLayer& view) {
    const int n = view.layer().bricks.bricks_per_side();
    gl_.ActiveTexture(GL_TEXTURE0);
    gl_.BindTexture(GL_TEXTURE_3D, bricks_there_);
    gl_.TexImage3D(GL_TEXTURE_3D, 0, GL_R32I, n, n, n, 0, GL_RED_INTEGER, GL_INT, view.brick_index());
  }

  std::size_t send_mesh(const ProjectedLayer& view) {
    struct Vertex {
      std::array<float, 3> corner, position, view_vector;
      std::array<float, 4> rotation;
    };
    std::vector<Vertex> vertices(view.corners().size());
    const auto floats = [](const Eigen::Vector3f& v) { return std::array<float, 3>{v.x(), v.y(), v.z()}; };
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      vertices[i] = {floats(view.corners()[i]), floats(view.positions()[i]), floats(view.view_vectors()[i]),
                     view.rotation()};
      if (view.deforms()) std::copy_n(view.posed()->corners().rotation[i].data(), 4, vertices[i].rotation.begin());
    }
    std::vector<std::uint32_t> indices;
    indices.reserve(6 * view.faces().size());
    for (const fields::ProxyFace& face : view.faces()) {
      indices.insert(indices.end(), {face[0], face[1], face[2], face[0], face[2], face[3]});
    }
    gl_.BindVertexArray(mesh_array_);
    gl_.BindBuffer(GL_ARRAY_BUFFER, vertices_);
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(Vertex)), vertices.data(),
                   GL_STREAM_DRAW);
    gl_.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, faces_);
    gl_.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(std::uint32_t)),
                   indices.data(), GL_STREAM_DRAW);
    for (GLuint a = 0; a < 4; ++a) {
      gl_.EnableVertexAttribArray(a);
      const std::size_t offset = a * 3 * sizeof(float);
      gl_.VertexAttribPointer(a, a < 3 ? 3 : 4, GL_FLOAT, GL_FALSE, sizeof(Vertex),
                              reinterpret_cast<const void*>(offset)); // NOLINT(performance-no-int-to-ptr): GL's offset
    }
    return view.faces().size();
  }

  // Under what was drawn.
  void shade(std::span<const ProjectedLayer> views, int peel) {
    const auto& surfaces = surfaces_[static_cast<std::size_t>(peel) % 2];
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffers_[2]);
    gl_.Disable(GL_DEPTH_TEST);
    gl_.Enable(GL_BLEND);
    gl_.BlendFunc(GL_ONE_MINUS_DST_ALPHA, GL_ONE);
    gl_.UseProgram(shading_);
    gl_.BindVertexArray(empty_array_);
    constexpr float kNear = 0.75F; // cells, as in tile_shader.h
    for (std::size_t l = 0; l < views.size(); ++l) {
      const LayerTextures& layer = layers_.at(&views[l].layer());
      bind(shading_, "u_position", 0, GL_TEXTURE_2D, surfaces[0]);
      bind(shading_, "u_sigma", 1, GL_TEXTURE_2D, surfaces[1]);
      bind(shading_, "u_rotation", 2, GL_TEXTURE_2D, surfaces[2]);
      bind(shading_, "u_table", 3, GL_TEXTURE_2D, layer.table);
      bind(shading_, "u_nets", 4, GL_TEXTURE_2D, layer.nets);
      set(shading_, "u_levels", static_cast<int>(layer.levels.size()));
      gl_.Uniform4iv(gl_.GetUniformLocation(shading_, "u_level"), static_cast<GLsizei>(layer.levels.size()),
                     layer.levels.front().data());
      set(shading_, "u_near", kNear / static_cast<float>(views[l].layer().field.config.finest_resolution));
      set(shading_, "u_layer", static_cast<int>(l));
      gl_.DrawArrays(GL_TRIANGLES, 0, 3);
    }
    gl_.Disable(GL_BLEND);
  }

  Functions gl_;
  std::string name_;
  bool is_es_ = false;
  GLuint rasterising_ = 0, inside_ = 0, shading_ = 0;
  GLuint mesh_array_ = 0, empty_array_ = 0, vertices_ = 0, faces_ = 0, cell_corners_ = 0;
  GLuint bricks_there_ = 0;                         // of a layer that lacks some
  std::array<GLuint, 3> framebuffers_{};            // two of surfaces, and the picture
  std::array<std::array<GLuint, 3>, 2> surfaces_{}; // as surfaces.frag writes them; one side while the other is read
  GLuint depth_ = 0, drawn_ = 0;
  int width_ = 0, height_ = 0;
  Camera camera_;
  std::map<const fields::DrawableField::Derived*, LayerTextures> layers_;
};

GlRenderer::GlRenderer(const GetFunction& get) : state_(std::make_unique<State>(get)) {}
GlRenderer::~GlRenderer() = default;
const std::string& GlRenderer::name() const { return state_->name(); }
bool GlRenderer::is_software() const {
  for (const char* software : {"llvmpipe", "softpipe", "SwiftShader", "Software Rasterizer"}) {
    if (name().find(software) != std::string::npos) return true;
  }
  return false;
}
void GlRenderer::draw(std::span<const fields::PosedField> layers, const Camera& camera) {
  state_->draw(layers, camera);
}
unsigned GlRenderer::texture() const { return state_->drawn(); }
ColorImage GlRenderer::read() { return state_->read(); }

} // namespace kinora::player::gl
