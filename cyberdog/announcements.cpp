#include "musher/cyberdog/announcements.hpp"

#include <utility>

#include "musher/cyberdog/interfaces.hpp"
#include "musher/cyberdog/numbers.hpp"
#include "musher/cyberdog/self_check.hpp"

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
      publish_state_(endpoints.PublishFunction<msg::StateSwitchStatus>(kStateSwitchStatus)),
      publish_self_check_(endpoints.PublishFunction<msg::SelfCheckStatus>(kSelfCheckStatus)),
      publish_ready_(endpoints.PublishFunction<msg::Bool>(kReadyNotify)) {
  self_check_timer_ = loop_.Every(kSelfCheckPeriod, [this] {
    if (Leads()) publish_self_check_(SelfCheckOf(config_, machine_));
  });
}

bool Announcements::Leads() const {
  return machine_.phase != Phase::kIdle && machine_.phase != Phase::kFenced;
}

void Announcements::OnRecord(const action::Record& record) {
  if (!Leads()) return;
  FollowSwitch(record);
  if (machine_.phase == Phase::kRunning && !ready_timer_ && ready_times_ == 0) PublishReady();
}

// To be called when the machine has completed the step of the record.
void Announcements::FollowSwitch(const action::Record& record) {
  const auto& current = machine_.current;
  const bool is_end = pending_ && record.kind == "switch" &&
                      record.switch_number == pending_->number &&
                      (!current || current->number != pending_->number);
  if (is_end) PublishEnd(*std::exchange(pending_, std::nullopt), record.code);
  const bool counts = current && !current->only && current->direction != Direction::kCheck;
  if (counts && !pending_) {
    pending_ = {current->number, current->target, IsPublishedAtBegin(current->target)};
    if (pending_->published) {
      publish_state_({StatusNumberOf(current->target), kCodeOk});
      published_state_ = current->target;
    }
  } else if (!current && !pending_ && machine_.state != published_state_) {
    publish_state_({StatusNumberOf(machine_.state), kCodeOk});  // the switch ended at once
    published_state_ = machine_.state;
  }
}

void Announcements::PublishEnd(const PendingSwitch& ended, std::int32_t code) {
  published_state_ = machine_.state;
  if (machine_.state != ended.target) {
    publish_state_({msg::StateSwitchStatus::kError, code});
  } else if (!ended.published || code != kCodeOk) {
    publish_state_({StatusNumberOf(ended.target), code});
  }
}

void Announcements::PublishReady() {
  ready_timer_ = loop_.Every(kReadyPeriod, [this] {
    const bool over = machine_.phase != Phase::kRunning || ++ready_times_ > kReadyTimes;
    if (over) {
      ready_timer_ = nullptr;
    } else {
      publish_ready_({true});
    }
  });
}

}  // namespace musher::cyberdog
