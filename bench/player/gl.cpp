// How close the picture of the shaders comes to the CPU's: frames all over a clip, every layer alone and all together,
// from the capture's camera, from nearer, farther, and from 30° and 60° aside. Prints the GPU's name, then CSV: dB of
// both pictures on black and milliseconds of each, the GPU's with its picture read back.
//   bench_gl CLIP.mkv [WIDTHxHEIGHT]
#include <cmath>
#include <cstdio>

#include "clip/clip_io.h"
#include "player/gl/gl_renderer.h"
#include "player/gl/surfaceless_context.h"
#include "player/player.h"
#include "player/view_path.h"
#include "stopwatch.h"

using namespace kinora;

namespace {

double psnr_of(const ColorImage& a, const ColorImage& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixel_count(); ++i) {
    const std::uint8_t* p = a.data() + 4 * i;
    const std::uint8_t* q = b.data() + 4 * i;
    for (int c = 0; c < 3; ++c) sum += std::pow((p[c] * p[3] - q[c] * q[3]) / 255.0, 2);
  }
  return 10 * std::log10(255 * 255 / std::max(sum / (3.0 * static_cast<double>(a.pixel_count())), 1e-9));
}

void write_ppm(const std::string& path, const ColorImage& image) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr) return;
  std::fprintf(file, "P6\n%d %d\n255\n", image.width(), image.height());
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const std::uint8_t* p = image.data() + 4 * i;
    for (int c = 0; c < 3; ++c) std::fputc(p[c] * p[3] / 255, file);
  }
  std::fclose(file);
}

struct Standpoint {
  const char* name;
  double degrees, forward; ///< metres
};

} // namespace

int main(int argc, char** argv) {
  int width = 640, height = 480;
  if (argc < 2 || (argc > 2 && std::sscanf(argv[2], "%dx%d", &width, &height) != 2)) {
    std::fprintf(stderr, "usage: bench_gl CLIP.mkv [WIDTHxHEIGHT] [PICTURES]\n");
    return 2;
  }
  try {
    const player::gl::testing::SurfacelessContext context(player::gl::testing::SurfacelessContext::Kind::kEs3);
    player::gl::GlRenderer renderer(player::gl::testing::SurfacelessContext::function);
    std::printf("# %s%s\n", renderer.name().c_str(), renderer.is_software() ? ": software" : "");
    const player::Player player(clip::read_clip(argv[1]));
    const clip::Clip& clip = player.clip();
    std::vector<fields::DrawableField> drawables;
    for (const clip::Layer& layer : clip.layers) {
      drawables.emplace_back(layer.field, layer.motion.graph().get(), layer.confidence);
    }
    std::printf("from,frame,layer,psnr,gpu_ms,cpu_ms\n");
    const int last = static_cast<int>(player.frame_count()) - 1;
    for (const auto& [name, degrees, forward] :
         {Standpoint{"capture", 0, 0}, {"near", 0, 0.7}, {"far", 0, -1.5}, {"aside 30", 30, 0}, {"aside 60", 60, 0}}) {
      for (const int frame : {last / 4, last}) {
        player::View view = player::orbit_views(player, {frame}, degrees).front();
        view.camera.camera_to_world.translate(Eigen::Vector3d(0, 0, forward));
        view.camera.intrinsics = view.camera.intrinsics.resized(width, height);
        std::vector<fields::PosedField> layers;
        for (std::size_t i = 0; i < drawables.size(); ++i) {
          layers.push_back(fields::pose(drawables[i], clip.layers[i].motion.warp(frame)));
        }
        for (std::size_t i = 0; i <= layers.size(); ++i) {
          const bool all = i == layers.size();
          const auto drawn = all ? std::span(layers) : std::span(layers).subspan(i, 1);
          const bench::Stopwatch cpu;
          const ColorImage reference = fields::render(drawn, view.camera).color;
          const double cpu_ms = cpu.milliseconds();
          const bench::Stopwatch gpu;
          renderer.draw(drawn, view.camera);
          const ColorImage picture = renderer.read();
          std::printf("%s,%d,%s,%.2f,%.0f,%.0f\n", name, frame, all ? "all" : clip.layers[i].name.c_str(),
                      psnr_of(picture, reference), gpu.milliseconds(), cpu_ms);
          std::fflush(stdout);
          if (argc > 3 && all) {
            const std::string path = std::string(argv[3]) + "_" + name + "_" + std::to_string(frame);
            write_ppm(path + "_gpu.ppm", picture);
            write_ppm(path + "_cpu.ppm", reference);
          }
        }
      }
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_gl: %s\n", error.what());
    return 1;
  }
  return 0;
}
