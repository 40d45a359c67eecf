// Where the repository lies: for tests that read its samples.
#pragma once

#include <filesystem>

namespace kinora::test {

std::filesystem::path source_folder();

} // namespace kinora::test
