#include "musher/application/skill_node.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "musher/base/joined.hpp"
#include "musher/behavior/tree/node.hpp"
#include "musher/behavior/tree/setup.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/transport/action.hpp"

namespace musher {
namespace {

using Action = msg::SkillExecution;
using Client = transport::ActionClient<Action>;

constexpr Duration kFoundWithin = std::chrono::seconds(3);
constexpr Duration kStartTime = std::chrono::seconds(5);    // for the reply to a goal
constexpr Duration kCancelTime = std::chrono::seconds(1);   // then the cancellation is repeated
constexpr Duration kEndsWithin = std::chrono::seconds(10);  // an earlier goal that is cancelled
constexpr Duration kEndTime = std::chrono::seconds(10);     // of a lost goal that is cancelled

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

// A goal, also after its node was halted, until its end.
struct SkillGoal {
  std::shared_ptr<Client> client;
  std::string action;
  transport::GoalId id{};
  bool released = false;  // its node was halted, or has read the outcome
  int cancels = 0;        // without a reply yet
  double progress = 0;
  std::optional<transport::GoalOutcome<Action>> outcome;
  bool stopped = false;  // its server has ended it, or does not know it, after it was lost

  bool lost() const { return outcome && outcome->end == transport::GoalEnd::kLost; }
  bool MayRun() const { return !outcome || (lost() && !stopped); }
};

void Cancel(const std::shared_ptr<SkillGoal>& goal);

// Of a lost goal, after its server has replied to its cancellation.
void AwaitEnd(const std::shared_ptr<SkillGoal>& goal, std::int8_t return_code) {
  if (return_code == msg::CancelGoal::kErrorUnknownGoalId ||
      return_code == msg::CancelGoal::kErrorGoalTerminated) {
    goal->stopped = true;
    return;
  }
  goal->client->GetOutcome(goal->id, kEndTime, [weak = std::weak_ptr(goal)](const auto& outcome) {
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
  goal->client->Cancel(goal->id, kCancelTime, [weak = std::weak_ptr(goal)](const auto& reply) {
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
  explicit Wire(transport::Endpoints& endpoints) : node_(endpoints.node()) {
    endpoints.SubscribeEach<msg::SkillOffers>(
        "skills",
        [this](const msg::SkillOffers& offers, transport::EndpointId writer) {
          offers_[writer] = offers;
        },
        [this](transport::EndpointId writer) { offers_.erase(writer); },
        transport::kLatchedFromManyQos);
  }
  ~Wire() {
    for (const auto& goal : goals_) Cancel(goal);
  }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  // The offers with that skill, of that actuator; empty: of all.
  std::vector<const msg::SkillOffers*> Find(const std::string& skill,
                                            const std::string& actuator) const {
    std::vector<const msg::SkillOffers*> found;
    for (const auto& [writer, offers] : offers_) {
      if (!actuator.empty() && offers.actuator != actuator) continue;
      const bool has = std::ranges::any_of(offers.skills,
                                           [&](const auto& offer) { return offer.skill == skill; });
      if (has) found.push_back(&offers);
    }
    return found;
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
    auto made = transport::MakeActionClient<Action>(node_, offers.action.substr(1),
                                                    {std::chrono::seconds(3), {}});
    if (!made) return made.error();
    auto goal = std::make_shared<SkillGoal>();
    goal->client = std::move(made).value();
    goal->action = offers.action;
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
      if (own && own->released) Cancel(own);
    };
    events.on_feedback = [weak = std::weak_ptr(goal)](const Action::Feedback& feedback) {
      const auto own = weak.lock();
      if (own) own->progress = ProgressIn(feedback.status).value_or(own->progress);
    };
    events.on_end = [weak = std::weak_ptr(goal)](const auto& outcome) {
      if (const auto own = weak.lock()) TakeOutcome(own, outcome);
    };
    goal->id = goal->client->SendGoal(request, kStartTime, std::move(events));
    goals_.push_back(goal);
    return goal;
  }

 private:
  transport::Node& node_;
  std::map<transport::EndpointId, msg::SkillOffers> offers_;
  std::vector<std::shared_ptr<SkillGoal>> goals_;  // that may not have ended
};

namespace {

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
    const auto parameters = SkillNodes::ReadParameters(parameters_.Or(""));
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
    const std::string actuator = actuator_.Or("");
    const auto found = wire.Find(skill, actuator);
    const Duration waited = tick.now - begun_;
    if (found.empty()) {
      if (waited < kFoundWithin) return tree::Status::kRunning;
      return Fail((actuator.empty() ? "no actuator that runs" : "no actuator " + actuator) +
                  " offers the skill " + skill);
    }
    if (found.size() > 1) {
      std::vector<std::string> names;
      for (const msg::SkillOffers* offers : found) names.push_back(offers->actuator);
      return Fail(skill + " is offered by " + Joined(names) + "; the port actuator chooses one");
    }
    if (wire.IsEnding(found[0]->action)) {
      if (waited < kEndsWithin) return tree::Status::kRunning;
      return Fail("a goal of " + found[0]->actuator + " that was cancelled or lost has not ended");
    }
    auto sent = wire.Send(*found[0], skill, values_);
    if (!sent) return Fail(sent.error().message);
    goal_ = sent.value();
    sent_ = true;
    return tree::Status::kRunning;
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
