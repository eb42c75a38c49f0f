#pragma once
// The motion manager's decision code, alone with a board and a virtual clock.

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
  // In Active, the body standing (recovery stand), unless stated otherwise.
  Harness();

  // The body's motion, ended, without a command.
  void Body(std::int32_t id);
  // Runs reports of the board and timers for that time.
  void RunFor(Duration duration);
  // The program is suspended for that time; then its timers run before the queued messages are
  // read.
  void StandStill(Duration duration);
  // Until the request is answered; its code, -1 when that takes more than 200 s.
  std::int32_t CodeOf(RequestToken token);

  void Do(const MotionEvent& event);
  // A result command; its token.
  RequestToken RequestMotion(std::int32_t id, std::int32_t source = 0,
                             const MotionArguments& arguments = {});
  RequestToken Play(std::vector<MotionRequest> requests, std::int32_t source = 0);
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

  RequestToken requests_made() const { return token_; }  // as many requests were made

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
  std::vector<motion_action::ServoResponse> responses;
  std::vector<std::string> log;
  std::vector<std::int32_t> reported;  // to the machine's manager
  std::vector<std::string> announced;
  // Observes every step: the core before it, the event, and the actions.
  std::function<void(const MotionCore& before, const MotionEvent&, const MotionActions&)> watch;

 private:
  MotionRules Rules() const { return {TheTable(), config, gate_}; }

  Gate gate_;
  RequestToken token_ = 0;
  Time next_report_;
};

}  // namespace musher::motion::testing
