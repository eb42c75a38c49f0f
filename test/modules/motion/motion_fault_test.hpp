#pragma once
// Anything that may happen to a motion manager, in any order, and what has to hold all the same:
//   - no motion begins that the state of the machine, a capability or the emergency stop forbids;
//   - a walk is stopped at most 200 ms after its last frame, and nothing walks that nobody has;
//   - only those move the body by servo who have at least the priority of who has it;
//   - the board is told numbers only, and no speed beyond the limits of the motion;
//   - everybody who asks is answered once.
// What happens is drawn from outside: by RapidCheck or from the bytes of a fuzzer.

#include <functional>
#include <optional>
#include <string>

#include "musher/test/modules/motion/harness.hpp"

namespace musher::motion::testing {

class MotionFaultTest {
 public:
  // A number below its argument.
  using Draw = std::function<std::size_t(std::size_t below)>;

  explicit MotionFaultTest(Draw draw);

  // The first promise that is broken; nothing when all hold.
  std::optional<std::string> Run(int steps);

 private:
  template <class T>
  T Any(std::initializer_list<T> values) {
    return *(values.begin() + draw_(values.size()));
  }
  void Happen();
  void ServoFrame();
  void Command();
  void ChangeState();
  void ChangeBoard();

  void Watch(const MotionCore& before, const MotionEvent& event, const MotionActions& actions);
  void Judge(const BodyCommand& command, const MotionEvent& event);
  bool MayBegin(const BodyCommand& command, const MotionEvent& event) const;
  bool Allows(const std::string& capability) const;
  void CheckPriority(const MotionCore& before, const MotionEvent& event);
  void CheckRest(const MotionEvent& event);
  void Break(const std::string& promise);

  Draw draw_;
  Harness harness_;
  std::optional<std::string> broken_;
  std::int8_t last_life_ = 0;
  BodyCommand last_sent_;
  std::int8_t left_ = 0;  // the command that was left to the lie-down after it
};

}  // namespace musher::motion::testing
