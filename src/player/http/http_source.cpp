#include <algorithm>
#include <charconv>
#include <chrono>
#include <exception>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <httplib.h>

#include "container/byte_source.h"
#include "core/error.h"
#include "player/http/http_functions.h"

namespace kinora::player::http {
namespace {

constexpr std::uint64_t kMaxWhole = std::uint64_t{1} << 30; // from a server that gives no ranges
constexpr int kTries = 5;
constexpr std::chrono::milliseconds kFirstPause{200}; // before another try; then twice as long each time

struct Address {
  std::string server; ///< http://host:port
  std::string path;
};

Address parse(const std::string& text) {
  const std::size_t host = text.find("://") + 3;
  const std::size_t path = std::min(text.find('/', host), text.size());
  if (path == host) throw Error(ErrorCode::kUsage, fmt::format("{} names no server; is the address right?", text));
  const std::string rest = text.substr(path, text.find('#', path) - path);
  return {text.substr(0, path), rest.empty() ? "/" : rest};
}

struct ContentRange {
  std::uint64_t first = 0, size = 0; ///< of the answer's first byte; of the whole file
};

/// "bytes 0-99/1234"
std::optional<ContentRange> parse_content_range(const std::string& text) {
  ContentRange range;
  const std::size_t slash = text.find('/');
  if (text.rfind("bytes ", 0) != 0 || slash == std::string::npos) return std::nullopt;
  const char* const end = text.data() + text.size();
  if (std::from_chars(text.data() + 6, end, range.first).ec != std::errc()) return std::nullopt;
  if (std::from_chars(text.data() + slash + 1, end, range.size).ec != std::errc()) return std::nullopt;
  return range;
}

class HttpSource final : public container::ByteSource {
public:
  HttpSource(std::string address, std::function<bool()> stopped)
      : name_(std::move(address)), stopped_(std::move(stopped)), address_(parse(name_)), client_(address_.server) {
    constexpr int kSeconds = 10;
    client_.set_keep_alive(true);
    client_.set_follow_location(true);
    client_.set_decompress(false);
    client_.set_connection_timeout(kSeconds);
    client_.set_read_timeout(kSeconds);
    std::byte first{};
    fetch(0, std::span(&first, 1));
  }

  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return size_; }

