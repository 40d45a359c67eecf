#include "host/simulated_device.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::host {
namespace {

class SteadyClock final : public DeviceClock {
public:
  double now() const override {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  void sleep(double seconds) override { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }
};

/// False if the line says something else than a fault, or a remark.
bool add_fault(const std::string& line, std::vector<DeviceFault>& faults) {
  std::istringstream words(line.substr(0, line.find('#')));
  std::string kind;
  if (!(words >> kind)) return true;
  DeviceFault fault;
  if (kind == "drop") {
    fault.kind = DeviceFault::Kind::kDrop;
  } else if (kind == "disconnect") {
    fault.kind = DeviceFault::Kind::kDisconnect;
  } else if (kind != "stall") {
    return false;
  }
  words >> fault.begin;
  if (fault.kind != DeviceFault::Kind::kDisconnect) words >> fault.seconds;
  std::string rest;
  if (!words || words >> rest || fault.begin < 0 || fault.seconds < 0) return false;
  faults.push_back(fault);
  return true;
}

} // namespace

DeviceClock& DeviceClock::steady() {
  static SteadyClock clock;
  return clock;
}

std::vector<DeviceFault> parse_device_faults(std::string_view text, const std::string& source) {
  std::vector<DeviceFault> faults;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (add_fault(line, faults)) continue;
    throw Error(ErrorCode::kCorruptInput,
                fmt::format("{}, line {}: \"{}\" is no fault of a device; write \"stall BEGIN SECONDS\", \"drop BEGIN "
                            "SECONDS\" or \"disconnect BEGIN\"",
                            source, number, line));
  }
  return faults;
}

SimulatedDevice::SimulatedDevice(std::vector<DeviceFault> faults, double max_age, DeviceClock& clock,
                                 std::function<bool()> stopped)
    : faults_(std::move(faults)), max_age_(max_age), clock_(clock), stopped_(std::move(stopped)) {}

SimulatedDevice::Delivery SimulatedDevice::wait_for(double time) {
  if (!std::isfinite(time)) return Delivery::kThere;
  if (!first_time_) {
    first_time_ = time;
    start_ = clock_.now();
  }
  const double from_start = time - *first_time_;
  double there = from_start;
  for (const DeviceFault& fault : faults_) {
    if (!fault.covers(from_start)) continue;
    if (fault.kind == DeviceFault::Kind::kDrop) return Delivery::kLost;
    disconnected_ |= fault.kind == DeviceFault::Kind::kDisconnect;
    if (fault.kind == DeviceFault::Kind::kStall) there = std::max(there, fault.begin + fault.seconds);
  }
  if (disconnected_ || !sleep_until(start_ + there)) return Delivery::kEnded;
  return overdue(time) > 0 ? Delivery::kLost : Delivery::kThere;
}

double SimulatedDevice::age(double time) const {
  return first_time_ ? clock_.now() - start_ - (time - *first_time_) : 0;
}

bool SimulatedDevice::sleep_until(double time) {
  constexpr double kLongest = 0.05; // seconds between questions whether to stop
  for (double left = time - clock_.now(); left > 0; left = time - clock_.now()) {
    if (stopped_()) return false;
    clock_.sleep(std::min(left, kLongest));
  }
  return true;
}

} // namespace kinora::host
