#include "musher/test/modules/race/drive/simulated_dog.hpp"

#include <algorithm>
#include <utility>

#include "musher/modules/motion/motion_wire.hpp"
#include "musher/modules/world/process/world_messages.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::race::testing {

using namespace motion;

namespace {

MotionTable TheTable() {
  auto reading = ReadTableFile(SourceDir() + "/config/motion/motions.toml");
  return std::move(*reading.table);
}

}  // namespace

SimulatedDog::SimulatedDog(world::Scene scene) : table_(TheTable()), world_(std::move(scene)) {
  Report();
  Take(motion_event::Opened{});
}

void SimulatedDog::Servo(const msg::MotionServoCmd& frame) {
  Take(motion_event::ServoArrived{FromWire(frame)});
}

void SimulatedDog::Play(std::int32_t motion_id, OnDone on_done) {
  const RequestToken token = ++last_token_;
  waiting_[token] = std::move(on_done);
  Take(motion_event::PlayArrived{token, kFromAlgorithm, {MotionRequest{motion_id, {}}}});
}

void SimulatedDog::Step() {
  world_.Step();
  Report();
  Take(motion_event::TimePassed{});
}

void SimulatedDog::Report() {
  const world::Body& body = world_.body();
  BodyReport report;
  report.mode = static_cast<std::int8_t>(body.mode());
  report.gait = static_cast<std::int8_t>(body.gait());
  report.bar = static_cast<std::int8_t>(body.progress_percent());
  report.switch_status = static_cast<std::int8_t>(body.status());
  report.life_count = body.life_count();
  Take(motion_event::BoardReported{report});
}

void SimulatedDog::Take(const MotionEvent& event) {
  for (const MotionAction& action : motion::Step(Rules(), core_, event, now())) {
    if (const auto* send = std::get_if<motion_action::Send>(&action)) {
      if (const auto command = world::FromMessage(ToWire(send->command))) {
        static_cast<void>(world_.Command(command.value()));
      }
    } else if (const auto* answer = std::get_if<motion_action::Answer>(&action)) {
      const auto caller = waiting_.extract(answer->token);
      if (!caller.empty()) caller.mapped()(answer->code);
    } else if (const auto* reply = std::get_if<motion_action::ServoResponse>(&action)) {
      if (on_servo_reply) on_servo_reply(ToWire(*reply));
    } else if (const auto* line = std::get_if<motion_action::Log>(&action)) {
      log_.push_back(line->text);
    }
  }
}

std::int32_t SimulatedDog::present_motion() const {
  return PresentMotion(Rules(), core_);
}

}  // namespace musher::race::testing
