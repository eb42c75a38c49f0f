#include "musher/application/skill_node.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/base/joined.hpp"
#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/transport/action.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

using Action = msg::SkillExecution;
using Client = transport::ActionClient<Action>;

constexpr Duration kFoundWithin = std::chrono::seconds(3);
constexpr Duration kStartTime = std::chrono::seconds(5);    // for the reply to a goal
constexpr Duration kCancelTime = std::chrono::seconds(1);   // then the cancellation is repeated
constexpr Duration kEndsWithin = std::chrono::seconds(10);  // an earlier goal that is cancelled
constexpr Duration kEndTime = std::chrono::seconds(10);     // of a lost goal that is cancelled
constexpr int kMostLooks = 2;  // for a run without its goal, each kCancelTime
constexpr const char* kCancelledBy = "a behaviour tree that has lost it";

std::string Trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\n") - first + 1);
}

// "processing: Moving (30%)": 30.
std::optional<double> ProgressIn(const std::string& text) {
  const auto open = text.rfind('(');
  if (open == std::string::npos || !text.ends_with("%)")) return std::nullopt;
  const std::string number = text.substr(open + 1, text.size() - open - 3);
  const bool digits = !number.empty() && number.size() <= 3 &&
                      std::ranges::all_of(number, [](char c) { return c >= '0' && c <= '9'; });
  return digits ? std::optional(std::stod(number)) : std::nullopt;
}

// The machines whose controllers report the processes of their actuators. With security keys an
// actuator may read that, and not the statuses of other actuators.
class MachinesByProcess {
 public:
  void Take(transport::EndpointId controller, const msg::MachineStatus& status) {
    reports_[controller] = status;
  }
  void Drop(transport::EndpointId controller) { reports_.erase(controller); }

  // The machine of the actuator with this name and process; nullopt: of none, or of several.
  std::optional<MachineIdentity> OfActuator(const std::string& name, std::int32_t pid) const {
    return Only([&](const auto& actuator) { return actuator.name == name && actuator.pid == pid; });
  }
  std::optional<MachineIdentity> OfThisProcess() const {
    return Only(
        [](const auto& actuator) { return actuator.pid == getpid() && actuator.host == HostId(); });
  }

 private:
  template <class Is>
  std::optional<MachineIdentity> Only(Is is) const {
    std::optional<MachineIdentity> found;
    for (const auto& [controller, status] : reports_) {
      if (std::ranges::none_of(status.actuators, is)) continue;
      const MachineIdentity machine{status.machine, status.machine_id};
      if (found && !SameMachine(*found, machine)) return std::nullopt;
      found = machine;
    }
    return found;
  }

  std::map<transport::EndpointId, msg::MachineStatus> reports_;
};

// What a skill actuator serves, for all nodes that run its skills.
struct Servers {
  transport::EventLoop& loop;
  std::unique_ptr<Client> action;
  std::unique_ptr<transport::Client<msg::GetSkill>> look;
  std::unique_ptr<transport::Client<msg::CancelSkill>> cancel;
};

// A goal, also after its node was halted, until its end.
struct SkillGoal {
  std::shared_ptr<Servers> servers;
  std::string action;
  std::string skill;
  transport::GoalId id{};
  bool accepted = false;  // as far as known
  bool released = false;  // its node was halted, or has read the outcome
  int cancels = 0;        // without a reply yet
  int looks = 0;          // for its run, after its server does not know the goal
  bool seen = false;      // its run, without the goal
  double progress = 0;
  std::optional<transport::GoalOutcome<Action>> outcome;
  bool stopped = false;  // its server has ended it, or does not know it, after it was lost
  transport::LoopHandlePtr again;  // a look for its run

  bool lost() const { return outcome && outcome->end == transport::GoalEnd::kLost; }
  bool MayRun() const { return !outcome || (lost() && !stopped); }
};

void Cancel(const std::shared_ptr<SkillGoal>& goal);

