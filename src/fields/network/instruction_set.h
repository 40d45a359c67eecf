// Which instruction set vectorised code runs on.
#pragma once

namespace kinora::fields::kernels {

/// Name of the instruction set in use, for reports: "AVX3", "AVX2", …
const char* instruction_set();

} // namespace kinora::fields::kernels
