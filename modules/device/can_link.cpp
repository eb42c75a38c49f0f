#include "musher/modules/device/can_link.hpp"

#include <utility>

#include "musher/base/check.hpp"

namespace musher::device {

CanLink::CanLink(transport::EventLoop& loop, const CanBus::Open& open, CanProtocol protocol,
                 Duration silence, Events events)
    : loop_(loop),
      open_(open),
      protocol_(std::move(protocol)),
      silence_time_(silence),
      events_(std::move(events)),
      record_(protocol_.fields) {
  Reopen();
}

void CanLink::Reopen() {
  bus_.reset();
  CanBus::Events events;
  events.on_frame = [this](const CanFrame& frame) { OnFrame(frame); };
  events.on_fault = [this](const std::string& why) {
    recover_.reset();
    if (!std::exchange(bus_fault_, true)) Fail(why);
  };
  events.on_recovered = [this] { OnRecovered(); };
  events.on_lost = [this](const std::string& why) { Lose(why); };
  auto opened = open_(loop_, protocol_.network_interface, std::move(events));
  if (!opened) return Lose(opened.error().message);
  bus_ = std::move(opened).value();
  ArmSilence();
  recover_ = loop_.At(loop_.Now(), [this] { Recover(); });
}

// A bus that goes off and on again many times a second stays at fault.
void CanLink::OnRecovered() {
  if (!recover_) recover_ = loop_.At(loop_.Now() + kSteady, [this] { Recover(); });
}

// Of a device that sends by itself a record shows that it works.
void CanLink::Recover() {
  recover_.reset();
  bus_fault_ = false;
  if (silence_time_ == Duration()) Work();
}

Result<> CanLink::Send(std::string_view command, std::span<const std::uint8_t> data) {
  const CanCommand* const found = protocol_.FindCommand(command);
  if (found == nullptr) {
    return Error{static_cast<std::int32_t>(KeyCode::kUnSupport),
                 "its file of frames has no command '" + std::string(command) + "'"};
  }
  if (!works_) {
    return Error{static_cast<std::int32_t>(KeyCode::kNetError),
                 fault_.empty() ? "no frame received yet" : fault_};
  }
  return bus_->Send(Encode(*found, data));
}

void CanLink::OnFrame(const CanFrame& frame) {
  if (bus_fault_) return OnRecovered();
  if (!record_.Knows(frame.id)) {
    if (!other_) other_ = frame.id;
    return;
  }
  const auto complete = record_.Take(frame);
  if (!complete) {
    const Time now = loop_.Now();
    if (refused_at_ && now - *refused_at_ < kRefusedPause) return;
    refused_at_ = now;
    return events_.on_refused(complete.error());
  }
  if (complete.value()) OnRecord();
}

void CanLink::OnRecord() {
  if (!std::exchange(filtered_, true)) {
    bus_->Filter({record_.ids().begin(), record_.ids().end()});
  }
  other_.reset();
  ArmSilence();
  Work();
  events_.on_record(record_.values());
}

void CanLink::Work() {
  fault_.clear();
  if (!std::exchange(works_, true)) events_.on_working();
}

void CanLink::Fail(const std::string& why) {
  works_ = false;
  record_.Forget();
  if (bus_ && std::exchange(filtered_, false)) bus_->Filter({});  // any frame shows that it works
  if (std::exchange(fault_, why) != why) events_.on_fault(why);
}

void CanLink::Lose(const std::string& why) {
  silence_.reset();
  recover_.reset();
  other_.reset();
  reopen_ = loop_.At(loop_.Now() + kReopen, [this] { Reopen(); });
  bus_fault_ = true;
  Fail(why);
}

void CanLink::ArmSilence() {
  if (silence_time_ == Duration()) return;
  const Time due = loop_.Now() + silence_time_;
  silence_ = loop_.At(due, [this, due] { OnSilence(due); });
}

// A process that was suspended runs its timers first: frames may be queued.
void CanLink::OnSilence(Time due) {
  const Time now = loop_.Now();
  if (now > due + kLate) {
    const Time again = now + kLate;
    silence_ = loop_.At(again, [this, again] { OnSilence(again); });
    return;
  }
  if (!bus_fault_) Fail(Silence());  // what is wrong with the bus says more
  ArmSilence();
}

std::string CanLink::Silence() const {
  std::string text = protocol_.network_interface + ": ";
  const char* between = "no frame ";
  for (const CanId& id : record_.Missing()) {
    text += between + ToText(id);
    between = " or ";
  }
  text += " for " + std::to_string(ToMilliseconds(silence_time_)) + " ms";
  if (other_) text += "; frames of other devices come, such as " + ToText(*other_);
  return text;
}

}  // namespace musher::device