// Its actuator has restarted, and may go on with the run, without the goal. A run that has another
// goal, or none that runs, is not touched. Where it is not known that the goal was accepted, the
// run may be that of another client: its end is awaited. An actuator that does not reply is asked
// again; one without the service, some times.
void CancelContinuedRun(const std::shared_ptr<SkillGoal>& goal) {
  const bool has_service = !goal->servers->look->Servers().empty();
  if (goal->looks++ >= kMostLooks && !goal->seen && !has_service) {
    goal->stopped = true;
    return;
  }
  msg::GetSkill::Request request;
  request.skill = goal->skill;
  goal->servers->look->Call(request, kCancelTime, [weak = std::weak_ptr(goal)](const auto& reply) {
    const auto own = weak.lock();
    if (!own) return;
    if (!reply) return Cancel(own);
    const msg::SkillFeedback& run = reply.value().feedback;
    const bool runs = reply.value().error.empty() && run.goal_id.empty() && run.state != "IDLE" &&
                      run.status == msg::SkillFeedback::kStatusProcessing;
    if (!runs) {
      own->stopped = true;
      return;
    }
    own->seen = true;
    if (!own->accepted) {
      transport::EventLoop& loop = own->servers->loop;
      own->again = loop.At(loop.Now() + kCancelTime, [weak] {
        if (const auto goal_of_it = weak.lock()) CancelContinuedRun(goal_of_it);
      });
      return;
    }
    msg::CancelSkill::Request cancel;
    cancel.skill = own->skill;
    cancel.by = kCancelledBy;
    own->servers->cancel->Call(cancel, kEndTime, [weak](const auto& ended) {
      const auto goal_of_it = weak.lock();
      if (!goal_of_it) return;
      if (!ended) return Cancel(goal_of_it);
      goal_of_it->stopped = true;
    });
  });
}

// Waits for the end of a lost goal, after its server has replied to its cancellation.
void AwaitEnd(const std::shared_ptr<SkillGoal>& goal, std::int8_t return_code) {
  if (return_code == msg::CancelGoal::kErrorUnknownGoalId) return CancelContinuedRun(goal);
  if (return_code == msg::CancelGoal::kErrorGoalTerminated) {
    goal->stopped = true;
    return;
  }
  goal->servers->action->GetOutcome(goal->id, kEndTime,
                                    [weak = std::weak_ptr(goal)](const auto& outcome) {
                                      const auto own = weak.lock();
                                      if (!own) return;
                                      own->stopped = outcome.ok();
                                      if (!own->stopped) Cancel(own);
                                    });
}

// Again and again, until the goal has ended: a request or its reply may be lost, and the actuator
// may not know the goal yet.
void Cancel(const std::shared_ptr<SkillGoal>& goal) {
  if (!goal->MayRun()) return;
  ++goal->cancels;
  goal->servers->action->Cancel(goal->id, kCancelTime,
                                [weak = std::weak_ptr(goal)](const auto& reply) {
                                  const auto own = weak.lock();
                                  if (!own) return;
                                  --own->cancels;
                                  if (!own->MayRun()) return;
                                  if (!reply) return Cancel(own);
                                  if (own->lost()) AwaitEnd(own, reply.value().return_code);
                                });
}

void TakeOutcome(const std::shared_ptr<SkillGoal>& goal,
                 const transport::GoalOutcome<Action>& outcome) {
  goal->outcome = outcome;
  if (goal->lost() && goal->cancels == 0) Cancel(goal);
}

}  // namespace

class SkillNodes::Wire {
 public:
  struct Offer {
    msg::SkillOffers offers;
    transport::ParticipantId participant;
    std::uint64_t number = 0;  // grows with each that is received
  };
  struct OffersByMachine {
    std::vector<const Offer*> own;  // of this machine, as far as known: the newest of each actuator
    std::vector<const Offer*> others;  // of other machines
  };

