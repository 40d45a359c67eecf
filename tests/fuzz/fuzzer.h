// What is fuzzed: each parser with inputs that it takes. The same functions run under libFuzzer (libfuzzer_main.cpp,
// scripts/fuzz) for as long as one likes, and on a fixed row of damaged inputs with the other tests (fuzz_test.cpp).
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace kinora::fuzz {

using Bytes = std::vector<std::byte>;

struct Fuzzer {
  const char* name;
  std::vector<Bytes> (*seeds)(); ///< whole inputs, to be damaged
  /// Gives an input to a parser. Ends normally or in an Error that a user can read; all else is a fault of the parser.
  void (*run)(std::span<const std::byte> input);
  int rounds; ///< of the row that is run with the other tests
};

/// All of them.
std::vector<Fuzzer> fuzzers();

std::vector<Fuzzer> file_fuzzers();    ///< Kinora's own file
std::vector<Fuzzer> folder_fuzzers();  ///< what capture folders hold
std::vector<Fuzzer> input_fuzzers();   ///< what else a user may give to a command
std::vector<Fuzzer> payload_fuzzers(); ///< what a clip's tracks hold
std::vector<Fuzzer> plugin_fuzzers();  ///< what a plugin may hand over
std::vector<Fuzzer> reader_fuzzers();  ///< captures of one file

/// What a parser must never break.
inline void require(bool holds, const std::string& claim) {
  if (!holds) throw std::logic_error(claim);
}

inline Bytes bytes_of(const std::string& text) {
  const auto view = std::as_bytes(std::span(text));
  return {view.begin(), view.end()};
}

} // namespace kinora::fuzz
