# How every target of Kinora is built: one set of warnings, one precompiled header, one function per kind of target.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

find_program(CCACHE ccache)
if(CCACHE)
  # Precompiled headers are cached safely only with this sloppiness (ccache's manual, "Precompiled headers"); the base
  # folder lets clones and worktrees share what was compiled.
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
      CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CCACHE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-fpch-preprocess)
  else()
    add_compile_options("SHELL:-Xclang -fno-pch-timestamp")
  endif()
endif()

add_library(kinora_flags INTERFACE)
if(NOT EMSCRIPTEN)
  # For programs too: a precompiled header serves only those who agree on it.
  target_compile_options(kinora_flags INTERFACE -fPIC -fno-semantic-interposition)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  # The compiler tidies its memory up less often: an eighth of its time.
  target_compile_options(kinora_flags INTERFACE --param=ggc-min-heapsize=500000)
endif()
target_compile_options(
  kinora_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-qual
                         -Werror -fno-math-errno -ffp-contract=off)
target_include_directories(kinora_flags INTERFACE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)

set(KINORA_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize= takes them")
if(KINORA_SANITIZE)
  add_compile_options(-fsanitize=${KINORA_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${KINORA_SANITIZE})
  # g++ 12 warns of overruns inside std::string's own `operator+` once it is instrumented (its bug 105651).
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-Wno-array-bounds -Wno-restrict -Wno-stringop-overflow)
  endif()
endif()

# kinora_use_pch(target): the shared precompiled header of cmake/pch.h, compiled once.
function(kinora_use_pch target)
  if(NOT TARGET kinora_pch)
    if(NOT EXISTS ${CMAKE_BINARY_DIR}/pch.cpp)
      file(TOUCH ${CMAKE_BINARY_DIR}/pch.cpp)
    endif()
    add_library(kinora_pch OBJECT ${CMAKE_BINARY_DIR}/pch.cpp)
    target_link_libraries(kinora_pch PRIVATE kinora_flags Eigen3::Eigen fmt::fmt)
    target_include_directories(kinora_pch PRIVATE ${PROJECT_SOURCE_DIR}/cmake)
    target_precompile_headers(kinora_pch PRIVATE <pch.h>)
  endif()
  target_precompile_headers(${target} REUSE_FROM kinora_pch)
endfunction()

# kinora_library(name SOURCES a.cpp … [PUBLIC lib …] [PRIVATE lib …]): static library kinora_<name>.
function(kinora_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PUBLIC;PRIVATE")
  add_library(kinora_${name} STATIC ${arg_SOURCES})
  target_link_libraries(kinora_${name} PUBLIC ${arg_PUBLIC} Eigen3::Eigen PRIVATE kinora_flags ${arg_PRIVATE})
  target_include_directories(kinora_${name} PUBLIC ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src)
  kinora_use_pch(kinora_${name})
endfunction()

# kinora_module(name FOR library SOURCES a.cpp … [LINK lib …]): lib/kinora/<name>.so, which src/core/module.h opens when it
# is first used. It exports its entry alone. Programs that link kinora_<library> are built with it.
function(kinora_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "FOR" "SOURCES;LINK")
  set(target kinora_module_${name})
  set(exports ${PROJECT_SOURCE_DIR}/cmake/module.map)
  add_library(${target} MODULE ${arg_SOURCES})
  target_link_libraries(${target} PRIVATE kinora_flags ${arg_LINK} Eigen3::Eigen)
  target_link_options(${target} PRIVATE LINKER:--version-script=${exports})
  if(NOT KINORA_SANITIZE) # Clang's sanitizers are in the program that loads the module
    target_link_options(${target} PRIVATE LINKER:-z,defs)
  endif()
  set_target_properties(
    ${target} PROPERTIES PREFIX "" OUTPUT_NAME ${name} DEFINE_SYMBOL "" LINK_DEPENDS ${exports}
                         LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/kinora)
  kinora_use_pch(${target})
  set_property(TARGET kinora_${arg_FOR} APPEND PROPERTY INTERFACE_LINK_DEPENDS $<TARGET_FILE:${target}>)
  install(TARGETS ${target} LIBRARY DESTINATION lib/kinora)
endfunction()

# What `./check` builds under sanitizers: the tests labelled `parse` (they read input that is not trusted), and programs
# with THREADS.
add_custom_target(sanitized_tests)
add_custom_target(threaded_tests)

# kinora_test(name SOURCES a.cpp … [LINK lib …] [LABEL l] [THREADS filter] [TIMEOUT s] [FIXTURE f]): GoogleTest program,
# one CTest entry per test. THREADS: those of its tests, as GoogleTest filters them, that say something about threads; the
# thread sanitizer's build has no others. FIXTURE names what another test has to set up before (CTest's FIXTURES_SETUP).
function(kinora_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "LABEL;THREADS;TIMEOUT;FIXTURE" "SOURCES;LINK")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "${name}: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE kinora_flags ${arg_LINK} kinora_test_support Eigen3::Eigen fmt::fmt GTest::gtest_main)
  kinora_use_pch(${name})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)
  endif()
  if(arg_LABEL STREQUAL parse)
    add_dependencies(sanitized_tests ${name})
  endif()
  if(arg_THREADS)
    add_dependencies(threaded_tests ${name})
    if(KINORA_SANITIZE STREQUAL "thread")
      set(arg_LABEL threads)
      set(filter TEST_FILTER ${arg_THREADS})
    endif()
  endif()
  if(arg_FIXTURE)
    set(fixture FIXTURES_REQUIRED ${arg_FIXTURE})
  endif()
  include(GoogleTest)
  gtest_discover_tests(
    ${name}
    TEST_PREFIX ${name}.
    DISCOVERY_TIMEOUT 60
    ${filter}
    PROPERTIES TIMEOUT ${arg_TIMEOUT} ${fixture} LABELS "${arg_LABEL}")
endfunction()