  explicit Wire(transport::Endpoints& endpoints)
      : node_(endpoints.node()), name_space_(endpoints.name_space()) {
    ReceiveStatuses(endpoints.name_space());
    ReceiveReports(endpoints.name_space());
    endpoints.SubscribeWithInfo<msg::SkillOffers>(
        "skills",
        [this](const msg::SkillOffers& offers, const transport::SampleInfo& info) {
          offers_[info.writer] = {offers, info.participant, ++received_};
        },
        [this](transport::EndpointId writer) { offers_.erase(writer); },
        transport::kLatchedFromManyQos);
  }
  ~Wire() {
    for (const auto& goal : goals_) Cancel(goal);
  }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  // The offers with that skill, of that actuator; empty: of all. A process that has crashed keeps
  // its offers until its lease ends.
  OffersByMachine Find(const std::string& skill, const std::string& actuator) const {
    std::map<std::string, const Offer*> newest;
    OffersByMachine found;
    const auto has = [&](const Offer& offer) {
      return std::ranges::any_of(offer.offers.skills,
                                 [&](const auto& one) { return one.skill == skill; });
    };
    for (const auto& [writer, offer] : offers_) {
      if (!actuator.empty() && offer.offers.actuator != actuator) continue;
      if (IsOfAnother(offer)) {
        if (has(offer)) found.others.push_back(&offer);
        continue;
      }
      const Offer*& known = newest[offer.offers.actuator];
      if (known == nullptr || known->number < offer.number) known = &offer;
    }
    for (const auto& [name, offer] : newest) {
      if (has(*offer)) found.own.push_back(offer);
    }
    return found;
  }

  // The machine of this process; nullopt: not known.
  std::optional<MachineIdentity> own_machine() const {
    const auto own = MachineByStatus(node_.participant());
    return own ? own : machines_.OfThisProcess();
  }
  std::optional<MachineIdentity> MachineOf(const Offer& offer) const {
    auto machine = MachineByStatus(offer.participant);
    if (machine) return machine;
    const std::int32_t pid = ProcessOf(offer.participant);
    return pid == 0 ? std::nullopt : machines_.OfActuator(offer.offers.actuator, pid);
  }
  // Whether what says the machine of an offer may still come.
  bool MayBeKnownLater(const Offer& offer) const {
    return !MachineOf(offer) && (statuses_in_ != nullptr || ProcessOf(offer.participant) != 0);
  }
  // Offers of another machine by that action, whose actuator would receive a goal, too; or null.
  const Offer* OfAnotherBy(const std::string& action) const {
    const auto found = std::ranges::find_if(offers_, [&](const auto& entry) {
      return entry.second.offers.action == action && IsOfAnother(entry.second);
    });
    return found == offers_.end() ? nullptr : &found->second;
  }

  // Whether a goal for that action is cancelled, or lost, and may still run.
  bool IsEnding(const std::string& action) {
    std::erase_if(goals_, [](const auto& goal) { return goal->released && !goal->MayRun(); });
    return std::ranges::any_of(goals_, [&](const auto& goal) {
      return goal->action == action && goal->MayRun() && (goal->released || goal->lost());
    });
  }

