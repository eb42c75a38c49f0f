#include "musher/test/fault_injection/robot/observer.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

#include "musher/lifecycle/config/config.hpp"
#include "musher/test/fault_injection/robot/members.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::fault_injection {
namespace {

constexpr Duration kSlice = Milliseconds(50);  // of a wait, between checks for an interrupt
constexpr Duration kDiscoveryTimeout = Milliseconds(5000);  // once the leader is known
constexpr Duration kReplyTimeout = std::chrono::seconds(30);
constexpr Duration kStatusReplyTimeout = std::chrono::seconds(5);

std::atomic<bool> interrupted = false;

Time Now() {
  return std::chrono::steady_clock::now();
}

template <class T>
T Must(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(result).value();
}

}  // namespace

void Interrupt() {
  interrupted = true;
}

void ThrowIfInterrupted() {
  if (interrupted) throw Interrupted{};
}

Observer::Observer(int domain, TransportProfile profile, const std::string& name_space,
                   bool beside_another)
    : beside_another_(beside_another) {
  transport::DdsOptions options;
  options.domain_id = domain;
  options.profile = profile;
  options.discovery = transport::DiscoveryTiming::kAtOnce;
  node_ = Must(transport::NodeThread::Start(options));
  node_->RunOnLoop([&] { Make(name_space); });
}

Observer::~Observer() {
  node_->RunOnLoop([this] {
    subscriptions_.clear();
    emergency_stop_.reset();
    set_state_.reset();
    restart_.reset();
    get_status_.reset();
    release_.reset();
  });
}

void Observer::Make(const std::string& name_space) {
  transport::Node& node = node_->node();
  const auto service = [&](const char* name) {
    return transport::MachineService(name_space, name);
  };
  set_state_ = Must(transport::MakeClient<msg::SetState>(node, service("set_state")));
  restart_ = Must(transport::MakeClient<msg::RestartActuator>(node, service("restart_actuator")));
  get_status_ = Must(transport::MakeClient<msg::GetStatus>(node, service("get_status")));
  release_ = Must(
      transport::MakeClient<msg::ReleaseEmergencyStop>(node, service("release_emergency_stop")));
  emergency_stop_topic_ = transport::EmergencyStopTopic(name_space);
  subscriptions_.push_back(Must(transport::MakeSubscription<msg::MachineStatus>(
      node, transport::MachineStatusTopic(name_space),
      [this](const msg::MachineStatus& status, const transport::SampleInfo& info) {
        if (status.machine != kMachine) return;
        leader_ = info.participant;
        OnMachine(status);
      },
      transport::kLatchedFromManyQos)));
  subscriptions_.push_back(Must(transport::MakeSubscription<msg::ActuatorStatus>(
      node, transport::ActuatorStatusTopic(name_space),
      [this](const msg::ActuatorStatus& status, const transport::SampleInfo&) {
        if (status.machine == kMachine) OnActuator(status);
      },
      transport::kLatchedFromManyQos)));
}

void Observer::OnMachine(std::optional<msg::MachineStatus> status) {
  const std::lock_guard lock(mutex_);
  machine_.push_back({Now(), std::move(status)});
  changed_.notify_all();
}

void Observer::OnActuator(const msg::ActuatorStatus& status) {
  {
    const std::lock_guard lock(mutex_);
    actuators_.push_back(status);
    latest_of_actuators_[status.name] = status;
    changed_.notify_all();
  }
  for (auto trigger = triggers_.begin(); trigger != triggers_.end();) {
    if (!trigger->when(status)) {
      ++trigger;
      continue;
    }
    trigger->act();
    trigger->done.set_value();
    trigger = triggers_.erase(trigger);
  }
}

std::optional<Time> Observer::AwaitUntil(Time deadline,
                                         const std::function<std::optional<Time>()>& found) {
  std::unique_lock lock(mutex_);
  while (true) {
    if (const auto at = found()) return at;
    const Time now = Now();
    if (now >= deadline) return std::nullopt;
    changed_.wait_until(lock, std::min(deadline, now + kSlice));
    ThrowIfInterrupted();
  }
}

std::optional<Time> Observer::AwaitSince(Time since, const Is& is, Duration timeout) {
  std::size_t checked = 0;
  return AwaitUntil(Now() + timeout, [&]() -> std::optional<Time> {
    for (; checked < machine_.size(); ++checked) {
      const Seen& seen = machine_[checked];
      if (seen.at >= since && seen.status && is(*seen.status)) return seen.at;
    }
    return std::nullopt;
  });
}

// The last status, or that of a controller of another host with a higher epoch: the one that
// releases control may have published last.
const Observer::Seen* Observer::OfTheLeader() const {
  if (machine_.empty() || !machine_.back().status) return nullptr;
  const msg::MachineStatus& last = *machine_.back().status;
  for (auto seen = machine_.rbegin(); seen != machine_.rend(); ++seen) {
    if (!seen->status) break;
    if (seen->status->host != last.host && seen->status->epoch > last.epoch) return &*seen;
  }
  return &machine_.back();
}

