#pragma once
// The motion manager's decision code, alone with a board and the clock in its hand.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/motion/motion_core.hpp"
#include "musher/test/modules/motion/board.hpp"

namespace musher::motion::testing {

// The table that is installed.
const MotionTable& TheTable();

class Harness {
 public:
  // In Active, the body standing (recovery stand), unless something else is said.
  Harness();

  // The body's motion, ended, without anybody having commanded it.
  void Body(std::int32_t id);
  // Reports of the board and timers for so long.
  void RunFor(Duration duration);
  // The program stands still for so long; then its timers come before what waits to be read.
  void StandStill(Duration duration);
  // Until the request is answered; its code, -1 when that takes more than 200 s.
  std::int32_t CodeOf(RequestToken token);

  void Do(const MotionEvent& event);
  // A result command; its token.
  RequestToken Ask(std::int32_t id, std::int32_t source = 0, const MotionArguments& arguments = {});
  RequestToken Play(std::vector<MotionOrder> orders, std::int32_t source = 0);
  RequestToken LieDown(std::int32_t id, int tries);
  // A servo frame.
  void Servo(std::int32_t id, std::int32_t source = 0, std::vector<float> vel = {0.2F, 0, 0},
             std::int32_t type = ServoCommand::kData);
  // A frame every 50 ms.
  void Stream(std::int32_t id, Duration duration, std::int32_t source = 0);

  // Ids of the motions commanded, repetitions left out.
  std::vector<std::int32_t> Commanded() const;
  // The code of the last servo response, -1 when there was none.
  std::int32_t ServoCode() const;
  std::size_t LogLines() const { return log.size(); }

  RequestToken asked() const { return token_; }  // as many requests were made

  struct Sent {
    Time at;
    BodyCommand command;
  };
  MotionConfig config;
  std::map<std::string, Error> refused;  // by capability; "" concerns all
  MotionCore core;
  Board board;
  Time now{std::chrono::hours(1)};
  std::vector<Sent> sent;
  std::map<RequestToken, motion_action::Answer> answers;
  std::vector<motion_action::TellServo> told;
  std::vector<std::string> log;
  std::vector<std::int32_t> reported;  // to the machine's manager
  std::vector<std::string> said;
  // Sees every step: the core as it was, what happened, and what was decided.
  std::function<void(const MotionCore& before, const MotionEvent&, const MotionActions&)> watch;

 private:
  MotionRules Rules() const { return {TheTable(), config, gate_}; }

  Gate gate_;
  RequestToken token_ = 0;
  Time next_report_;
};

}  // namespace musher::motion::testing
