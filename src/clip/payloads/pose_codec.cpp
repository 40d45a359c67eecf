#include "clip/payloads/pose_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::put;

namespace {

constexpr std::uint8_t kFarVersion = 1;
constexpr std::size_t kFarBytes = 40;
constexpr double kFarQuaternionScale = 1 << 30;
constexpr std::uint8_t kVersion = 2;
constexpr std::size_t kPoseBytes = 23;
constexpr double kQuaternionScale = 1 << 23;
constexpr double kMicrometres = 1e6;
constexpr double kFarthest = 1e9;     // metres
constexpr double kFarthestNear = 2e9; // micrometres, of version 2

// Unit quaternion w x y z with one component left out: that one is positive, and follows from the others.
struct SmallestThree {
  int omitted = 0;
  std::array<std::int32_t, 3> others{};

  bool operator==(const SmallestThree&) const = default;
};

SmallestThree pack(const Eigen::Quaterniond& rotation, double scale) {
  const std::array<double, 4> q{rotation.w(), rotation.x(), rotation.y(), rotation.z()};
  const auto size_of = [&q](std::size_t i) { return std::abs(q[i]); };
  double largest = 0;
  for (std::size_t i = 0; i < 4; ++i) largest = std::max(largest, size_of(i));
  // Components of equal size (quarter turns have them) differ by the rounding of the others: then the first counts.
  const double tie = 4 / scale;
  std::size_t omitted = 0;
  while (size_of(omitted) < largest - tie) ++omitted;
  SmallestThree packed;
  packed.omitted = static_cast<int>(omitted);
  const double sign = q[omitted] < 0 ? -1 : 1;
  for (std::size_t i = 0, o = 0; i < 4; ++i) {
    if (i == omitted) continue;
    packed.others[o++] = static_cast<std::int32_t>(std::lrint(sign * q[i] * scale));
  }
  return packed;
}

Eigen::Quaterniond unpack(const SmallestThree& packed, double scale) {
  std::array<double, 4> q{};
  double rest = 1;
  for (std::size_t i = 0, o = 0; i < 4; ++i) {
    if (static_cast<int>(i) == packed.omitted) continue;
    q[i] = packed.others[o++] / scale;
    rest -= q[i] * q[i];
  }
  q[static_cast<std::size_t>(packed.omitted)] = std::sqrt(std::max(0.0, rest));
  return {q[0], q[1], q[2], q[3]};
}

// Rounding may still make another component the largest, and packing what was unpacked that one again: of the numbers
// that follow each other in such a circle the least are it, from wherever it is entered.
SmallestThree pack_stable(const SE3& pose, double scale) {
  std::vector<SmallestThree> steps{pack(Eigen::Quaterniond(pose.linear()).normalized(), scale)};
  constexpr std::size_t kMaxSteps = 64;
  while (steps.size() < kMaxSteps) {
    const Eigen::Quaterniond unpacked(unpack(steps.back(), scale).toRotationMatrix());
    const SmallestThree next = pack(unpacked.normalized(), scale);
    const auto circle = std::find(steps.begin(), steps.end(), next);
    if (circle != steps.end()) {
      return *std::min_element(circle, steps.end(), [](const SmallestThree& a, const SmallestThree& b) {
        return a.omitted != b.omitted ? a.omitted < b.omitted : a.others < b.others;
      });
    }
    steps.push_back(next);
  }
  return steps.back();
}

[[noreturn]] void reject(const std::string& location, const std::string& why) {
  throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
}

motion::Health health_of(unsigned number, const std::string& location) {
  if (number > static_cast<unsigned>(motion::Health::kLost))
    reject(location, "a pose is neither tracked nor held nor lost");
  return static_cast<motion::Health>(number);
}

Eigen::Matrix3d rotation_of(const SmallestThree& packed, double scale, const std::string& location) {
  double squares = 0;
  for (const std::int32_t component : packed.others) squares += std::pow(component / scale, 2);
  constexpr double kMaxOthers = 0.75 + 1e-6; // the omitted component is the largest of four
  if (squares > kMaxOthers) reject(location, "a pose holds no unit quaternion");
  return unpack(packed, scale).toRotationMatrix();
}

Bytes encode_far(const motion::Motion::Pose& pose) {
  const SmallestThree packed = pack_stable(pose.canonical_to_world, kFarQuaternionScale);
  Bytes out;
  put(out, kFarVersion);
  put(out, static_cast<std::uint8_t>(pose.health));
  put(out, static_cast<std::uint8_t>(packed.omitted));
  put(out, std::uint8_t{0});
  for (const std::int32_t component : packed.others) put(out, component);
  for (int a = 0; a < 3; ++a) {
    put(out, static_cast<std::int64_t>(std::llrint(pose.canonical_to_world.translation()[a] * kMicrometres)));
  }
  return out;
}

motion::Motion::Pose decode_far(std::span<const std::byte> payload, const std::string& location) {
  if (payload.size() != kFarBytes) reject(location, fmt::format("a pose has {} bytes instead of 40", payload.size()));
  motion::Motion::Pose pose;
  pose.health = health_of(get<std::uint8_t>(payload, 1), location);
  SmallestThree packed;
  packed.omitted = get<std::uint8_t>(payload, 2);
  if (packed.omitted > 3) reject(location, "a pose omits a component that a quaternion does not have");
  for (std::size_t i = 0; i < 3; ++i) packed.others[i] = get<std::int32_t>(payload, 4 + 4 * i);
  pose.canonical_to_world.linear() = rotation_of(packed, kFarQuaternionScale, location);
  for (int a = 0; a < 3; ++a) {
    const auto micrometres = get<std::int64_t>(payload, 16 + 8 * static_cast<std::size_t>(a));
    pose.canonical_to_world.translation()[a] = static_cast<double>(micrometres) / kMicrometres;
    if (std::abs(pose.canonical_to_world.translation()[a]) > kFarthest + 1)
      reject(location, "a pose is impossibly far away");
  }
  return pose;
}

} // namespace

