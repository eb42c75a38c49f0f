#pragma once
// Gives a motion board on LCM the gait of a user: the text of its sections and, once the board has
// accepted it, that of its steps. Pure: each event comes with the time and gives an output;
// lcm_backend.hpp turns datagrams and timers into events.
//
// clang-format off
//              Begin()               accepted            accepted
//   free ─────────────────▶ sections ─────────▶ steps ─────────────▶ free, defined
//    ▲                          │  refused, or no answer in 1 s  │
//    └── all answers, or 5 s ───┴────────── waiting ◀────────────┘
// clang-format on
//
// Rules:
//   - An answer of the board has no number: one that comes after its limit, or is that to the text
//     of another program, would be taken for the answer to the next text. So no definition begins
//     before all texts are answered, or 5 s have passed.
//   - A text of another program replaces what the board has: a definition in progress has failed.
//   - A lost datagram is not repeated, for the same reason.
//
// Threads: any; a plain value.

#include <optional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/modules/motion/user_gait.hpp"

namespace musher::motion {

inline constexpr Duration kGaitAnswer = Milliseconds(1000);      // of the board, to one text
inline constexpr Duration kLateGaitAnswer = Milliseconds(5000);  // after it none comes any more

class GaitDefinition {
 public:
  struct Output {
    std::optional<std::string> text;  // to send to the board
    std::optional<Result<>> ended;    // the outcome
  };

  Output Begin(const UserGait& gait, Time now);
  Output OnAnswer(bool accepted, Time now);
  // A text on the board's channel that is not of this process.
  Output OnOtherText(const std::string& sender, Time now);
  Output OnSendFailed(const Error& error);
  Output OnTime(Time now);

  // When to call OnTime(); nullopt: never.
  std::optional<Time> NextDeadline() const;

 private:
  struct Definition {
    std::string steps;  // sent once the sections are accepted
    bool sent_steps = false;
    Time answered_by{};
  };

  std::string NameOfText() const { return definition_->sent_steps ? "steps" : "sections"; }
  Output End(Result<> result);

  std::optional<Definition> definition_;
  int unanswered_ = 0;  // texts, without that of the definition
  Time late_until_{};   // then their answers are given up
};

}  // namespace musher::motion
