// Text of a file whose bytes may have been damaged.
#pragma once

#include <string>
#include <string_view>

namespace kinora::container {

/// `text` with U+FFFD in place of each byte that is not part of a well-formed sequence (RFC 3629).
std::string valid_utf8(std::string_view text);

} // namespace kinora::container
