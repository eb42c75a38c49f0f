#include "musher/test/modules/motion/harness.hpp"
#include "musher/test/support/paths.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace musher::motion::testing {

const MotionTable& TheTable() {
  static const MotionTable table = [] {
    TableReading reading = ReadTableFile(SourceDir() + "/config/motion/motions.toml");
    for (const Diagnostic& diagnostic : reading.diagnostics) {
      ADD_FAILURE() << FormatDiagnostic(diagnostic);
    }
    return reading.table.value_or(MotionTable());
  }();
  return table;
}

Harness::Harness() : next_report_(now) {
  gate_ = [this](const std::string& capability) -> Result<> {
    for (const std::string& key : {capability, std::string()}) {
      if (const auto found = refused.find(key); found != refused.end()) return found->second;
    }
    return Ok();
  };
  Body(kRecoveryStand);
  Do(motion_event::Opened{});
}

void Harness::Body(std::int32_t id) {
  const Motion& motion = *TheTable().Find(id);
  board.report.mode = motion.mode;
  board.report.gait = motion.gait;
  board.report.bar = 100;
  if (!board.silent) Do(motion_event::BoardReported{board.report});
}

void Harness::Do(const MotionEvent& event) {
  const MotionCore before = core;
  const MotionActions actions = Step(Rules(), core, event, now);
  if (watch) watch(before, event, actions);
  for (const MotionAction& action : actions) {
    if (const auto* send = std::get_if<motion_action::Send>(&action)) {
      sent.push_back({now, send->command});
      board.Take(send->command, now);
    } else if (const auto* answer = std::get_if<motion_action::Answer>(&action)) {
      EXPECT_TRUE(answers.emplace(answer->token, *answer).second) << "answered twice";
    } else if (const auto* response = std::get_if<motion_action::ServoResponse>(&action)) {
      responses.push_back(*response);
    } else if (const auto* error = std::get_if<motion_action::ReportError>(&action)) {
      reported.push_back(error->code);
    } else if (const auto* say = std::get_if<motion_action::Say>(&action)) {
      announced.push_back(say->text);
    } else {
      log.push_back(std::get<motion_action::Log>(action).text);
    }
  }
}

void Harness::RunFor(Duration duration) {
  const Time end = now + duration;
  while (true) {
    const auto deadline = NextDeadline(Rules(), core);
    const Time next = std::min(deadline.value_or(next_report_), next_report_);
    if (next > end) break;
    now = std::max(now, next);
    if (now >= next_report_) {
      next_report_ = now + Board::kReport;
      if (!board.silent) Do(motion_event::BoardReported{board.Report(now)});
    }
    if (deadline && now >= *deadline) Do(motion_event::TimePassed{});
  }
  now = end;
}

void Harness::StandStill(Duration duration) {
  now += duration;
  const auto deadline = NextDeadline(Rules(), core);
  if (deadline && now >= *deadline) Do(motion_event::TimePassed{});
}

std::int32_t Harness::CodeOf(RequestToken token) {
  for (int i = 0; i < 20'000 && answers.count(token) == 0; ++i) RunFor(Milliseconds(10));
  return answers.count(token) == 0 ? -1 : answers.at(token).code;
}

RequestToken Harness::RequestMotion(std::int32_t id, std::int32_t source,
                                    const MotionArguments& arguments) {
  return Play({{id, arguments}}, source);
}

RequestToken Harness::Play(std::vector<MotionRequest> requests, std::int32_t source) {
  Do(motion_event::PlayArrived{++token_, source, std::move(requests)});
  return token_;
}

RequestToken Harness::LieDown(std::int32_t id, int tries) {
  Do(motion_event::LieDown{++token_, id, tries});
  return token_;
}

void Harness::Servo(std::int32_t id, std::int32_t source, std::vector<float> vel,
                    std::int32_t type) {
  ServoCommand command;
  command.type = type;
  command.source = source;
  command.requested.id = id;
  command.requested.arguments.vel_des = std::move(vel);
  Do(motion_event::ServoArrived{command});
}

void Harness::Stream(std::int32_t id, Duration duration, std::int32_t source) {
  for (const Time end = now + duration; now < end; RunFor(Milliseconds(50))) Servo(id, source);
}

std::vector<std::int32_t> Harness::Commanded() const {
  std::vector<std::int32_t> ids;
  for (const Sent& frame : sent) {
    if (ids.empty() || ids.back() != frame.command.id) ids.push_back(frame.command.id);
  }
  return ids;
}

std::int32_t Harness::ServoCode() const {
  return responses.empty() ? -1 : responses.back().code;
}

}  // namespace musher::motion::testing
