# What the player needs, for WebAssembly, for which Debian has no libraries: headers of packages where these are
# enough, and zstd from its source. The targets have the names that they have elsewhere.

# 128-bit vectors, and errors that are exceptions.
add_compile_options(-msimd128 -fwasm-exceptions)
add_link_options(-fwasm-exceptions -sALLOW_MEMORY_GROWTH=1)
# Where Debian keeps the modules that em++ needs when it links: a Node.js of another origin does not look there.
set_property(GLOBAL PROPERTY RULE_LAUNCH_LINK "${CMAKE_COMMAND} -E env NODE_PATH=/usr/share/nodejs")

# kinora_headers(target folder): a package that is one folder of headers. Only that folder is put on the search path:
# beside it lie the headers of this machine's C library.
function(kinora_headers target folder)
  find_path(KINORA_HEADERS_${folder} ${folder} PATHS /usr/include /usr/include/eigen3 NO_DEFAULT_PATH
            NO_CMAKE_FIND_ROOT_PATH REQUIRED)
  set(headers ${CMAKE_BINARY_DIR}/headers)
  file(MAKE_DIRECTORY ${headers})
  file(CREATE_LINK ${KINORA_HEADERS_${folder}}/${folder} ${headers}/${folder} SYMBOLIC)
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${target} SYSTEM INTERFACE ${headers})
endfunction()

kinora_headers(Eigen3::Eigen Eigen)
kinora_headers(nlohmann_json::nlohmann_json nlohmann)
kinora_headers(fmt::fmt fmt)
target_compile_definitions(fmt::fmt INTERFACE FMT_HEADER_ONLY)
kinora_headers(PkgConfig::HWY hwy)
target_compile_definitions(PkgConfig::HWY INTERFACE HWY_COMPILE_ONLY_STATIC) # nothing to choose from when it runs

# The writing half too: codecs have both halves in one file. What no program calls is not linked.
set(zstd ${PROJECT_SOURCE_DIR}/build/zstd)
if(NOT EXISTS ${zstd}/zstd.h)
  message(FATAL_ERROR "The WebAssembly build needs the source of zstd in ${zstd}; run scripts/zstd_source")
endif()
enable_language(C)
file(GLOB zstd_sources ${zstd}/common/*.c ${zstd}/compress/*.c ${zstd}/decompress/*.c)
add_library(zstd_wasm STATIC ${zstd_sources})
target_include_directories(zstd_wasm SYSTEM INTERFACE ${zstd})
add_library(PkgConfig::ZSTD ALIAS zstd_wasm)
