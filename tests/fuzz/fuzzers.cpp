#include "fuzz/fuzzer.h"

namespace kinora::fuzz {

std::vector<Fuzzer> fuzzers() {
  std::vector<Fuzzer> all;
  for (const auto& some :
       {file_fuzzers(), folder_fuzzers(), input_fuzzers(), payload_fuzzers(), plugin_fuzzers(), reader_fuzzers()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

} // namespace kinora::fuzz
