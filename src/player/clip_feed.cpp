#include "player/clip_feed.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <utility>

#include <fmt/format.h>

#include "core/error.h"

namespace kinora::player {
namespace {

constexpr std::size_t kPieceBytes = 1 << 17;
constexpr std::size_t kHeadBytes =
    4096;                          // that a writer changes when it has finished; where the index is stands in them
constexpr double kPatience = 0.25; // seconds of waiting after which a part is worth making ready
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

void ClipFeed::seek(double seconds) {
  const std::lock_guard lock(mutex_);
  sought_ = seconds;
}

void ClipFeed::follow(const std::stop_token& stop) {
  read_to_end(stop);
  while (!stop.stop_requested() && source_->may_grow() && !finished()) {
    if (held_.size() != ready_bytes_) make_ready();
    tell(false, "this is all so far; waiting for more");
    rest(stop);
    source_->refresh();
    index_.reset();
    read_head_again();
    read_to_end(stop);
  }
  if (stop.stop_requested()) return;
  make_ready();
  tell(true, missing_);
  held_.clear();
}

void ClipFeed::read_to_end(const std::stop_token& stop) {
  while (!stop.stop_requested() && !all_there()) {
    if (source_->size() > kMaxBytes) {
      throw Error(ErrorCode::kFailure,
                  fmt::format("{} is larger than {} MB; cut it with kinora cut", source_->name(), kMaxBytes >> 20));
    }
    look_for_sought();
    read_piece(next_missing());
    const std::string come = fmt::format("{} % has come", 100 * held_.size() / source_->size());
    if (all_there()) continue; // whoever called makes it ready; what is small is ready soon
    if (!readiness_ && held_.size() >= first_look_bytes_) take_first_look(come);
    const bool is_urgent = due_ && !held_.missing(due_->begin, due_->end);
    if (is_urgent) due_.reset();
    const double patience = readiness_ == Readiness::kFirstLook ? kPatienceOfAFirstLook : kPatience;
    if (!is_urgent && seconds_() - looked_at_ < patience) continue;
    tell(false, come);
    make_ready();
  }
}

void ClipFeed::read_piece(const ByteRange& missing) {
  std::vector<std::byte> piece(
      static_cast<std::size_t>(std::min<std::uint64_t>(missing.end - missing.begin, kPieceBytes)));
  source_->read(missing.begin, piece);
  held_.add(missing.begin, piece);
}

void ClipFeed::look_for_sought() {
  std::optional<double> sought;
  {
    const std::lock_guard lock(mutex_);
    if (held_.front().empty()) return; // it says where the index is
    sought = std::exchange(sought_, std::nullopt);
  }
  if (!sought) return;
  if (!index_)
    index_ = container::CueIndex::read(held_.front().first(std::min(held_.front().size(), kHeadBytes)), *source_);
  if (!*index_) return;
  const ByteRange bytes = (*index_)->bytes_for(*sought);
  if (!held_.missing(bytes.begin, bytes.end)) return;
  from_ = bytes.begin;
  due_ = bytes;
}

ClipFeed::ByteRange ClipFeed::next_missing() const {
  const std::optional<ByteRange> behind = held_.missing(from_, source_->size());
  return behind ? *behind : held_.missing(0, source_->size()).value();
}

// It says how long the file is, once its writer knows.
void ClipFeed::read_head_again() {
  std::vector<std::byte> head(std::min(held_.front().size(), kHeadBytes));
  source_->read(0, head);
  held_.replace(0, head);
}

bool ClipFeed::finished() { return state_of(held_.all(), source_->name()) == FileState::kFinished; }

void ClipFeed::take_first_look(const std::string& message) {
  first_look_bytes_ = 2 * held_.size();
  ArrivedClip arrived = read_arrived(held_.all(), source_->name(), false);
  if (!arrived.has_all_layers()) return;
  tell(false, message);
  show(std::move(arrived), Readiness::kFirstLook);
  looked_at_ = seconds_();
}

// A source that fails leaves what has come before.
void ClipFeed::make_ready_what_came() {
  try {
    if (held_.size() > ready_bytes_) make_ready();
  } catch (const std::exception&) { // what shows already stays
  }
}

void ClipFeed::make_ready() {
  ArrivedClip arrived = read_arrived(held_.all(), source_->name(), all_there() && finished());
  ready_bytes_ = held_.size();
  missing_ = arrived.missing;
  if (arrived.clip) show(std::move(arrived), Readiness::kWhole);
  looked_at_ = seconds_();
}

void ClipFeed::show(ArrivedClip arrived, Readiness readiness) {
  auto player = std::make_shared<const Player>(std::move(*arrived.clip), readiness);
  readiness_ = readiness;
  const std::lock_guard lock(mutex_);
  newest_.player = std::move(player);
  newest_.times = std::move(arrived.times);
  newest_.there = std::move(arrived.there);
  newest_.bytes = source_->size();
}

void ClipFeed::tell(bool complete, std::string message) {
  const std::lock_guard lock(mutex_);
  newest_.complete = complete;
  newest_.bytes = source_->size();
  newest_.message = std::move(message);
}

} // namespace kinora::player
