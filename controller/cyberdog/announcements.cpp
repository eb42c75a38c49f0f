#include "musher/controller/cyberdog/announcements.hpp"

#include <utility>

#include "musher/controller/cyberdog/numbers.hpp"
#include "musher/controller/cyberdog/self_check.hpp"

namespace musher::cyberdog {
namespace {

constexpr Duration kSelfCheckPeriod = std::chrono::seconds(1);
constexpr Duration kReadyPeriod = Milliseconds(100);
constexpr int kReadyTimes = 3000;

}  // namespace

Announcements::Announcements(transport::Endpoints& endpoints, const MachineConfig& config,
                             const Machine& machine)
    : loop_(endpoints.node().loop()),
      config_(config),
      machine_(machine),
      tell_state_(endpoints.Tell<msg::StateSwitchStatus>("state_switch_status")),
      tell_self_check_(endpoints.Tell<msg::SelfCheckStatus>("self_check_status")),
      tell_ready_(endpoints.Tell<msg::Bool>("ready_notify")) {
  self_check_timer_ = loop_.Every(kSelfCheckPeriod, [this] {
    if (Leads()) tell_self_check_(SelfCheckOf(config_, machine_));
  });
}

bool Announcements::Leads() const {
  return machine_.phase != Phase::kIdle && machine_.phase != Phase::kFenced;
}

void Announcements::OnRecord(const action::Record& record) {
  if (!Leads()) return;
  FollowSwitch(record);
  if (machine_.phase == Phase::kRunning && !ready_timer_ && ready_times_ == 0) TellReady();
}

// The machine has taken the whole step that the record is of.
void Announcements::FollowSwitch(const action::Record& record) {
  const auto& current = machine_.current;
  const bool tells_end = pending_ && record.kind == "switch" &&
                         record.switch_number == pending_->number &&
                         (!current || current->number != pending_->number);
  if (tells_end) TellEnd(*std::exchange(pending_, std::nullopt), record.code);
  const bool counts = current && !current->only && current->direction != Direction::kCheck;
  if (counts && !pending_) {
    pending_ = {current->number, current->target, IsToldAtBegin(current->target)};
    if (pending_->told) {
      tell_state_({StatusNumberOf(current->target), kCodeOk});
      told_state_ = current->target;
    }
  } else if (!current && !pending_ && machine_.state != told_state_) {
    tell_state_({StatusNumberOf(machine_.state), kCodeOk});  // it was there at once
    told_state_ = machine_.state;
  }
}

void Announcements::TellEnd(const Pending& ended, std::int32_t code) {
  told_state_ = machine_.state;
  if (machine_.state != ended.target) {
    tell_state_({msg::StateSwitchStatus::kError, code});
  } else if (!ended.told || code != kCodeOk) {
    tell_state_({StatusNumberOf(ended.target), code});
  }
}

void Announcements::TellReady() {
  ready_timer_ = loop_.Every(kReadyPeriod, [this] {
    const bool over = machine_.phase != Phase::kRunning || ++ready_times_ > kReadyTimes;
    if (over) {
      ready_timer_ = nullptr;
    } else {
      tell_ready_({true});
    }
  });
}

}  // namespace musher::cyberdog
