#include "musher/controller/client/switch_client.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

// A reply, or the last status, may still arrive after the exit of the controller is noticed.
constexpr Duration kGrace = Milliseconds(200);
// A successor replies once it has discovered the actuators.
constexpr Duration kReplyTimeout = std::chrono::seconds(10);
constexpr const char* kStopped = "stopped";  // a phase of MachineStatus
constexpr Duration kQueryPeriod = Milliseconds(200);

std::string Seconds(Duration duration) {
  return std::to_string(ToMilliseconds(duration) / 1000) + " s";
}

}  // namespace

SwitchClient::SwitchClient(transport::Node& node, Options options, std::string target,
                           std::string actuator, OnNews on_news, OnEnd on_end)
    : node_(node),
      options_(std::move(options)),
      target_(std::move(target)),
      actuator_(std::move(actuator)),
      on_news_(std::move(on_news)),
      on_end_(std::move(on_end)),
      send_by_(node.loop(), std::min(options_.find + kServiceWithin, options_.timeout)) {}

Result<std::unique_ptr<SwitchClient>> SwitchClient::Make(transport::Node& node, Options options,
                                                         std::string target, std::string actuator,
                                                         OnNews on_news, OnEnd on_end) {
  std::unique_ptr<SwitchClient> client(new SwitchClient(node, std::move(options), std::move(target),
                                                        std::move(actuator), std::move(on_news),
                                                        std::move(on_end)));
  if (auto opened = client->Open(); !opened) return opened.error();
  return client;
}

Result<> SwitchClient::Open() {
  const std::string& name_space = options_.leader.name_space;
  auto set_state = transport::MakeClient<msg::SetState>(
      node_, transport::MachineService(name_space, "set_state"), [this] { Send(); });
  if (!set_state) return set_state.error();
  set_state_ = std::move(set_state).value();
  auto get_switch = transport::MakeClient<msg::GetSwitch>(
      node_, transport::MachineService(name_space, "get_switch"), [this] { Send(); });
  if (!get_switch) return get_switch.error();
  get_switch_ = std::move(get_switch).value();
  LeaderWatch::Options options = options_.leader;
  options.one_machine = true;
  auto watch = LeaderWatch::Make(
      node_, options, [this](const msg::MachineStatus& status) { OnStatus(status); },
      [this](const msg::MachineStatus& leader, const std::string& how) {
        OnLeaderEnd(leader, how);
      });
  if (!watch) return watch.error();
  watch_ = std::move(watch).value();
  transport::EventLoop& loop = node_.loop();
  timeout_ = loop.At(loop.Now() + options_.timeout,
                     [this] { EndUnknown("no answer within " + Seconds(options_.timeout)); });
  if (options_.exited) {
    const msg::MachineStatus& exited = *options_.exited;
    step_ = Step::kCalled;
    epoch_ = Epoch(exited.epoch);
    pid_ = exited.pid;
    number_ = CommandNumber(exited.target == target_ ? exited.switch_number : 0);
    called_ = transport::ParticipantId(exited.participant);
    if (exited.phase == kStopped) stopped_ = exited;
    how_ = "has exited";
    wait_ = loop.At(loop.Now() + (stopped_ ? Duration{} : kGrace), [this] { Orphan(); });
    return Ok();
  }
  wait_ = loop.At(loop.Now() + options_.find,
                  [this] { EndUnknown("no controller found within " + Seconds(options_.find)); });
  return Ok();
}

void SwitchClient::OnStatus(const msg::MachineStatus& status) {
  switch (step_) {
    case Step::kFinding:
      before_ = CommandNumber(status.switch_number);
      return Call(status);
    case Step::kCalled:
      TakeStopped(status);
      if (wait_) return;  // it is known to have ended
      epoch_ = Epoch(status.epoch);
      if (status.target == target_) number_ = CommandNumber(status.switch_number);
      return;
    case Step::kOrphaned:
      return Continue(status);
    case Step::kQuerying:
    case Step::kEnded:
      return;
  }
}

// Keeps the last status of the called controller, which exits with its machine. The watch knows no
// participant of a controller that no longer leads, but its status names it.
void SwitchClient::TakeStopped(const msg::MachineStatus& status) {
  const transport::ParticipantId from = status.participant != 0
                                            ? transport::ParticipantId(status.participant)
                                            : watch_->participant();
  if (status.phase == kStopped && from == called_) stopped_ = status;
}

void SwitchClient::Call(const msg::MachineStatus& leader) {
  step_ = Step::kCalled;
  epoch_ = Epoch(leader.epoch);
  pid_ = leader.pid;
  called_ = watch_->participant();
  number_ = CommandNumber(leader.target == target_ ? leader.switch_number : 0);
  wait_ = nullptr;
  sent_ = false;
  Send();
}

// Calls the service of the leading controller as soon as it is matched. The service of a crashed
// controller may still be matched, and a successor must not get a request meant for it.
void SwitchClient::Send() {
  if (sent_ || !watch_) return;
  const auto reaches = [this](const auto& client) {
    const std::vector<transport::ParticipantId> servers = client.Servers();
    return std::find(servers.begin(), servers.end(), watch_->participant()) != servers.end();
  };
  if (step_ == Step::kCalled && reaches(*set_state_)) {
    if (target_ != kTearDown && target_ != kError && send_by_.IsOver()) {
      return EndUnknown("no controller found in time; nothing was requested");
    }
    sent_ = true;
    const MachineIdentity& machine = watch_->machine();
    set_state_->Call(
        {target_, actuator_, options_.by, machine.name, machine.id}, options_.timeout,
        [this](const auto& reply) {
          if (reply) return End({SwitchEnd::Kind::kAnswered, reply.value()});
          if (step_ == Step::kCalled) EndUnknown(reply.error().message);
        },
        watch_->participant());
  } else if (step_ == Step::kQuerying && reaches(*get_switch_)) {
    sent_ = true;
    const MachineIdentity& machine = watch_->machine();
    get_switch_->Call(
        {epoch_.value(), number_.value(), machine.name, machine.id}, kReplyTimeout,
        [this](const auto& reply) {
          if (reply && step_ == Step::kQuerying) OnReply(reply.value());
        },
        watch_->participant());
  }
}

