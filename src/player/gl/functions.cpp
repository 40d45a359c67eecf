#include "player/gl/functions.h"

#include <string>

#include "core/error.h"

namespace kinora::player::gl {
namespace {

template <class F> F found(const GetFunction& get, const char* name) {
  void* address = get(name);
  if (address == nullptr) {
    throw Error(ErrorCode::kFailure, std::string("this OpenGL has no ") + name +
                                         ": drawing by the GPU needs OpenGL 3.3 or OpenGL ES 3.0; draw by the CPU");
  }
  return reinterpret_cast<F>(address);
}

} // namespace

Functions::Functions(const GetFunction& get) {
#define KINORA_GL_LOAD(type, name) name = found<PFNGL##type##PROC>(get, "gl" #name);
  KINORA_GL_FUNCTIONS(KINORA_GL_LOAD)
#undef KINORA_GL_LOAD
}

} // namespace kinora::player::gl
