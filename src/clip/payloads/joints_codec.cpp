#include "clip/payloads/joints_codec.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "clip/coding/range_coder.h"
#include "container/little_endian.h"
#include "core/error.h"

namespace kinora::clip {

using container::get;
using container::put;
using motion::JointPaths;

namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kHeaderBytes = 2;
constexpr std::size_t kMaxJoints = 64;
constexpr std::size_t kLongestName = 32;
constexpr double kUnit = 1.0 / 512;                   // metres
constexpr std::int32_t kFarthest = 1 << 23;           // units
constexpr const char* kWriterLocation = "the joints"; // of what is written

using QuantisedPosition = std::array<std::int32_t, 3>;
using Frame = std::vector<QuantisedPosition>; // one for each joint

bool is_name(const std::string& name) {
  const auto is_plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && name.size() <= kLongestName && std::all_of(name.begin(), name.end(), is_plain);
}

// A joint is expected to have moved since the frame before as the one coded before it in this frame; the first, not to
// have moved. In the first frame all are expected where the one coded before is.
template <class Coder>
void code_frame(Coder& coder, std::array<IntegerModel, 3>& models, const Frame& last, Frame& now,
                const std::string& location) {
  for (std::size_t j = 0; j < now.size(); ++j) {
    for (std::size_t a = 0; a < 3; ++a) {
      std::int32_t expected = last.empty() ? 0 : last[j][a];
      if (j > 0) expected += now[j - 1][a] - (last.empty() ? 0 : last[j - 1][a]);
      expected = std::clamp(expected, -kFarthest, kFarthest);
      // A difference has less than 2³¹ units: no sum of an enemy's overflows once it is clamped to twice the range.
      const std::int32_t difference = code_integer(coder, models[a], now[j][a] - expected);
      now[j][a] = expected + std::clamp(difference, -3 * kFarthest, 3 * kFarthest);
      if (std::abs(now[j][a]) > kFarthest) {
        throw Error(ErrorCode::kCorruptInput, fmt::format("{}: joint {} is too far away", location, j));
      }
    }
  }
}

std::uint64_t memory_of(std::size_t joints, std::size_t frames) {
  return std::uint64_t{frames} * (sizeof(std::vector<Eigen::Vector3d>) + joints * sizeof(Eigen::Vector3d));
}

// As the reader will.
void check(const JointPaths& joints) {
  const auto refuse = [](const std::string& why) {
    throw Error(ErrorCode::kFailure, fmt::format("the joints of a layer cannot be stored: {}", why));
  };
  if (joints.names.empty() || joints.names.size() > kMaxJoints) {
    refuse(fmt::format("they are {}, and 1 to {} can be", joints.names.size(), kMaxJoints));
  }
  for (const std::string& name : joints.names) {
    if (!is_name(name)) refuse(fmt::format("\"{}\" is no name for one", name));
  }
  for (const std::vector<Eigen::Vector3d>& frame : joints.positions) {
    if (frame.size() != joints.names.size()) refuse("a frame has not one place for each");
    for (const Eigen::Vector3d& position : frame) {
      if (!((position.array().abs() <= kUnit * kFarthest).all())) refuse("one is too far away");
    }
  }
}

} // namespace

Bytes encode_joints(const JointPaths& joints) {
  check(joints);
  Bytes out;
  put(out, kVersion);
  put(out, static_cast<std::uint8_t>(joints.names.size()));
  for (const std::string& name : joints.names) {
    put(out, static_cast<std::uint8_t>(name.size()));
    const auto bytes = std::as_bytes(std::span(name));
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  RangeEncoder coder;
  std::array<IntegerModel, 3> models;
  Frame last;
  for (const std::vector<Eigen::Vector3d>& positions : joints.positions) {
    Frame now(positions.size());
    for (std::size_t j = 0; j < positions.size(); ++j) {
      for (std::size_t a = 0; a < 3; ++a) {
        now[j][a] = static_cast<std::int32_t>(std::lround(positions[j][static_cast<Eigen::Index>(a)] / kUnit));
      }
    }
    code_frame(coder, models, last, now, kWriterLocation);
    last = std::move(now);
  }
  const Bytes coded = coder.finish();
  out.insert(out.end(), coded.begin(), coded.end());
  return out;
}

JointPaths decode_joints(std::span<const std::byte> payload, std::size_t frames, const std::string& location,
                         AllocationBudget& budget) {
  const auto reject = [&location](const std::string& why) {
    throw Error(ErrorCode::kCorruptInput, fmt::format("{}: {}", location, why));
  };
  if (payload.size() < kHeaderBytes) reject("joints are too short");
  if (const auto version = get<std::uint8_t>(payload, 0); version != kVersion) {
    reject(fmt::format("joints have version {}; this Kinora reads version {}", version, kVersion));
  }
  const std::size_t count = get<std::uint8_t>(payload, 1);
  if (count == 0 || count > kMaxJoints) reject(fmt::format("a skeleton has {} joints", count));
  budget.take(memory_of(count, frames), location);
  JointPaths joints;
  std::size_t at = kHeaderBytes;
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t size = at < payload.size() ? get<std::uint8_t>(payload, at) : 0;
    if (payload.size() - at < 1 + size) reject("a joint's name is cut short");
    const auto* const text = reinterpret_cast<const char*>(payload.data() + at + 1);
    joints.names.emplace_back(text, size);
    if (!is_name(joints.names.back())) reject(fmt::format("joint {} has an impossible name", j));
    at += 1 + size;
  }
  RangeDecoder coder(payload.subspan(at), location);
  std::array<IntegerModel, 3> models;
  Frame last;
  for (std::size_t f = 0; f < frames; ++f) {
    Frame now(count);
    code_frame(coder, models, last, now, location);
    std::vector<Eigen::Vector3d>& positions = joints.positions.emplace_back();
    for (const QuantisedPosition& p : now) positions.push_back(kUnit * Eigen::Vector3d(p[0], p[1], p[2]));
    last = std::move(now);
  }
  coder.finish();
  return joints;
}

std::uint64_t decoding_memory(const JointPaths& joints) {
  return memory_of(joints.names.size(), joints.positions.size());
}

} // namespace kinora::clip