Bytes encode_pose(const motion::Motion::Pose& pose) {
  const SE3& transform = pose.canonical_to_world;
  const double farthest = transform.translation().cwiseAbs().maxCoeff();
  if (!transform.matrix().allFinite() || farthest > kFarthest) {
    throw Error(ErrorCode::kFailure, "a pose is not finite or impossibly far away; it cannot be stored");
  }
  if (std::round(farthest * kMicrometres) > kFarthestNear) return encode_far(pose);
  const SmallestThree packed = pack_stable(transform, kQuaternionScale);
  Bytes out;
  put(out, kVersion);
  put(out, static_cast<std::uint8_t>(static_cast<unsigned>(pose.health) | static_cast<unsigned>(packed.omitted) << 2U));
  for (const std::int32_t component : packed.others) {
    put(out, static_cast<std::uint16_t>(component & 0xFFFF));
    put(out, static_cast<std::int8_t>(component >> 16));
  }
  for (int a = 0; a < 3; ++a)
    put(out, static_cast<std::int32_t>(std::lrint(transform.translation()[a] * kMicrometres)));
  return out;
}

motion::Motion::Pose decode_pose(std::span<const std::byte> payload, const std::string& location) {
  if (payload.empty()) reject(location, "a pose has no bytes");
  const auto version = get<std::uint8_t>(payload, 0);
  if (version == kFarVersion) return decode_far(payload, location);
  if (version != kVersion) {
    reject(location, fmt::format("a pose has version {}; this Kinora reads versions 1 and 2", version));
  }
  if (payload.size() != kPoseBytes) reject(location, fmt::format("a pose has {} bytes instead of 23", payload.size()));
  const auto flags = get<std::uint8_t>(payload, 1);
  if (flags > 0xF) reject(location, "a pose omits a component that a quaternion does not have");
  motion::Motion::Pose pose;
  pose.health = health_of(flags & 3U, location);
  SmallestThree packed;
  packed.omitted = flags >> 2;
  for (std::size_t i = 0; i < 3; ++i) {
    packed.others[i] =
        get<std::int8_t>(payload, 4 + 3 * i) * 0x10000 + std::int32_t{get<std::uint16_t>(payload, 2 + 3 * i)};
  }
  pose.canonical_to_world.linear() = rotation_of(packed, kQuaternionScale, location);
  for (int a = 0; a < 3; ++a) {
    const auto micrometres = get<std::int32_t>(payload, 11 + 4 * static_cast<std::size_t>(a));
    pose.canonical_to_world.translation()[a] = micrometres / kMicrometres;
  }
  return pose;
}

} // namespace kinora::clip