// "the controller (pid 7, epoch 3) has exited during switch 5 to Active"
std::string SwitchClient::Lost() const {
  const std::string during = number_ == 0
                                 ? "before it reported the number of the switch to " + target_
                                 : "during switch " + ToString(number_) + " to " + target_;
  return "the controller (pid " + std::to_string(pid_) + ", epoch " + ToString(epoch_) + ") " +
         how_ + " " + during;
}

void SwitchClient::OnLeaderEnd(const msg::MachineStatus& leader, const std::string& how) {
  transport::EventLoop& loop = node_.loop();
  if (step_ == Step::kCalled) TakeStopped(leader);
  if (step_ == Step::kCalled && !wait_) {
    how_ = how;
    wait_ = loop.At(loop.Now() + kGrace, [this] { Orphan(); });
  } else if (step_ == Step::kQuerying) {
    Orphan();  // the successor has exited as well
  }
}

void SwitchClient::Orphan() {
  if (EndedWithItsMachine()) return End(EndByStatus());
  transport::EventLoop& loop = node_.loop();
  step_ = Step::kOrphaned;
  on_news_(Lost() + "; waiting " + Seconds(options_.successor) + " for a successor");
  wait_ = loop.At(loop.Now() + options_.successor, [this] {
    EndUnknown("no successor within " + Seconds(options_.successor) +
               "; `musher up` with the same config takes control of what still runs, and `musher "
               "status` then shows the machine's state");
  });
  if (watch_->leader()) Continue(*watch_->leader());
}

// A controller exits with its machine. If its reply is lost, its latched status has the outcome.
bool SwitchClient::EndedWithItsMachine() const {
  return target_ == kTearDown && actuator_.empty() && stopped_;
}

SwitchEnd SwitchClient::EndByStatus() const {
  SwitchEnd end;
  end.kind = SwitchEnd::Kind::kReported;
  end.result.switch_number = stopped_->switch_number;
  end.result.target = target_;
  end.result.state = stopped_->state;
  end.result.degraded = stopped_->degraded;
  end.result.outcome = stopped_->degraded.empty() ? "done" : "done-degraded";
  for (const msg::ActuatorInfo& actuator : stopped_->actuators) {
    if (!actuator.degraded || !end.result.reason.empty()) continue;
    end.result.code = actuator.code;
    end.result.reason = actuator.name + ": " + actuator.message;
  }
  return end;
}

void SwitchClient::Continue(const msg::MachineStatus& successor) {
  // A successor without the disk of the first begins with the same epoch, and raises it as soon as
  // it receives the higher one.
  if (Epoch(successor.epoch) <= epoch_ && successor.pid != pid_) return;
  if (target_ == kTearDown && actuator_.empty()) return Call(successor);
  Query();
}

void SwitchClient::Query() {
  transport::EventLoop& loop = node_.loop();
  step_ = Step::kQuerying;
  wait_ = loop.At(loop.Now() + kReplyTimeout, [this] {
    EndUnknown("its successor did not report the outcome within " + Seconds(kReplyTimeout) +
               "; `musher status` shows the machine's state");
  });
  sent_ = false;
  Send();
}

void SwitchClient::OnReply(const msg::GetSwitch::Response& reply) {
  transport::EventLoop& loop = node_.loop();
  if (reply.outcome == msg::GetSwitch::kUnderWay) {
    wait_ = loop.At(loop.Now() + kQueryPeriod, [this] { Query(); });
    return;
  }
  const bool ours = reply.found && reply.target == target_ && reply.actuator == actuator_ &&
                    (number_ != 0 || CommandNumber(reply.switch_number) > before_);
  if (!ours && (number_ != 0 || !reply.found)) return EndUnknown(reply.reason);
  SwitchEnd end;
  end.kind = SwitchEnd::Kind::kReported;
  end.result.target = target_;
  end.result.actuator = actuator_;
  end.result.state = reply.state;
  if (ours) {
    end.result.switch_number = reply.switch_number;
    end.result.outcome = reply.outcome;
    end.result.code = reply.code;
    end.result.reason = reply.reason;
  } else {
    end.result.outcome = msg::GetSwitch::kInterrupted;
    end.result.code = kCodeNetError;
    end.result.reason = Lost() + "; the switch had not begun, request it again";
  }
  End(end);
}

void SwitchClient::EndUnknown(const std::string& why) {
  SwitchEnd end;
  end.result.switch_number = number_.value();
  end.result.target = target_;
  end.result.actuator = actuator_;
  end.result.code = how_.empty() ? kCodeTimeout : kCodeNetError;
  end.result.reason = how_.empty() ? why : Lost() + "; " + why;
  End(end);
}

void SwitchClient::End(const SwitchEnd& end) {
  if (step_ == Step::kEnded) return;
  step_ = Step::kEnded;
  timeout_ = nullptr;
  wait_ = nullptr;
  on_end_(end);
}

}  // namespace musher
