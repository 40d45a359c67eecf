// The functions of OpenGL ES 3.0, which OpenGL 3.3 has as well, that drawing calls.
#pragma once

#include <functional>

#include <GLES3/gl3.h>

namespace kinora::player::gl {

/// Address of an OpenGL function of the current context: eglGetProcAddress, glfwGetProcAddress and the like.
using GetFunction = std::function<void*(const char* name)>;

struct Functions {
  /// Throws Error(kFailure), naming the first function that is not there.
  explicit Functions(const GetFunction& get);

#define KINORA_GL_FUNCTIONS(X)                                                                                         \
  X(GETSTRING, GetString)                                                                                              \
  X(GETERROR, GetError)                                                                                                \
  X(ENABLE, Enable)                                                                                                    \
  X(DISABLE, Disable)                                                                                                  \
  X(CULLFACE, CullFace)                                                                                                \
  X(FRONTFACE, FrontFace)                                                                                              \
  X(DEPTHFUNC, DepthFunc)                                                                                              \
  X(DEPTHMASK, DepthMask)                                                                                              \
  X(BLENDFUNC, BlendFunc)                                                                                              \
  X(VIEWPORT, Viewport)                                                                                                \
  X(CLEARBUFFERFV, ClearBufferfv)                                                                                      \
  X(CREATESHADER, CreateShader)                                                                                        \
  X(SHADERSOURCE, ShaderSource)                                                                                        \
  X(COMPILESHADER, CompileShader)                                                                                      \
  X(GETSHADERIV, GetShaderiv)                                                                                          \
  X(GETSHADERINFOLOG, GetShaderInfoLog)                                                                                \
  X(DELETESHADER, DeleteShader)                                                                                        \
  X(CREATEPROGRAM, CreateProgram)                                                                                      \
  X(ATTACHSHADER, AttachShader)                                                                                        \
  X(BINDATTRIBLOCATION, BindAttribLocation)                                                                            \
  X(LINKPROGRAM, LinkProgram)                                                                                          \
  X(GETPROGRAMIV, GetProgramiv)                                                                                        \
  X(GETPROGRAMINFOLOG, GetProgramInfoLog)                                                                              \
  X(DELETEPROGRAM, DeleteProgram)                                                                                      \
  X(USEPROGRAM, UseProgram)                                                                                            \
  X(GETUNIFORMLOCATION, GetUniformLocation)                                                                            \
  X(UNIFORM1I, Uniform1i)                                                                                              \
  X(UNIFORM1F, Uniform1f)                                                                                              \
  X(UNIFORM2F, Uniform2f)                                                                                              \
  X(UNIFORM3FV, Uniform3fv)                                                                                            \
  X(UNIFORM4FV, Uniform4fv)                                                                                            \
  X(UNIFORM4IV, Uniform4iv)                                                                                            \
  X(UNIFORMMATRIX3FV, UniformMatrix3fv)                                                                                \
  X(GENTEXTURES, GenTextures)                                                                                          \
  X(DELETETEXTURES, DeleteTextures)                                                                                    \
  X(ACTIVETEXTURE, ActiveTexture)                                                                                      \
  X(BINDTEXTURE, BindTexture)                                                                                          \
  X(TEXIMAGE2D, TexImage2D)                                                                                            \
  X(TEXIMAGE3D, TexImage3D)                                                                                            \
  X(TEXPARAMETERI, TexParameteri)                                                                                      \
  X(PIXELSTOREI, PixelStorei)                                                                                          \
  X(GENBUFFERS, GenBuffers)                                                                                            \
  X(DELETEBUFFERS, DeleteBuffers)                                                                                      \
  X(BINDBUFFER, BindBuffer)                                                                                            \
  X(BUFFERDATA, BufferData)                                                                                            \
  X(GENVERTEXARRAYS, GenVertexArrays)                                                                                  \
  X(DELETEVERTEXARRAYS, DeleteVertexArrays)                                                                            \
  X(BINDVERTEXARRAY, BindVertexArray)                                                                                  \
  X(VERTEXATTRIBPOINTER, VertexAttribPointer)                                                                          \
  X(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray)                                                                  \
  X(DRAWARRAYS, DrawArrays)                                                                                            \
  X(DRAWELEMENTS, DrawElements)                                                                                        \
  X(GENFRAMEBUFFERS, GenFramebuffers)                                                                                  \
  X(DELETEFRAMEBUFFERS, DeleteFramebuffers)                                                                            \
  X(BINDFRAMEBUFFER, BindFramebuffer)                                                                                  \
  X(FRAMEBUFFERTEXTURE2D, FramebufferTexture2D)                                                                        \
  X(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus)                                                                    \
  X(DRAWBUFFERS, DrawBuffers)                                                                                          \
  X(READPIXELS, ReadPixels)

#define KINORA_GL_MEMBER(type, name) PFNGL##type##PROC name;
  KINORA_GL_FUNCTIONS(KINORA_GL_MEMBER)
#undef KINORA_GL_MEMBER
};

} // namespace kinora::player::gl
