#pragma once
// Random events for a motion manager, in any order, and the invariants that must hold:
//   - no motion begins that the state of the machine, a capability or the emergency stop forbids;
//   - a walk is stopped at most 200 ms after its last frame, and no walk continues without a
//     source;
//   - a servo source moves the body only with at least the priority of the controlling source;
//   - the board gets finite numbers only, and no speed beyond the limits of the motion;
//   - every request is answered once.
// The events are sampled from outside: by RapidCheck or from the bytes of a fuzzer.

#include <functional>
#include <optional>
#include <string>

#include "musher/test/modules/motion/harness.hpp"

namespace musher::motion::testing {

class MotionFaultTest {
 public:
  // Returns a number below its argument.
  using Draw = std::function<std::size_t(std::size_t below)>;

  explicit MotionFaultTest(Draw draw);

  // The first violated invariant; nothing when all hold.
  std::optional<std::string> Run(int steps);

 private:
  template <class T>
  T Any(std::initializer_list<T> values) {
    return *(values.begin() + draw_(values.size()));
  }
  void Inject();
  void ServoFrame();
  void Command();
  void ChangeState();
  void ChangeBoard();

  void Watch(const MotionCore& before, const MotionEvent& event, const MotionActions& actions);
  void CheckCommand(const BodyCommand& command, const MotionEvent& event);
  bool MayBegin(const BodyCommand& command, const MotionEvent& event) const;
  bool Allows(const std::string& capability) const;
  void CheckPriority(const MotionCore& before, const MotionEvent& event);
  void CheckRest(const MotionEvent& event);
  void Violate(const std::string& invariant);

  Draw draw_;
  Harness harness_;
  std::optional<std::string> violation_;
  std::int8_t last_life_ = 0;
  BodyCommand last_sent_;
  std::int8_t left_ = 0;  // the command that was left to the lie-down after it
};

}  // namespace musher::motion::testing
