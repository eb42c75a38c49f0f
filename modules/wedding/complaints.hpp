#pragma once
// What was wrong, for the log: each kind at once, then at most once a period, with how many there
// were in between. Whoever sends ten thousand wrong words a second is told, and fills no disk.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "musher/lifecycle/time.hpp"

namespace musher::wedding {

enum class Complaint {
  kTarget,
  kGesture,
  kFaces,
  kJoints,
  kVoice,
  kCommand,  // nobody knows it
  kResting,  // a command while the show rests
  kNoRoom,   // too many wait
  kFault,    // a state failed
  kCount
};

class Complaints {
 public:
  using SayLine = std::function<void(const std::string& line)>;

  explicit Complaints(SayLine say) : say_(std::move(say)) {}

  void Tell(Complaint kind, const std::string& line, Time now) {
    Kind& told = kinds_.at(static_cast<std::size_t>(kind));
    ++total_;
    if (told.at && now >= *told.at && now - *told.at < kPeriod) {
      ++told.silent;
      told.line = line;
      return;
    }
    Say(told, line, now);
  }
  // Tells what was kept back and is due. Each tick.
  void Tick(Time now) {
    for (Kind& kind : kinds_) {
      if (kind.silent == 0 || now - *kind.at < kPeriod) continue;
      --kind.silent;
      Say(kind, std::string(kind.line), now);
    }
  }
  std::uint64_t total() const { return total_; }

 private:
  static constexpr Duration kPeriod = Milliseconds(2000);
  struct Kind {
    std::optional<Time> at;
    std::uint64_t silent = 0;  // since then
    std::string line;          // the last of them
  };

  void Say(Kind& kind, const std::string& line, Time now) {
    say_(kind.silent == 0 ? line : line + " (and " + std::to_string(kind.silent) + " like it)");
    kind.at = now;
    kind.silent = 0;
  }

  const SayLine say_;
  std::array<Kind, static_cast<std::size_t>(Complaint::kCount)> kinds_{};
  std::uint64_t total_ = 0;
};

}  // namespace musher::wedding
