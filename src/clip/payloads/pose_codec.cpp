#include "clip/payloads/pose_codec.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::put;

namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kPoseBytes = 40;
constexpr double kQuaternionScale = 1 << 30;
constexpr double kMicrometres = 1e6;
constexpr double kFarthest = 1e9; // metres

// Unit quaternion w x y z with one component left out: that one is positive, and follows from the others.
struct SmallestThree {
  int omitted = 0;
  std::array<std::int32_t, 3> others{};

  bool operator==(const SmallestThree&) const = default;
};

SmallestThree pack(const Eigen::Quaterniond& rotation) {
  const std::array<double, 4> q{rotation.w(), rotation.x(), rotation.y(), rotation.z()};
  const auto size_of = [&q](std::size_t i) { return std::abs(q[i]); };
  double largest = 0;
  for (std::size_t i = 0; i < 4; ++i) largest = std::max(largest, size_of(i));
  // Components of equal size (quarter turns have them) differ by the rounding of the others: then the first counts.
  constexpr double kTie = 4 / kQuaternionScale;
  std::size_t omitted = 0;
  while (size_of(omitted) < largest - kTie) ++omitted;
  SmallestThree packed;
  packed.omitted = static_cast<int>(omitted);
  const double sign = q[omitted] < 0 ? -1 : 1;
  for (std::size_t i = 0, o = 0; i < 4; ++i) {
    if (i == omitted) continue;
    packed.others[o++] = static_cast<std::int32_t>(std::lrint(sign * q[i] * kQuaternionScale));
  }
  return packed;
}

Eigen::Quaterniond unpack(const SmallestThree& packed) {
  std::array<double, 4> q{};
  double rest = 1;
  for (std::size_t i = 0, o = 0; i < 4; ++i) {
    if (static_cast<int>(i) == packed.omitted) continue;
    q[i] = packed.others[o++] / kQuaternionScale;
    rest -= q[i] * q[i];
  }
  q[static_cast<std::size_t>(packed.omitted)] = std::sqrt(std::max(0.0, rest));
  return {q[0], q[1], q[2], q[3]};
}

// Rounding may still make another component the largest; packing what was unpacked then settles it.
SmallestThree pack_stable(const SE3& pose) {
  SmallestThree packed = pack(Eigen::Quaterniond(pose.linear()).normalized());
  constexpr int kMaxRounds = 8;
  for (int round = 0; round < kMaxRounds; ++round) {
    const SmallestThree again = pack(Eigen::Quaterniond(unpack(packed).toRotationMatrix()).normalized());
    if (again == packed) break;
    packed = again;
  }
  return packed;
}

} // namespace

Bytes encode_pose(const motion::Motion::Pose& pose) {
  const SE3& transform = pose.canonical_to_world;
  if (!transform.matrix().allFinite() || transform.translation().cwiseAbs().maxCoeff() > kFarthest) {
    throw Error(ErrorCode::kFailure, "a pose is not finite or impossibly far away; it cannot be stored");
  }
  const SmallestThree packed = pack_stable(transform);
  Bytes out;
  put(out, kVersion);
  put(out, static_cast<std::uint8_t>(pose.health));
  put(out, static_cast<std::uint8_t>(packed.omitted));
  put(out, std::uint8_t{0});
  for (const std::int32_t component : packed.others) put(out, component);
  for (int a = 0; a < 3; ++a)
    put(out, static_cast<std::int64_t>(std::llrint(transform.translation()[a] * kMicrometres)));
  return out;
}

motion::Motion::Pose decode_pose(std::span<const std::byte> payload, const std::string& location) {
  const auto reject = [&location](const std::string& why) {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
  };
  if (payload.size() != kPoseBytes)
    reject(fmt::format("a pose has {} bytes instead of {}", payload.size(), kPoseBytes));
  if (const auto version = get<std::uint8_t>(payload, 0); version != kVersion) {
    reject(fmt::format("a pose has version {}; this Kinora reads version {}", version, kVersion));
  }
  const auto health = get<std::uint8_t>(payload, 1);
  if (health > static_cast<std::uint8_t>(motion::Health::kLost)) reject("a pose is neither tracked nor held nor lost");
  SmallestThree packed;
  packed.omitted = get<std::uint8_t>(payload, 2);
  if (packed.omitted > 3) reject("a pose omits a component that a quaternion does not have");
  double squares = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    packed.others[i] = get<std::int32_t>(payload, 4 + 4 * i);
    squares += std::pow(packed.others[i] / kQuaternionScale, 2);
  }
  constexpr double kMaxOthers = 0.75 + 1e-6; // the omitted component is the largest of four
  if (squares > kMaxOthers) reject("a pose holds no unit quaternion");
  motion::Motion::Pose pose;
  pose.health = static_cast<motion::Health>(health);
  pose.canonical_to_world.linear() = unpack(packed).toRotationMatrix();
  for (int a = 0; a < 3; ++a) {
    const auto micrometres = get<std::int64_t>(payload, 16 + 8 * static_cast<std::size_t>(a));
    pose.canonical_to_world.translation()[a] = static_cast<double>(micrometres) / kMicrometres;
    if (std::abs(pose.canonical_to_world.translation()[a]) > kFarthest + 1) reject("a pose is impossibly far away");
  }
  return pose;
}

} // namespace kinora::clip
