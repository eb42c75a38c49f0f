#pragma once
// A rate-limited log of faults: each kind at once, then at most once a period, with the number of
// suppressed lines. A publisher of ten thousand invalid words a second is reported without filling
// the disk.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "musher/base/time.hpp"

namespace musher::wedding {

enum class LogKind {
  kTarget,
  kGesture,
  kFaces,
  kJoints,
  kVoice,
  kCommand,  // unknown
  kResting,  // a command while the show is paused
  kNoRoom,   // the queue is full
  kFault,    // a state failed
  kCount
};

class RateLimitedLog {
 public:
  using WriteLine = std::function<void(const std::string& line)>;

  explicit RateLimitedLog(WriteLine write) : write_(std::move(write)) {}

  void Log(LogKind kind, const std::string& line, Time now) {
    Kind& of_kind = kinds_.at(static_cast<std::size_t>(kind));
    ++total_;
    if (of_kind.at && now >= *of_kind.at && now - *of_kind.at < kPeriod) {
      ++of_kind.silent;
      of_kind.line = line;
      return;
    }
    Write(of_kind, line, now);
  }
  // Logs what was suppressed and is due. Each tick.
  void Tick(Time now) {
    for (Kind& kind : kinds_) {
      if (kind.silent == 0 || now - *kind.at < kPeriod) continue;
      --kind.silent;
      Write(kind, std::string(kind.line), now);
    }
  }
  std::uint64_t total() const { return total_; }

 private:
  static constexpr Duration kPeriod = Milliseconds(2000);
  struct Kind {
    std::optional<Time> at;
    std::uint64_t silent = 0;  // suppressed since then
    std::string line;          // the last of them
  };

  void Write(Kind& kind, const std::string& line, Time now) {
    write_(kind.silent == 0 ? line : line + " (and " + std::to_string(kind.silent) + " more)");
    kind.at = now;
    kind.silent = 0;
  }

  const WriteLine write_;
  std::array<Kind, static_cast<std::size_t>(LogKind::kCount)> kinds_{};
  std::uint64_t total_ = 0;
};

}  // namespace musher::wedding