  void read(std::uint64_t offset, std::span<std::byte> out) override {
    if (!whole_.empty()) {
      std::copy_n(whole_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    } else {
      fetch(offset, out);
    }
  }

  bool may_grow() const override { return true; }
  void refresh() override {
    if (!whole_.empty()) return; // all of it again, for nothing in most cases
    std::byte first{};
    fetch(0, std::span(&first, 1));
  }

private:
  [[noreturn]] void fail(ErrorCode code, const std::string& why) const {
    throw Error(code, fmt::format("{}: {}", name_, why));
  }

  [[noreturn]] void corrupt(const std::string& why) const { fail(ErrorCode::kCorruptInput, why); }

  /// Goes on where a connection broke.
  void fetch(std::uint64_t offset, std::span<std::byte> out) {
    std::chrono::milliseconds pause = kFirstPause;
    for (int tries = 0; !out.empty(); ++tries) {
      if (tries == kTries) fail(ErrorCode::kFailure, fmt::format("{}; try again later", trouble_));
      if (tries > 0) {
        rest(pause);
        pause *= 2;
      }
      const std::size_t came = ask(offset, out);
      if (came > 0) tries = -1;
      if (came > 0) pause = kFirstPause;
      offset += came;
      out = out.subspan(came);
    }
  }

  void rest(std::chrono::milliseconds time) const {
    constexpr std::chrono::milliseconds kPiece{50};
    for (; time.count() > 0 && !stopped_(); time -= kPiece) std::this_thread::sleep_for(kPiece);
    if (stopped_()) fail(ErrorCode::kInterrupted, "interrupted while waiting for the server");
  }

  /// One request. Gives how many bytes came; if that is none, trouble_ says why.
  std::size_t ask(std::uint64_t offset, std::span<std::byte> out) {
    std::size_t came = 0;
    bool is_whole = false;
    std::vector<std::byte> whole;
    std::exception_ptr fault; // cpp-httplib is left by its own ways alone
    const auto guarded = [&](const auto& work) {
      try {
        return !stopped_() && work();
      } catch (const Error&) {
        fault = std::current_exception();
        return false;
      }
    };
    const auto head = [&](const httplib::Response& answer) {
      return guarded([&] { return look_at_head(answer, offset, is_whole); });
    };
    const auto body = [&](const char* data, std::size_t size) {
      return guarded([&] {
        const auto piece = std::as_bytes(std::span(data, size));
        if (is_whole) {
          take_whole(piece, whole);
        } else {
          if (came + size > out.size()) corrupt("the server gives more bytes than it was asked for");
          std::copy(piece.begin(), piece.end(), out.begin() + static_cast<std::ptrdiff_t>(came));
          came += size;
        }
        return true;
      });
    };
    const httplib::Headers headers{{"Range", fmt::format("bytes={}-{}", offset, offset + out.size() - 1)},
                                   {"Accept-Encoding", "identity"}};
    trouble_ = "the server ends the connection too early";
    const httplib::Result result = client_.Get(address_.path, headers, head, body);
    if (fault) std::rethrow_exception(fault);
    if (stopped_()) fail(ErrorCode::kInterrupted, "interrupted while reading");
    if (!result && (result.error() == httplib::Error::Connection || result.error() == httplib::Error::SSLConnection)) {
      trouble_ = "the server cannot be reached";
    }
    if (!is_whole) return came;
    if (!result) return 0;
    size_ = whole.size();
    if (offset + out.size() > size_) corrupt("it has become shorter; open it again");
    std::copy_n(whole.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    whole_ = std::move(whole);
    return out.size();
  }

  void take_whole(std::span<const std::byte> piece, std::vector<std::byte>& whole) const {
    if (whole.size() + piece.size() > kMaxWhole) {
      fail(ErrorCode::kFailure,
           "it is larger than 1 GB, and the server gives no parts of it; fetch it and play the file");
    }
    whole.insert(whole.end(), piece.begin(), piece.end());
  }

  /// False if another try may help.
  bool look_at_head(const httplib::Response& answer, std::uint64_t offset, bool& is_whole) {
    if (answer.status >= 500) {
      trouble_ = fmt::format("the server answers with status {}", answer.status);
      return false;
    }
    if (answer.status != 200 && answer.status != 206) {
      const bool absent = answer.status == 404 || answer.status == 410;
      const std::string why = absent ? "there is no such file" : "the server refuses it";
      fail(size_ == 0 ? ErrorCode::kNotRecognised : ErrorCode::kCorruptInput,
           answer.status == 416 ? "it is empty or has become shorter; open it again"
                                : fmt::format("{} (status {})", why, answer.status));
    }
    const std::string tag = answer.get_header_value("ETag");
    if (answer.status == 206) {
      const auto range = parse_content_range(answer.get_header_value("Content-Range"));
      if (!range || range->first != offset || range->size == 0) {
        corrupt("the server gives other bytes than it was asked for");
      }
      // A file that grows has another tag each time; its end says whether it is still the same clip.
      if (range->size < size_ || (range->size == size_ && tag != tag_)) {
        corrupt("it was changed while it was read; open it again");
      }
      size_ = range->size;
    }
    is_whole = answer.status == 200;
    tag_ = tag;
    return true;
  }

  std::string name_;
  std::function<bool()> stopped_;
  Address address_;
  httplib::Client client_;
  std::uint64_t size_ = 0;
  std::string tag_;
  std::vector<std::byte> whole_; ///< from a server that gives no ranges
  std::string trouble_;
};

} // namespace

std::unique_ptr<container::ByteSource> open_address(const std::string& address, const std::function<bool()>& stopped) {
  return std::make_unique<HttpSource>(address, stopped);
}

} // namespace kinora::player::http
