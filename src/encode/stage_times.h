// How long each stage of a run took, for people: no result may depend on it.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace kinora::encode {

/// Milliseconds of each stage, one value per frame. Not thread-safe.
class StageTimes {
public:
  /// Calls `work`, and notes its time under `stage`.
  template <class Work> auto measure(const std::string& stage, Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    const Note note{*this, stage, start};
    return work();
  }

  /// {"stage": {"median", "p99", "total_s"}}; a stage that runs once is spread over `frames` and has no p99.
  nlohmann::json json(std::size_t frames) const {
    nlohmann::json out = nlohmann::json::object();
    for (const auto& [stage, times] : milliseconds_) {
      std::vector<double> sorted = times;
      std::sort(sorted.begin(), sorted.end());
      double total = 0;
      for (const double t : sorted) total += t;
      out[stage]["total_s"] = round(total / 1000);
      if (sorted.size() == 1 && frames > 1) {
        out[stage]["ms_per_frame"] = round(total / static_cast<double>(frames));
      } else {
        out[stage]["ms_per_frame"] = round(sorted[(sorted.size() - 1) / 2]);
        out[stage]["ms_per_frame_p99"] = round(sorted[(sorted.size() - 1) * 99 / 100]);
      }
    }
    return out;
  }

private:
  struct Note {
    StageTimes& times;
    const std::string& stage;
    std::chrono::steady_clock::time_point start;
    ~Note() {
      const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - start;
      times.milliseconds_[stage].push_back(spent.count());
    }
  };

  static double round(double value) { return std::round(value * 1000) / 1000; }

  std::map<std::string, std::vector<double>> milliseconds_;
};

} // namespace kinora::encode