std::optional<Time> Observer::Await(const Is& is, Duration timeout) {
  return AwaitUntil(Now() + timeout, [&]() -> std::optional<Time> {
    const Seen* leader = OfTheLeader();
    if (leader == nullptr || !is(*leader->status)) return std::nullopt;
    return leader->at;
  });
}

std::optional<msg::MachineStatus> Observer::Latest() {
  const std::lock_guard lock(mutex_);
  return machine_.empty() ? std::nullopt : machine_.back().status;
}

std::vector<msg::MachineStatus> Observer::Since(Time since) {
  const std::lock_guard lock(mutex_);
  std::vector<msg::MachineStatus> statuses;
  for (const Seen& seen : machine_) {
    if (seen.at >= since && seen.status) statuses.push_back(*seen.status);
  }
  return statuses;
}

bool Observer::AwaitAllIn(const std::string& state, Duration timeout) {
  // Also those from which this observer has received nothing yet, on a busy machine.
  const auto is_in = [&](const msg::ActuatorInfo& info) {
    const auto report = latest_of_actuators_.find(info.name);
    if (info.protocol != ProtocolName(Protocol::kMusher)) return true;
    return report != latest_of_actuators_.end() && report->second.state == state;
  };
  const auto all_in = [&]() -> std::optional<Time> {
    if (machine_.empty() || !machine_.back().status) return std::nullopt;
    const auto& actuators = machine_.back().status->actuators;
    const bool all = std::all_of(actuators.begin(), actuators.end(), is_in);
    return all ? std::optional(Now()) : std::nullopt;
  };
  return AwaitUntil(Now() + timeout, all_in).has_value();
}

void Observer::Forget() {
  const std::lock_guard lock(mutex_);
  if (machine_.size() > 1) machine_.erase(machine_.begin(), machine_.end() - 1);
  actuators_.clear();
}

std::vector<msg::ActuatorStatus> Observer::Reports() {
  const std::lock_guard lock(mutex_);
  return actuators_;
}

std::map<std::string, msg::ActuatorStatus> Observer::LatestOfActuators() {
  const std::lock_guard lock(mutex_);
  return latest_of_actuators_;
}

std::shared_future<void> Observer::Once(When when, std::function<void()> act) {
  std::shared_future<void> done;
  node_->RunOnLoop([&] {
    Trigger& trigger = triggers_.emplace_back();
    trigger.when = std::move(when);
    trigger.act = std::move(act);
    done = trigger.done.get_future().share();
  });
  return done;
}

void Observer::ForgetTriggers() {
  node_->RunOnLoop([this] { triggers_.clear(); });
}

template <msg::Service S>
std::shared_future<Result<typename S::Response>> Observer::Call(
    std::unique_ptr<transport::Client<S>>& client, const typename S::Request& request) {
  const auto leads_to_leader = [&] {
    bool found = false;
    node_->RunOnLoop([&] {
      const std::vector<transport::ParticipantId> servers = client->Servers();
      found = std::find(servers.begin(), servers.end(), leader_) != servers.end();
    });
    return found;
  };
  const Time deadline = Now() + kDiscoveryTimeout;
  while (!leads_to_leader() && Now() < deadline) {
    AwaitUntil(Now() + Milliseconds(2), [] { return std::nullopt; });
  }
  auto promise = std::make_shared<std::promise<Result<typename S::Response>>>();
  std::shared_future<Result<typename S::Response>> future = promise->get_future().share();
  node_->RunOnLoop([&] {
    client->Call(
        request, std::is_same_v<S, msg::GetStatus> ? kStatusReplyTimeout : kReplyTimeout,
        [promise](auto reply) { promise->set_value(std::move(reply)); },
        beside_another_ ? leader_ : transport::ParticipantId());
  });
  return future;
}

std::shared_future<Result<msg::SetState::Response>> Observer::SetState(
    const std::string& target, const std::string& actuator) {
  return Call<msg::SetState>(set_state_, {target, actuator});
}

Result<msg::RestartActuator::Response> Observer::Restart(const std::string& actuator) {
  return AwaitFuture(Call<msg::RestartActuator>(restart_, {actuator}));
}

Result<msg::MachineStatus> Observer::GetStatus() {
  auto reply = AwaitFuture(Call<msg::GetStatus>(get_status_, {}));
  if (!reply) return reply.error();
  return reply.value().status;
}

void Observer::EngageEmergencyStop(StopId id) {
  node_->RunOnLoop([&] {
    emergency_stop_ = Must(transport::MakePublisher<msg::EmergencyStop>(
        node_->node(), emergency_stop_topic_, transport::kLatchedQos));
    const auto sent =
        emergency_stop_->Publish({id.value(), true, "fault_injection", "an injected stop"});
    if (!sent) throw std::runtime_error(sent.error().message);
  });
}

Result<msg::ReleaseEmergencyStop::Response> Observer::ReleaseEmergencyStop() {
  node_->RunOnLoop([this] { emergency_stop_.reset(); });
  return AwaitFuture(Call<msg::ReleaseEmergencyStop>(release_, {"fault_injection"}));
}

}  // namespace musher::fault_injection
