#include "musher/modules/meilin/servers/tool.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "musher/modules/meilin/servers/goal_limit.hpp"

namespace musher::meilin::servers {

const ToolKind& ArmKind() {
  static const ToolKind kind{"Arm",
                             {{"IDLE", 0, 0},
                              {"GRASP", 3, 2},
                              {"STORE_TO_BODY", 2, 3},
                              {"STORE_ON_ARM", 1.5, 3},
                              {"GET_BODY", 2, 1},
                              {"PLACE_MID", 3, 4},
                              {"PLACE_HIGH", 3, 4}}};
  return kind;
}

const ToolKind& SpearKind() {
  static const ToolKind kind{"Spear",
                             {{"IDLE", 0, 0},
                              {"PREPARE", 2, 1},
                              {"GRASP", 3, 2},
                              {"DOCK_EXTEND", 2, 5},
                              {"DOCK_RELEASE", 2, 6}}};
  return kind;
}

void Tool::OnReport(double done) {
  done_ = done == 1;
  if (!done_) stop_armed_ = true;
  if (done_ && stop_armed_) stop_done_ = true;
  if (!running_ || !sent_) return;
  if (!done_) armed_ = true;
  if (done_ && armed_) fresh_done_ = true;
}

void Tool::Forget() {
  done_ = false;
  stopped_at_.reset();
  well_ = well_ || !has_begun_;
}

void Tool::AwaitIdle(Time now) {
  stopped_at_ = now;
  stop_armed_ = !done_;
  stop_done_ = false;
}

bool Tool::Settles(Time now) const {
  return stopped_at_ && now >= *stopped_at_ && now - *stopped_at_ < kSettle && !stop_done_;
}

bool Tool::IsIdleAndWell(Time now) const {
  if (running_) return false;
  return well_ || (!has_begun_ && stopped_at_ && !Settles(now));
}

void Tool::Begin(std::uint8_t command, double limit_s, Time now) {
  command_ = command;
  running_ = has_begun_ = true;
  sent_ = false;
  well_ = false;
  fresh_done_ = false;
  state_ = kind_.commands.at(command).state;
  begun_ = now;
  limit_ = LimitOf(limit_s, time_limit_);
}

bool Tool::TakeDue(Time now) {
  if (!running_ || sent_) return false;
  if (Settles(now) && command_ != 0) return false;
  sent_ = true;
  sent_at_ = now;
  armed_ = !done_;
  return true;
}

void Tool::Stop(Time now) {
  if (!running_) return;
  running_ = false;
  AwaitIdle(now);
  state_ = kToolError;
}

std::optional<Tool::End> Tool::Update(Time now) {
  if (!running_) return std::nullopt;
  if ((command_ == 0 && sent_) || fresh_done_) {
    running_ = false;
    well_ = true;
    state_ = kToolDone;
    return End{true, fmt::format("{} command {} done", kind_.name, command_)};
  }
  if (!sent_ || now - sent_at_ < limit_) return std::nullopt;
  Stop(now);
  return End{false, "Timeout"};
}

double Tool::ElapsedSeconds(Time now) const {
  return std::max(0.0, ToSeconds(now - begun_));
}

double Tool::Progress(Time now) const {
  if (state_ == kToolDone) return 1;
  const double expected_s = kind_.commands.at(command_).expected_s;
  constexpr double kAlmost = 0.99;  // it is not done before the hardware says so
  return expected_s > 0 ? std::min(ElapsedSeconds(now) / expected_s, kAlmost) : 0;
}

}  // namespace musher::meilin::servers
