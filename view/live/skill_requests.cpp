#include "musher/view/live/skill_requests.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <utility>

#include "musher/transport/goal_id_text.hpp"
#include "musher/view/http/reply.hpp"

namespace musher::view {
namespace {

using GoalEnded = transport::GoalOutcome<msg::SkillExecution>;

bool IsName(const std::string& action) {
  static constexpr const char* kNameCharacters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_/";
  return action.size() > 1 && action.size() < 256 &&
         action.find_first_not_of(kNameCharacters) == std::string::npos;
}

http::Response GoalResponse(const std::string& json) {
  http::Response response;
  response.body = std::make_shared<const std::string>(json);
  return response;
}

http::Response NotMeant(const Error& why) {
  return http::ErrorResponse(why.code == kCodeTimeout ? 504 : 409, why.code, why.message);
}

http::Response Running(const std::string& goal_id) {
  return GoalResponse(R"({"goal_id":)" + http::JsonText(goal_id) + "}");
}

// Of a goal that ended before it was seen to run.
http::Response EndResponse(const GoalEnded& outcome, const std::string& goal_id) {
  switch (outcome.end) {
    case transport::GoalEnd::kSucceeded:
    case transport::GoalEnd::kCanceled:
      return Running(goal_id);
    case transport::GoalEnd::kAborted:
      return http::ErrorResponse(409, kCodeFailed, outcome.result.message);
    case transport::GoalEnd::kRejected:
      return http::ErrorResponse(409, kCodeFailed, outcome.reason);
    default:
      return http::ErrorResponse(504, kCodeTimeout, outcome.reason);
  }
}

http::Response CancelResponse(const Result<msg::CancelGoal::Response>& reply) {
  if (!reply) return http::ErrorResponse(504, reply.error().code, reply.error().message);
  switch (reply.value().return_code) {
    case msg::CancelGoal::kErrorNone:
      return GoalResponse("{}");
    case msg::CancelGoal::kErrorRejected:
      return http::ErrorResponse(409, kCodeFailed, "the actuator refuses the cancellation");
    default:
      return http::ErrorResponse(409, kCodeStateInvalid, "that run has ended already");
  }
}

// Of the replies of an action's servers to the cancellation of a goal, which at most one of them
// runs: that of this one. That it is not known counts once all of them have replied so.
transport::RawActionClient::CancelCounts CountsOfCancel(
    std::function<std::vector<transport::ParticipantId>()> servers) {
  return [servers = std::move(servers), unknown = std::set<transport::ParticipantId>()](
             transport::ParticipantId server, const msg::CancelGoal::Response& reply) mutable {
    if (reply.return_code != msg::CancelGoal::kErrorUnknownGoalId) return true;
    unknown.insert(server);
    const auto all = servers();
    return all.size() < 2 ||
           std::ranges::all_of(all, [&](const auto& one) { return unknown.contains(one); });
  };
}

// Of the services pause_skill and cancel_skill.
template <class Reply>
http::Response DoneResponse(const Result<Reply>& reply) {
  if (!reply) return http::ErrorResponse(504, reply.error().code, reply.error().message);
  if (!reply.value().success) {
    return http::ErrorResponse(409, kCodeStateInvalid, reply.value().message);
  }
  return GoalResponse("{}");
}

}  // namespace

Result<SkillRequests::Client*> SkillRequests::ClientOf(const std::string& action) {
  if (!IsName(action)) {
    return Error{kCodeParametersInvalid, "'" + action + "' is not the name of an action"};
  }
  const auto known = clients_.find(action);
  if (known != clients_.end()) return known->second.get();
  if (clients_.size() >= kMostActions) {
    return Error{kCodeParametersInvalid, "the page has requested skills of too many actions"};
  }
  auto made = transport::MakeActionClient<msg::SkillExecution>(
      node_, transport::ResolveName(name_space_, action));
  if (!made) return made.error();
  return (clients_[action] = std::move(made).value()).get();
}

template <class Service>
Result<transport::Client<Service>*> SkillRequests::ServiceOf(Clients<Service>& clients,
                                                             const std::string& actuator,
                                                             const std::string& name) {
  if (!IsName("/" + actuator)) {
    return Error{kCodeParametersInvalid, "'" + actuator + "' is not the name of an actuator"};
  }
  const auto known = clients.find(actuator);
  if (known != clients.end()) return known->second.get();
  if (clients.size() >= kMostActions) {
    return Error{kCodeParametersInvalid, "the page has called " + name + " of too many actuators"};
  }
  auto made = transport::MakeClient<Service>(
      node_, transport::ResolveName(name_space_, actuator + "/" + name));
  if (!made) return made.error();
  return (clients[actuator] = std::move(made).value()).get();
}

void SkillRequests::Answer(Begun& begun, http::Response response) {
  if (!begun.respond) return;
  begun.timer.reset();
  std::exchange(begun.respond, nullptr)(std::move(response));
}

void SkillRequests::Run(const MachineIdentity& machine, const Request& request,
                        const http::Respond& respond) {
  const auto client = ClientOf(request.action);
  if (!client) {
    return respond(http::ErrorResponse(400, client.error().code, client.error().message));
  }
  meant_.Check(
      request.actuator, [client = client.value()] { return client->Servers(); }, machine,
      [this, client = client.value(), request, respond](const std::optional<Error>& why) {
        if (why) return respond(NotMeant(*why));
        Begin(*client, request, respond);
      });
}

void SkillRequests::Begin(Client& client, const Request& request, const http::Respond& respond) {
  msg::SkillExecution::Goal goal;
  goal.skill_request.robot_id = request.actuator;
  goal.skill_request.skill_list.resize(1);
  goal.skill_request.skill_list[0].skill = request.skill;
  goal.skill_request.skill_list[0].params = request.parameters;
  const auto begun = std::make_shared<Begun>();
  begun->respond = respond;
  transport::GoalEvents<msg::SkillExecution> events;
  events.on_accepted = [this, begun] {
    begun->timer =
        node_.loop().At(node_.loop().Now() + kRefusalTime, [weak = std::weak_ptr<Begun>(begun)] {
          if (const auto one = weak.lock()) Answer(*one, Running(one->goal_id));
        });
  };
  events.on_end = [begun](const GoalEnded& outcome) {
    Answer(*begun, EndResponse(outcome, begun->goal_id));
  };
  begun->goal_id = transport::GoalIdText(client.SendGoal(goal, kAnswerTime, std::move(events)));
}

void SkillRequests::Cancel(const std::string& action, const std::string& goal_id,
                           const http::Respond& respond) {
  const auto id = transport::ReadGoalId(goal_id);
  if (!id) {
    return respond(http::ErrorResponse(400, kCodeParametersInvalid,
                                       "'" + goal_id + "' is not the id of a goal"));
  }
  const auto client = ClientOf(action);
  if (!client) {
    return respond(http::ErrorResponse(400, client.error().code, client.error().message));
  }
  client.value()->Cancel(
      *id, kAnswerTime, [respond](const auto& reply) { respond(CancelResponse(reply)); },
      CountsOfCancel([client = client.value()] { return client->Servers(); }));
}

template <class Service>
void SkillRequests::CallMeant(transport::Client<Service>& client, const MachineIdentity& machine,
                              const std::string& actuator, const typename Service::Request& request,
                              Duration timeout, const http::Respond& respond) {
  const auto of_another = std::make_shared<bool>(false);
  client.CallAll(
      request, timeout,
      [this, &client, machine, of_another](transport::ParticipantId server, const auto&) {
        const bool counts = meant_.IsMeant(server, client.Servers(), machine);
        *of_another |= !counts;
        return counts;
      },
      [respond, machine, actuator, of_another](const auto& reply) {
        if (reply || !*of_another) return respond(DoneResponse(reply));
        respond(http::ErrorResponse(
            504, kCodeTimeout,
            "no reply of " + actuator + " of " +
                (machine.name.empty() ? "the machine on the page" : MachineText(machine)) +
                "; only another machine's " + actuator +
                " has replied. Give each machine a namespace"));
      });
}

void SkillRequests::CancelRun(const MachineIdentity& machine, const std::string& by,
                              const std::string& actuator, const std::string& skill,
                              const http::Respond& respond) {
  ++rests_[actuator];
  const auto client = ServiceOf(cancels_, actuator, "cancel_skill");
  if (!client) {
    return respond(http::ErrorResponse(400, client.error().code, client.error().message));
  }
  msg::CancelSkill::Request request;
  request.skill = skill;
  request.by = by + " on the page";
  CallMeant(*client.value(), machine, actuator, request, kCancelTime, respond);
}

void SkillRequests::Pause(const MachineIdentity& machine, const std::string& actuator,
                          const std::string& skill, const http::Respond& respond) {
  const auto client = ServiceOf(pauses_, actuator, "pause_skill");
  if (!client) {
    return respond(http::ErrorResponse(400, client.error().code, client.error().message));
  }
  ++rests_[actuator];
  CallMeant(*client.value(), machine, actuator, {skill, /*pause=*/true}, kAnswerTime, respond);
}

void SkillRequests::Resume(const MachineIdentity& machine, const std::string& actuator,
                           const std::string& skill, const http::Respond& respond) {
  const auto client = ServiceOf(pauses_, actuator, "pause_skill");
  if (!client) {
    return respond(http::ErrorResponse(400, client.error().code, client.error().message));
  }
  meant_.Check(
      actuator, [client = client.value()] { return client->Servers(); }, machine,
      [this, client = client.value(), machine, actuator, skill, respond,
       before = rests_[actuator]](const std::optional<Error>& why) {
        if (why) return respond(NotMeant(*why));
        if (rests_[actuator] != before) {
          return respond(http::ErrorResponse(409, kCodeStateInvalid,
                                             "it was paused or cancelled meanwhile. Nothing was "
                                             "done"));
        }
        CallMeant(*client, machine, actuator, {skill, /*pause=*/false}, kAnswerTime, respond);
      });
}

}  // namespace musher::view