  Result<std::shared_ptr<SkillGoal>> Send(const msg::SkillOffers& offers, const std::string& skill,
                                          const Parameters& parameters) {
    const auto servers = ServersOf(offers);
    if (!servers) return servers.error();
    auto goal = std::make_shared<SkillGoal>();
    goal->servers = servers.value();
    goal->action = offers.action;
    goal->skill = skill;
    Action::Goal request;
    request.skill_request.robot_id = offers.actuator;
    request.skill_request.skill_list.resize(1);
    request.skill_request.skill_list[0].skill = skill;
    for (const auto& [key, value] : parameters) {
      request.skill_request.skill_list[0].params.push_back({key, value});
    }
    transport::GoalEvents<Action> events;
    events.on_accepted = [weak = std::weak_ptr(goal)] {
      const auto own = weak.lock();
      if (!own) return;
      own->accepted = true;
      if (own->released) Cancel(own);
    };
    events.on_feedback = [weak = std::weak_ptr(goal)](const Action::Feedback& feedback) {
      const auto own = weak.lock();
      if (!own) return;
      own->progress = ProgressIn(feedback.status).value_or(own->progress);
    };
    events.on_end = [weak = std::weak_ptr(goal)](const auto& outcome) {
      if (const auto own = weak.lock()) TakeOutcome(own, outcome);
    };
    goal->id = goal->servers->action->SendGoal(request, kStartTime, std::move(events));
    goals_.push_back(goal);
    return goal;
  }

 private:
  // Made for the first goal, and kept for all that follow.
  Result<std::shared_ptr<Servers>> ServersOf(const msg::SkillOffers& offers) {
    std::shared_ptr<Servers>& known = servers_[{offers.action, offers.actuator}];
    if (known) return known;
    auto action = transport::MakeActionClient<Action>(node_, offers.action.substr(1),
                                                      {std::chrono::seconds(3), {}});
    if (!action) return action.error();
    const auto name = [&](const char* service) {
      return transport::ResolveName(name_space_, offers.actuator + service);
    };
    auto look = transport::MakeClient<msg::GetSkill>(node_, name("/get_skill"));
    if (!look) return look.error();
    auto cancel = transport::MakeClient<msg::CancelSkill>(node_, name("/cancel_skill"));
    if (!cancel) return cancel.error();
    known = std::make_shared<Servers>(Servers{node_.loop(), std::move(action).value(),
                                              std::move(look).value(), std::move(cancel).value()});
    return known;
  }

  struct Status {
    MachineIdentity machine;
    transport::ParticipantId participant;
  };

  std::optional<MachineIdentity> MachineByStatus(transport::ParticipantId participant) const {
    for (const auto& [writer, status] : statuses_) {
      if (status.participant == participant && !status.machine.name.empty()) return status.machine;
    }
    return std::nullopt;
  }
  // 0: it does not say it.
  std::int32_t ProcessOf(transport::ParticipantId participant) const {
    const std::vector<transport::PeerInfo> peers = node_.Peers();
    const auto peer = std::ranges::find(peers, participant, &transport::PeerInfo::id);
    return peer == peers.end() ? 0 : peer->pid;
  }

  // With security keys there is no permission to read them.
  void ReceiveStatuses(const std::string& name_space) {
    transport::SubscriptionEvents events;
    events.on_writer_lost = [this](transport::EndpointId writer) { statuses_.erase(writer); };
    auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
        node_, transport::ActuatorStatusTopic(name_space),
        [this](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
          if (!transport::IsFrom(status, info)) return;
          statuses_[info.writer] = {{status.machine, status.machine_id}, info.participant};
        },
        transport::kLatchedFromManyQos, std::move(events));
    if (statuses) statuses_in_ = std::move(statuses).value();
  }
  void ReceiveReports(const std::string& name_space) {
    transport::SubscriptionEvents events;
    events.on_writer_lost = [this](transport::EndpointId writer) { machines_.Drop(writer); };
    auto reports = transport::MakeSubscription<msg::MachineStatus>(
        node_, transport::MachineStatusTopic(name_space),
        [this](const msg::MachineStatus& status, const transport::SampleInfo& info) {
          if (transport::IsOwn(status.participant, info)) machines_.Take(info.writer, status);
        },
        transport::kLatchedFromManyQos, std::move(events));
    if (reports) reports_in_ = std::move(reports).value();
  }
  bool IsOfAnother(const Offer& offer) const {
    const auto own = own_machine();
    const auto other = MachineOf(offer);
    return own && other && !SameMachine(*own, *other);
  }

  transport::Node& node_;
  const std::string name_space_;
  std::map<std::pair<std::string, std::string>, std::shared_ptr<Servers>> servers_;
  std::map<transport::EndpointId, Offer> offers_;
  std::map<transport::EndpointId, Status> statuses_;
  std::uint64_t received_ = 0;
  std::vector<std::shared_ptr<SkillGoal>> goals_;  // that may not have ended
  MachinesByProcess machines_;
  // Last: their callbacks use the rest.
  std::unique_ptr<transport::Subscription> statuses_in_;
  std::unique_ptr<transport::Subscription> reports_in_;
};

