#include "musher/wire/managed_node_endpoints.hpp"

#include <chrono>
#include <utility>

#include "musher/base/code.hpp"
#include "musher/messages/stamp.hpp"

namespace musher::transport {
namespace {

msg::State ToMessage(Ros2State state) {
  return {static_cast<std::uint8_t>(state), std::string(Ros2StateLabel(state))};
}

msg::TransitionDescription ToMessage(const Ros2Edge& edge) {
  return {{edge.id, std::string(edge.label)}, ToMessage(edge.start), ToMessage(edge.goal)};
}

// The transition from one state to the next one; empty if ROS 2 has none.
msg::Transition TransitionOf(Ros2State from, Ros2State to) {
  for (const Ros2Edge& edge : Ros2Graph()) {
    if (edge.start == from && edge.goal == to) return {edge.id, std::string(edge.label)};
  }
  return {};
}

std::string Failure(const std::string& transition, const std::string& why) {
  return "change_state " + transition + " failed: " + why;
}

// Limits a number that any participant may publish.
Duration Limited(float seconds) {
  constexpr float kLongest = 3600;
  if (!(seconds > 0)) return {};
  return Milliseconds(static_cast<std::int64_t>(std::min(seconds, kLongest) * 1000));
}

}  // namespace

ManagedNodeEndpoints::ManagedNodeEndpoints(Node& node, std::string name_space, std::string name,
                                           std::string instance, Hooks hooks)
    : node_(node),
      name_space_(std::move(name_space)),
      name_(std::move(name)),
      instance_(std::move(instance)),
      hooks_(std::move(hooks)) {}

Result<std::unique_ptr<ManagedNodeEndpoints>> ManagedNodeEndpoints::Make(
    Node& node, const std::string& name_space, const std::string& name, const std::string& instance,
    Hooks hooks) {
  std::unique_ptr<ManagedNodeEndpoints> endpoints(
      new ManagedNodeEndpoints(node, name_space, name, instance, std::move(hooks)));
  if (auto opened = endpoints->Open(); !opened) return opened.error();
  endpoints->of_every_node_.emplace(node, ResolveName(name_space, name),
                                    std::move(endpoints->hooks_.parameters));
  return endpoints;
}

ManagedNodeEndpoints::~ManagedNodeEndpoints() {
  EndBond();
}

Result<> ManagedNodeEndpoints::Open() {
  const std::string base = ResolveName(name_space_, name_) + "/";
  auto events = MakePublisher<msg::TransitionEvent>(node_, base + "transition_event");
  if (!events) return events.error();
  events_ = std::move(events).value();
  if (auto change = MakeServer<msg::ChangeState>(
          node_, base + "change_state",
          Server<msg::ChangeState>::HandlerOfCaller(
              [this](const auto& request, auto reply, ParticipantId caller) {
                OnChange(request, reply, caller);
              }));
      change) {
    change_state_ = std::move(change).value();
  } else {
    return change.error();
  }
  const auto open = [&]<class S>(std::unique_ptr<Server<S>>& server, const char* name,
                                 typename Server<S>::Handler handler) -> Result<> {
    auto made = MakeServer<S>(node_, base + name, std::move(handler));
    if (!made) return made.error();
    server = std::move(made).value();
    return Ok();
  };
  if (auto r = open(get_state_, "get_state",
                    [this](const auto&, auto reply) {
                      reply({ToMessage(core_.state())});
                      seen_finalized_ |= core_.state() == Ros2State::kFinalized;
                    });
      !r) {
    return r;
  }
  if (auto r = open(get_states_, "get_available_states",
                    [](const auto&, auto reply) {
                      msg::GetAvailableStates::Response all;
                      all.available_states.reserve(Ros2States().size());
                      for (const Ros2State state : Ros2States()) {
                        all.available_states.push_back(ToMessage(state));
                      }
                      reply(all);
                    });
      !r) {
    return r;
  }
  using Transitions = msg::GetAvailableTransitions::Response;
  if (auto r = open(get_transitions_, "get_available_transitions",
                    [this](const auto&, auto reply) {
                      Transitions now;
                      const auto edges = RequestableIn(core_.state());
                      now.available_transitions.reserve(edges.size());
                      for (const Ros2Edge& edge : edges) {
                        now.available_transitions.push_back(ToMessage(edge));
                      }
                      reply(now);
                    });
      !r) {
    return r;
  }
  return open(get_graph_, "get_transition_graph", [](const auto&, auto reply) {
    Transitions all;
    all.available_transitions.reserve(Ros2Graph().size());
    for (const Ros2Edge& edge : Ros2Graph()) all.available_transitions.push_back(ToMessage(edge));
    reply(all);
  });
}

void ManagedNodeEndpoints::Observe(const State& state, const State& target) {
  core_.Observe(state, target);
  PublishEvent();
}

bool ManagedNodeEndpoints::Holds() const {
  if (!ended_by_manager_) return false;
  return !seen_finalized_ || change_state_->Holds() || get_state_->Holds();
}

void ManagedNodeEndpoints::OnChange(const msg::ChangeState::Request& request,
                                    const Server<msg::ChangeState>::Reply& reply,
                                    ParticipantId caller) {
  const msg::Transition& requested = request.transition;
  const auto refuse = [&](const std::string& why) {
    Refuse(requested.label.empty() ? std::to_string(requested.id) : requested.label.substr(0, 64),
           why);
    reply({false});
  };
  const auto transition = core_.Begin(requested.id, requested.label);
  const auto why = hooks_.refusal
                       ? hooks_.refusal(transition ? &transition.value() : nullptr, caller)
                       : std::optional<Error>();
  if (why && transition) core_.End(false);
  if (why && transition && hooks_.postpone) {
    const auto again = [this, request, reply, caller, alive = std::weak_ptr<bool>(alive_)] {
      if (!alive.expired()) OnChange(request, reply, caller);
    };
    if (hooks_.postpone(transition.value(), caller, again)) return;
  }
  if (why) return refuse(why->message);
  if (!transition) return refuse(transition.error().message);
  PublishEvent();
  hooks_.change(transition.value(), caller,
                [this, reply, transition = transition.value(),
                 alive = std::weak_ptr<bool>(alive_)](const Result<>& result) {
                  reply({result.ok()});
                  if (!alive.expired()) OnEnded(transition, result);
                });
}

void ManagedNodeEndpoints::OnEnded(const Ros2Transition& transition, const Result<>& result) {
  core_.End(result.ok());
  if (!result) {
    Log(Failure(std::string(transition.name),
                WithCode(result.error().message, result.error().code)));
  }
  ended_by_manager_ |= result.ok() && core_.musher_state() == kTearDown;
  PublishEvent();
  if (result && transition.to == Ros2State::kActive) FormBond();
}

void ManagedNodeEndpoints::Refuse(const std::string& transition, const std::string& why) {
  const auto line = refusals_.Refused(Failure(transition, why), node_.loop().Now());
  if (line) Log(*line);
}

// Publishes one event for each change.
void ManagedNodeEndpoints::PublishEvent() {
  const Ros2State now = core_.state();
  const std::optional<Ros2State> from = std::exchange(published_, now);
  if (!from || *from == now) return;
  msg::TransitionEvent event;
  event.transition = TransitionOf(*from, now);
  event.start_state = ToMessage(*from);
  event.goal_state = ToMessage(now);
  static_cast<void>(events_->Publish(event));  // a subscriber that misses one calls get_state
}

void ManagedNodeEndpoints::FormBond() {
  if (!bond_reader_ && !OpenBond()) return;
  AfterBond(bond_.Start(node_.loop().Now()));
}

// Only a node that a manager has activated needs a bond.
bool ManagedNodeEndpoints::OpenBond() {
  const std::string topic = ResolveName(name_space_, "bond");
  auto writer = MakePublisher<msg::BondStatus>(node_, topic, kDefaultQos, {[this] {
                                                 if (bond_writer_)
                                                   AfterBond(bond_.OnReaders(node_.loop().Now()));
                                               }});
  if (!writer) {
    Log("no bond: " + writer.error().message);
    return false;
  }
  bond_writer_ = std::move(writer).value();
  auto reader = MakeSubscription<msg::BondStatus>(
      node_, topic,
      [this](const msg::BondStatus& status, const SampleInfo&) { OnBondStatus(status); });
  if (!reader) {
    Log("no bond: " + reader.error().message);
    return false;
  }
  bond_reader_ = std::move(reader).value();
  return true;
}

void ManagedNodeEndpoints::OnBondStatus(const msg::BondStatus& status) {
  if (status.id != name_ || status.instance_id == instance_) return;
  const Bond::Phase before = bond_.phase();
  AfterBond(bond_.OnHeartbeat(
      {status.instance_id, status.active, Limited(status.heartbeat_timeout)}, node_.loop().Now()));
  const bool broken = before == Bond::Phase::kFormed && bond_.phase() == Bond::Phase::kBroken;
  // A manager also ends it when it has deactivated the node itself.
  const bool active = core_.state() == Ros2State::kActive && !core_.under_way();
  if (broken && active) LogBond("the manager ended the bond");
}

void ManagedNodeEndpoints::EndBond() {
  AfterBond(bond_.Stop(node_.loop().Now()));
}

// Publishes a heartbeat if one is due, and sets the timer for the next one.
void ManagedNodeEndpoints::AfterBond(bool publish) {
  if (publish && bond_writer_) {
    msg::BondStatus status;
    status.header.stamp = msg::ToStamp(node_.loop().Now().time_since_epoch());
    status.id = name_;
    status.instance_id = instance_;
    status.active = bond_.active();
    status.heartbeat_timeout = static_cast<float>(ToSeconds(Bond::kTimeout));
    status.heartbeat_period = static_cast<float>(ToSeconds(Bond::kPeriod));
    static_cast<void>(bond_writer_->Publish(status));  // a lost heartbeat is followed by the next
  }
  const auto next = bond_.next();
  if (!next) {
    bond_timer_ = nullptr;
    return;
  }
  bond_timer_ = node_.loop().At(*next, [this] {
    const Bond::Phase before = bond_.phase();
    AfterBond(bond_.OnTime(node_.loop().Now()));
    const bool broken = before == Bond::Phase::kFormed && bond_.phase() == Bond::Phase::kBroken;
    if (broken) LogBond("the bond with the manager is broken: no heartbeat within its timeout");
  });
}

// Any participant may form a bond and end it, again and again.
void ManagedNodeEndpoints::LogBond(const std::string& line) {
  const auto now = bond_ends_.Refused(line, node_.loop().Now());
  if (now) Log(*now);
}

void ManagedNodeEndpoints::Log(const std::string& line) const {
  if (hooks_.log) hooks_.log(line);
}

}  // namespace musher::transport
