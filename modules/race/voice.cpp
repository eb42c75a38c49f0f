#include "musher/modules/race/voice.hpp"

#include <algorithm>
#include <utility>

#include "musher/cyberdog/codes/module_codes.hpp"  // names modules in texts

namespace musher::race {

void Voice::Begin(Index speech, const Memory& memory, Duration now) {
  const Speech& rule = course_.speeches[speech];
  speech_ = speech;
  phrases_.clear();
  begun_ = 0;
  speaking_ = false;
  const int pauses = static_cast<int>(rule.phrases.size());
  limit_at_ = now + std::max(rule.limit, pauses * rule.every);
  if (!rule.result) {
    for (const Phrase& phrase : rule.phrases) Add(phrase);
    return;
  }
  for (const Speech::OfValue& of : rule.of_values) {
    if (memory.Value(*rule.result) == of.value) Add(of.phrase);
  }
}

bool Voice::Advance(Duration now) {
  const Speech& rule = course_.speeches[speech_];
  const bool over = begun_ == 0 || (!speaking_ && now - begun_at_ >= rule.every);
  if (over && begun_ == phrases_.size()) return true;
  if (now >= limit_at_) {
    outputs_.Log("the speech " + rule.name + " has not ended within its limit; it continues");
    Stop();
    return true;
  }
  if (!over) return false;
  begun_at_ = now;
  speaking_ = true;
  outputs_.Speak(phrases_[begun_++], ++number_);
  return false;
}

void Voice::Pause() {
  if (!std::exchange(speaking_, false)) return;
  --begun_;
  ++number_;  // a late reply is that of no phrase
}

void Voice::OnSpoken(std::uint64_t number, const Result<>& spoken) {
  if (number != number_ || !speaking_) return;
  speaking_ = false;
  if (!spoken) outputs_.Log("not spoken: " + ErrorText(spoken.error()));
}

}  // namespace musher::race