namespace {

// "" for a port that is left out. An entry must have a value: left out, the port `actuator` is for
// any of them.
std::string Given(const tree::InPort<std::string>& port) {
  return port.entry() == nullptr ? port.Or("") : port.Get();
}

class RunSkill : public tree::StatefulAction {
 public:
  RunSkill(tree::Setup& setup, const std::weak_ptr<SkillNodes::Wire>& wire)
      : skill_(setup.Input<std::string>("skill", "its name")),
        actuator_(
            setup.OptionalInput<std::string>("actuator", "that offers it; else the only one")),
        parameters_(setup.OptionalInput<std::string>("parameters", "KEY=VALUE; KEY=VALUE")),
        progress_(setup.Output<double>("progress", "of the skill, 0 to 100")),
        message_(setup.Output<std::string>("message", "how it has ended, or why it was refused")),
        wire_(wire) {}

 private:
  tree::Status OnStart(const tree::Tick& tick) override {
    sent_ = false;
    begun_ = tick.now;
    const auto parameters = SkillNodes::ReadParameters(Given(parameters_));
    if (!parameters) return Fail(parameters.error().message);
    values_ = parameters.value();
    progress_.Set(0);
    return OnRunning(tick);
  }
  tree::Status OnRunning(const tree::Tick& tick) override {
    const auto wire = wire_.lock();
    if (!wire) return Fail("its topics are not open");
    if (!sent_) return Begin(*wire, tick);
    const auto goal = goal_.lock();
    if (!goal) return Fail("its topics were closed while it ran");
    progress_.Set(goal->progress);
    if (!goal->outcome) return tree::Status::kRunning;
    goal->released = true;
    const auto& outcome = *goal->outcome;
    const std::string text = outcome.reason.empty() ? outcome.result.message : outcome.reason;
    if (goal->lost()) {
      return Fail(
          (goal->MayRun() ? "lost; it may still run, and is cancelled once possible: " : "lost: ") +
          text);
    }
    if (outcome.end != transport::GoalEnd::kSucceeded) return Fail(text);
    progress_.Set(100);
    message_.Set(text);
    return tree::Status::kSuccess;
  }
  void OnHalted(const tree::Tick& /*tick*/) override {
    const auto goal = goal_.lock();
    if (!std::exchange(sent_, false) || !goal) return;
    goal->released = true;
    Cancel(goal);
  }

