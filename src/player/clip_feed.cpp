#include "player/clip_feed.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>

#include <fmt/format.h>

#include "core/error.h"
#include "player/arrived_clip.h"

namespace kinora::player {
namespace {

constexpr std::size_t kPieceBytes = 1 << 17;
constexpr double kPatience = 0.25;                      // seconds of waiting after which a part is worth making ready
constexpr double kPatienceOfAFirstLook = 1;             // the same, while one is to be seen
constexpr std::chrono::milliseconds kBetweenLooks{500}; // at a file that is being written

void rest(const std::stop_token& stop) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any().wait_for(lock, stop, kBetweenLooks, [] { return false; });
}

} // namespace

ClipFeed::ClipFeed(std::unique_ptr<container::ByteSource> source, MasterClock seconds)
    : source_(std::move(source)), seconds_(std::move(seconds)), looked_at_(seconds_()),
      thread_([this](const std::stop_token& stop) {
        try {
          follow(stop);
        } catch (const std::exception& error) {
          make_ready_what_came();
          tell(true, error.what());
          const std::lock_guard lock(mutex_);
          fault_ = std::current_exception();
        }
      }) {}

ClipSoFar ClipFeed::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

ClipSoFar ClipFeed::first(const std::function<bool()>& stopped) const {
  constexpr std::chrono::milliseconds kPause{5};
  while (!stopped()) {
    {
      const std::lock_guard lock(mutex_);
      if (newest_.player) return newest_;
      if (fault_) std::rethrow_exception(fault_);
    }
    std::this_thread::sleep_for(kPause);
  }
  throw Error(ErrorCode::kInterrupted, "interrupted before anything could be shown");
}

void ClipFeed::follow(const std::stop_token& stop) {
  read_to_end(stop);
  while (!stop.stop_requested() && source_->may_grow() && !finished()) {
    if (bytes_.size() != ready_bytes_) make_ready();
    tell(false, "this is all so far; waiting for more");
    rest(stop);
    source_->refresh();
    read_head_again();
    read_to_end(stop);
  }
  if (stop.stop_requested()) return;
  make_ready();
  tell(true, missing_);
  bytes_ = {};
}

void ClipFeed::read_to_end(const std::stop_token& stop) {
  while (!stop.stop_requested() && bytes_.size() < source_->size()) {
    if (source_->size() > kMaxBytes) {
      throw Error(ErrorCode::kFailure,
                  fmt::format("{} is larger than {} MB; cut it with kinora cut", source_->name(), kMaxBytes >> 20));
    }
    const std::size_t start = bytes_.size();
    std::vector<std::byte> piece(
        static_cast<std::size_t>(std::min<std::uint64_t>(source_->size() - start, kPieceBytes)));
    source_->read(start, piece);
    bytes_.insert(bytes_.end(), piece.begin(), piece.end());
    const std::string come = fmt::format("{} % has come", 100 * bytes_.size() / source_->size());
    if (bytes_.size() == source_->size()) continue; // whoever called makes it ready; what is small is ready soon
    if (!readiness_ && bytes_.size() >= first_look_bytes_) take_first_look(come);
    const double patience = readiness_ == Readiness::kFirstLook ? kPatienceOfAFirstLook : kPatience;
    if (seconds_() - looked_at_ < patience) continue;
    tell(false, come);
    make_ready();
  }
}

void ClipFeed::read_head_again() {
  constexpr std::size_t kHeadBytes = 4096; // it says how long the file is, once its writer knows
  source_->read(0, std::span(bytes_).first(std::min(bytes_.size(), kHeadBytes)));
}

bool ClipFeed::finished() const { return state_of(bytes_, source_->name()) == FileState::kFinished; }

void ClipFeed::take_first_look(const std::string& message) {
  first_look_bytes_ = 2 * bytes_.size();
  ArrivedClip arrived = read_arrived(bytes_, source_->name(), false);
  if (!arrived.has_all_layers()) return;
  tell(false, message);
  show(std::move(*arrived.clip), Readiness::kFirstLook);
  looked_at_ = seconds_();
}

// A source that fails leaves what has come before.
void ClipFeed::make_ready_what_came() {
  try {
    if (bytes_.size() > ready_bytes_) make_ready();
  } catch (const std::exception&) { // what shows already stays
  }
}

void ClipFeed::make_ready() {
  ArrivedClip arrived = read_arrived(bytes_, source_->name(), bytes_.size() == source_->size() && finished());
  if (arrived.clip) show(std::move(*arrived.clip), Readiness::kWhole);
  ready_bytes_ = bytes_.size();
  missing_ = std::move(arrived.missing);
  looked_at_ = seconds_();
}

void ClipFeed::show(clip::Clip clip, Readiness readiness) {
  auto player = std::make_shared<const Player>(std::move(clip), readiness);
  readiness_ = readiness;
  const std::lock_guard lock(mutex_);
  newest_.player = std::move(player);
  newest_.bytes = source_->size();
}

void ClipFeed::tell(bool complete, std::string message) {
  const std::lock_guard lock(mutex_);
  newest_.complete = complete;
  newest_.bytes = source_->size();
  newest_.message = std::move(message);
}

} // namespace kinora::player
