#include "musher/cyberdog/fs_machine_link.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/code.hpp"

namespace musher {
namespace {

// CyberDog's own figures: a heartbeat every 500 ms, lost after 5 missing ones.
constexpr Duration kSilence = 5 * Milliseconds(500);
// The reply of a module to a state it does not have: the key alone, without its module's code.
constexpr auto kNoSuchState = static_cast<std::int32_t>(KeyCode::kUnSupport);
// Matches writers of either reliability. All modules share one history, so it must not be short.
constexpr transport::Qos kHeartbeatsQos{transport::Qos::Reliability::kBestEffort,
                                        transport::Qos::Durability::kVolatile, 0};

}  // namespace

Result<std::unique_ptr<ActuatorLink>> FsMachineLink::Make(transport::Node& node,
                                                          const MachineConfig& config,
                                                          ActuatorIndex actuator, Emit emit) {
  const ActuatorConfig& own = config.actuators[actuator];
  std::unique_ptr<FsMachineLink> link(new FsMachineLink(node, config, actuator, std::move(emit)));
  FsMachineLink* self = link.get();
  auto client = transport::MakeClient<msg::FsMachine>(
      node, transport::ResolveName(config.name_space, own.name + "machine_service"), [self] {
        if (self->client_) self->OnServers(self->client_->Servers());
      });
  if (!client) return client.error();
  link->client_ = std::move(client).value();
  auto subscription = transport::MakeSubscription<msg::Heartbeats>(
      node, transport::ResolveName(config.name_space, "manager_heartbeats"),
      [self, name = own.heartbeat_name](const msg::Heartbeats& heartbeat,
                                        const transport::SampleInfo&) {
        if (heartbeat.name == name) self->OnHeartbeat();
      },
      kHeartbeatsQos);
  if (!subscription) return subscription.error();
  link->heartbeats_ = std::move(subscription).value();
  return std::unique_ptr<ActuatorLink>(std::move(link));
}

void FsMachineLink::OnAppeared() {
  report().state = State(kSetUp);
  ReportStatus();
}

void FsMachineLink::OnLost() {
  ++call_;
  silent_ = false;
  watch_ = nullptr;
}

void FsMachineLink::Drive() {
  client_->Call({pending()->target}, kCallTimeout,
                [this, call = ++call_](const Result<msg::FsMachine::Response>& reply) {
                  if (call == call_) OnReply(reply);
                });
}

void FsMachineLink::Inquire(const QueryCommand& query) {
  AnswerQuery(query.number);
}

void FsMachineLink::OnReply(const Result<msg::FsMachine::Response>& reply) {
  const bool was_lost = silent_;
  NoteContact();
  if (!reply) {
    End(Verdict::kFailed, reply.error().code, reply.error().message);
  } else if (reply.value().code == kCodeOk) {
    End(Verdict::kDone);
  } else if (reply.value().code == kNoSuchState) {
    End(Verdict::kRefused, kNoSuchState, "it has no such state");
  } else {
    End(Verdict::kFailed, reply.value().code);
  }
  if (was_lost) ReportStatus();
}

void FsMachineLink::OnHeartbeat() {
  if (!available()) return;
  const bool was_lost = silent_;
  NoteContact();
  if (!watch_) Watch(last_contact_ + kSilence);
  if (was_lost) ReportStatus();
}

void FsMachineLink::NoteContact() {
  last_contact_ = Now();
  if (std::exchange(silent_, false)) Watch(last_contact_ + kSilence);
}

void FsMachineLink::Watch(Time until) {
  watch_ = node().loop().At(until, [this] { OnSilence(); });
}

// By the clock, not by counting: a heartbeat only stores the time, and the watch checks it once.
void FsMachineLink::OnSilence() {
  Time until = last_contact_ + kSilence;
  if (pending()) until = std::max(until, pending()->deadline);
  if (Now() < until) return Watch(until);
  watch_ = nullptr;
  silent_ = true;
  ReportVanished("its heartbeats have stopped");
}

}  // namespace musher