  tree::Status Begin(SkillNodes::Wire& wire, const tree::Tick& tick) {
    const std::string& skill = skill_.Get();
    const std::string actuator = Given(actuator_);
    const auto found = wire.Find(skill, actuator);
    const Duration waited = tick.now - begun_;
    const bool may_wait = waited < kFoundWithin;
    if (found.own.empty()) {
      if (may_wait) return tree::Status::kRunning;
      return Fail(NoneText(wire, skill, actuator, found.others));
    }
    // The status of an actuator may be received after its offers.
    const bool all_known =
        !wire.own_machine() || std::ranges::none_of(found.own, [&](const auto* offer) {
          return wire.MayBeKnownLater(*offer);
        });
    if (!all_known && may_wait) return tree::Status::kRunning;
    if (found.own.size() > 1) {
      std::vector<std::string> names;
      for (const auto* offer : found.own) names.push_back(offer->offers.actuator);
      return Fail(skill + " is offered by " + Joined(names) + "; the port actuator chooses one");
    }
    const msg::SkillOffers& offers = found.own[0]->offers;
    if (offers.action.size() < 2) {
      return Fail(offers.actuator + " offers " + skill + " without an action");
    }
    if (const auto* other = wire.OfAnotherBy(offers.action)) {
      return Fail(offers.action + " is served by " + MachineText(*wire.MachineOf(*other)) +
                  ", too, which would receive the goal; give each machine a namespace");
    }
    if (wire.IsEnding(offers.action)) {
      if (waited < kEndsWithin) return tree::Status::kRunning;
      return Fail("a goal of " + offers.actuator + " that was cancelled or lost has not ended");
    }
    auto sent = wire.Send(offers, skill, values_);
    if (!sent) return Fail(sent.error().message);
    goal_ = sent.value();
    sent_ = true;
    return tree::Status::kRunning;
  }
  static std::string NoneText(const SkillNodes::Wire& wire, const std::string& skill,
                              const std::string& actuator,
                              const std::vector<const SkillNodes::Wire::Offer*>& others) {
    std::string whose;
    std::vector<std::string> names;
    for (const auto* offer : others) {  // of another machine: both are known
      whose = " of " + MachineText(*wire.own_machine());
      names.push_back(offer->offers.actuator + " of " + MachineText(*wire.MachineOf(*offer)));
    }
    return (actuator.empty() ? "no actuator" + whose + " that runs"
                             : "no actuator " + actuator + whose) +
           " offers the skill " + skill +
           (names.empty() ? "" : "; it is offered by " + Joined(names));
  }
  tree::Status Fail(const std::string& why) {
    message_.Set(why);
    return tree::Status::kFailure;
  }

  tree::InPort<std::string> skill_;
  tree::InPort<std::string> actuator_;
  tree::InPort<std::string> parameters_;
  tree::OutPort<double> progress_;
  tree::OutPort<std::string> message_;
  const std::weak_ptr<SkillNodes::Wire>& wire_;
  Time begun_{};
  SkillNodes::Parameters values_;
  bool sent_ = false;
  std::weak_ptr<SkillGoal> goal_;  // until its endpoints are dropped
};

}  // namespace

Result<SkillNodes::Parameters> SkillNodes::ReadParameters(const std::string& text) {
  Parameters parameters;
  std::string part;
  int depth = 0;
  char quote = 0;
  const auto take = [&]() -> Result<> {
    const std::string trimmed = Trimmed(std::exchange(part, ""));
    if (trimmed.empty()) return Ok();
    const auto equals = trimmed.find('=');
    if (equals == std::string::npos || equals == 0) {
      return Error{kCodeParametersInvalid,
                   "port 'parameters': expected KEY=VALUE, found '" + trimmed.substr(0, 40) + "'"};
    }
    std::string value = Trimmed(trimmed.substr(equals + 1));
    const bool quoted = value.size() >= 2 && value.front() == '"' && value.back() == '"';
    if (quoted) value = value.substr(1, value.size() - 2);
    parameters.emplace_back(Trimmed(trimmed.substr(0, equals)), std::move(value));
    return Ok();
  };
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"') {
      quote = c;
    } else if (c == '[') {
      ++depth;
    } else if (c == ']') {
      --depth;
    }
    if (c == ';' && quote == 0 && depth <= 0) {
      if (const Result<> taken = take(); !taken) return taken.error();
      continue;
    }
    part += c;
  }
  if (const Result<> taken = take(); !taken) return taken.error();
  return parameters;
}

Result<> SkillNodes::Register(tree::Factory& factory) {
  return factory.Add<RunSkill>("RunSkill", wire_);
}

void SkillNodes::Open(transport::Endpoints& endpoints) {
  const auto wire = std::make_shared<Wire>(endpoints);
  wire_ = wire;
  endpoints.Keep(wire);
}

}  // namespace musher
