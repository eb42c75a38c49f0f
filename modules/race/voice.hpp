#pragma once
// The voice of the race: the phrases of a speech, one after the other. Speech never fails a race:
// what is not spoken is logged. Pure.
//
// Times are those of the machine, which stands still in a pause. One thread.

#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/race/memory.hpp"
#include "musher/modules/race/outputs.hpp"

namespace musher::race {

class Voice {
 public:
  Voice(const Course& course, RaceOutputs& outputs) : course_(course), outputs_(outputs) {}

  // A speech about a result that is not known says nothing.
  void Begin(Index speech, const Memory& memory, Duration now);
  // Each tick; returns true when all is said, or the limit is reached.
  bool Advance(Duration now);
  void Stop() { phrases_.clear(); }
  // The phrase under way is repeated.
  void Pause();
  // It has been held for so long, which counts toward no limit.
  void Prolong(Duration held) { limit_at_ += held; }

  void OnSpoken(std::uint64_t number, const Result<>& spoken);

 private:
  void Add(const Phrase& phrase) {
    phrases_.push_back(course_.language == Language::kChinese ? phrase.chinese : phrase.english);
  }

  const Course& course_;
  RaceOutputs& outputs_;
  Index speech_ = 0;
  std::vector<std::string> phrases_;
  Index begun_ = 0;  // how many of them
  bool speaking_ = false;
  std::uint64_t number_ = 0;  // of the last one
  Duration begun_at_{};       // the last one
  Duration limit_at_{};
};

}  // namespace musher::race
