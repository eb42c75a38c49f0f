#pragma once
// A log that a flood cannot fill: of each kind a line at once, then at most one a period, with the
// number of suppressed lines. A publisher of ten thousand invalid words a second is reported
// without filling the disk.
//
//   RateLimitedLog log([](const std::string& line) { … }, std::chrono::seconds(2));
//   log.Log("target", "the target is 40 m away", now);
//
// One thread.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "musher/base/time.hpp"

namespace musher {

class RateLimitedLog {
 public:
  using WriteLine = std::function<void(const std::string& line)>;

  RateLimitedLog(WriteLine write, Duration period) : write_(std::move(write)), period_(period) {}

  // `kind`: lines of one kind suppress one another. A fixed few names, since each is kept: never
  // text from outside.
  void Log(std::string_view kind, const std::string& line, Time now) {
    auto found = kinds_.find(kind);
    if (found == kinds_.end()) found = kinds_.emplace(std::string(kind), Kind()).first;
    Kind& of_kind = found->second;
    ++total_;
    if (of_kind.at && now >= *of_kind.at && now - *of_kind.at < period_) {
      ++of_kind.suppressed;
      of_kind.line = line;
      return;
    }
    Write(of_kind, line, now);
  }
  // Writes what was suppressed and is due. To be called at least once a period.
  void Tick(Time now) {
    for (auto& [name, kind] : kinds_) {
      if (kind.suppressed == 0 || now - *kind.at < period_) continue;
      --kind.suppressed;
      Write(kind, std::string(kind.line), now);
    }
  }
  // The number of lines logged, suppressed ones included.
  std::uint64_t total() const { return total_; }

 private:
  struct Kind {
    std::optional<Time> at;        // when the last line was written
    std::uint64_t suppressed = 0;  // since then
    std::string line;              // the last of them
  };

  void Write(Kind& kind, const std::string& line, Time now) {
    write_(kind.suppressed == 0 ? line
                                : line + " (and " + std::to_string(kind.suppressed) + " more)");
    kind.at = now;
    kind.suppressed = 0;
  }

  const WriteLine write_;
  const Duration period_;
  std::map<std::string, Kind, std::less<>> kinds_;
  std::uint64_t total_ = 0;
};

}  // namespace musher
