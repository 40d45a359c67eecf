// A capture that comes as from a camera: at its own pace, and what is not taken in time is lost.
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::host {

/// Seconds since any moment, and how to let them pass.
class DeviceClock {
public:
  virtual ~DeviceClock() = default;
  virtual double now() const = 0; ///< from any thread; never goes back
  virtual void sleep(double seconds) = 0;
  /// That of the system.
  static DeviceClock& steady();
};

/// What goes wrong with a device, in seconds of the capture from its first frame on.
struct DeviceFault {
  enum class Kind {
    kStall,     ///< frames of that time come when it is over, all at once
    kDrop,      ///< frames of that time never come
    kDisconnect ///< from then on none comes
  };
  Kind kind = Kind::kStall;
  double begin = 0;
  double seconds = std::numeric_limits<double>::infinity(); ///< of a stall or a drop

  bool covers(double time) const { return time >= begin && time < begin + seconds; }
};

/// A line each: "stall BEGIN SECONDS", "drop BEGIN SECONDS", "disconnect BEGIN"; what follows a # is a remark.
/// Throws Error(kCorruptInput), naming `source` and the line.
std::vector<DeviceFault> parse_device_faults(std::string_view text, const std::string& source);

/// Tells of every frame, by its time, when it is there. A device keeps a bounded queue: a frame that nobody has asked
/// for `max_age` seconds after it was captured is lost. One thread at a time, but for age() and was_disconnected().
class SimulatedDevice {
public:
  /// `stopped` is asked now and then while the device waits; the clock must outlive it.
  SimulatedDevice(std::vector<DeviceFault> faults, double max_age, DeviceClock& clock, std::function<bool()> stopped);

  enum class Delivery {
    kThere, ///< now: the device has waited for it
    kLost,
    kEnded ///< the device is gone, or the wait was stopped
  };
  /// Of a frame with this time (seconds), given in the capture's order; the clock starts with the first one. A time
  /// that is not finite is no reason to wait.
  Delivery wait_for(double time);

  /// Seconds for which a frame with this time has been too old already; not positive if it is not.
  double overdue(double time) const { return age(time) - max_age_; }
  /// Seconds since a frame with this time was captured; from any thread that has been given a frame.
  double age(double time) const;
  bool was_disconnected() const { return disconnected_; }

private:
  bool sleep_until(double time);

  std::vector<DeviceFault> faults_;
  double max_age_;
  DeviceClock& clock_;
  std::function<bool()> stopped_;
  std::optional<double> first_time_;
  double start_ = 0; ///< on the clock, of the first frame
  bool disconnected_ = false;
};

} // namespace kinora::host
