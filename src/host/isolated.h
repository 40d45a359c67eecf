// Work of a stranger's code in a child process: what it breaks there is not broken here.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <span>
#include <string>

namespace kinora::host {

/// What became of it.
struct Isolated {
  bool ended = false;  ///< it returned, in time, and the whole answer came
  std::string problem; ///< else: "crashed (Segmentation fault)", "did not answer within 2 s", …
};

/// Runs `work` in a child process, which fills `answer` (plain bytes) there; the bytes come back. A child that crashes,
/// leaves or takes longer than `limit` is ended. What it prints goes nowhere.
Isolated run_isolated(std::span<std::byte> answer, const std::function<void()>& work,
                      std::chrono::milliseconds limit = std::chrono::seconds(2));

} // namespace kinora::host
