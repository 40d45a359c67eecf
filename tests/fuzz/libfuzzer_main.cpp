// The fuzzers as one libFuzzer program: fuzz NAME [libFuzzer's arguments]; fuzz --list; fuzz NAME --seeds FOLDER.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "fuzz/fuzzer.h"

namespace {

const kinora::fuzz::Fuzzer* chosen = nullptr; // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)

void write_seeds(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const kinora::fuzz::Bytes& seed : chosen->seeds()) {
    std::ofstream file(folder / ("seed" + std::to_string(number++)), std::ios::binary);
    file.write(reinterpret_cast<const char*>(seed.data()), static_cast<std::streamsize>(seed.size()));
  }
}

} // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  static const std::vector<kinora::fuzz::Fuzzer> all = kinora::fuzz::fuzzers();
  const char* name = *count > 1 ? (*arguments)[1] : "";
  if (std::strcmp(name, "--list") == 0) {
    for (const kinora::fuzz::Fuzzer& fuzzer : all) std::puts(fuzzer.name);
    std::exit(0);
  }
  for (const kinora::fuzz::Fuzzer& fuzzer : all)
    if (std::strcmp(name, fuzzer.name) == 0) chosen = &fuzzer;
  if (chosen == nullptr) {
    std::fprintf(stderr, "usage: fuzz NAME [libFuzzer's arguments] | fuzz NAME --seeds FOLDER | fuzz --list\n");
    std::exit(2);
  }
  if (*count > 3 && std::strcmp((*arguments)[2], "--seeds") == 0) {
    write_seeds((*arguments)[3]);
    std::exit(0);
  }
  (*arguments)[1] = (*arguments)[0]; // libFuzzer shall not see the name
  ++*arguments;
  --*count;
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    chosen->run(std::as_bytes(std::span(data, size)));
  } catch (const kinora::Error&) { // NOLINT(bugprone-empty-catch): what a parser shall do
  }
  return 0;
}
