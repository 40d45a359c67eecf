// tinygltf itself, without the decoders of pictures that it would bring.
#define TINYGLTF_IMPLEMENTATION
#include "gltf_scene/gltf_library.h"
