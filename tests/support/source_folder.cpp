#include "support/source_folder.h"

namespace kinora::test {

std::filesystem::path source_folder() { return KINORA_SOURCE_DIR; }

} // namespace kinora::test
