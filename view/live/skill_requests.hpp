#pragma once
// The requests of a page for skills: runs one, pauses, resumes and cancels it. How a run goes on
// and ends is in the topic `skill_feedback`, which the page watches.
//
// Threads: loop thread only, callbacks too. Each `respond` runs once, within a time; never after
// this is dropped. Errors are responses with a status and a sentence:
//   400 the request is malformed
//   409 the skill is refused, or cannot be cancelled, paused or resumed; or a machine beside the
//       one on the page would receive the request
//   504 no answer in time of the machine on the page

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/service.hpp"
#include "musher/view/http/server.hpp"
#include "musher/view/live/meant_servers.hpp"

namespace musher::view {

class SkillRequests {
 public:
  static constexpr Duration kAnswerTime = std::chrono::seconds(5);
  // An actuator accepts a goal before it looks at it: one that is refused ends within this time.
  static constexpr Duration kRefusalTime = Milliseconds(500);
  // A skill ends within 5 s of its cancellation, unless it has another limit.
  static constexpr Duration kCancelTime = std::chrono::seconds(15);
  static constexpr std::size_t kMostActions = 64;

  // The node must outlive it.
  SkillRequests(transport::Node& node, std::string name_space, bool with_keys)
      : node_(node), name_space_(std::move(name_space)), meant_(node, name_space_, with_keys) {}

  struct Request {
    std::string action;  // of SkillOffers: "/robot_0/skill_execution"
    std::string actuator;
    std::string skill;
    std::vector<msg::SkillParameter> parameters;
  };
  // {"goal_id":"…"} once it runs, or has ended well. `machine`: the one on the page.
  void Run(const MachineIdentity& machine, const Request& request, const http::Respond& respond);
  // {} once an actuator is cancelling it. `goal_id`: of SkillFeedback. That it has ended is said
  // once every server of the action has replied that it does not run it.
  void Cancel(const std::string& action, const std::string& goal_id, const http::Respond& respond);
  // The same of a run without a goal, which goes on after a restart: {} once it has ended on
  // `machine`, the one on the page. `by`: the person, for its result.
  void CancelRun(const MachineIdentity& machine, const std::string& by, const std::string& actuator,
                 const std::string& skill, const http::Respond& respond);
  // {} once it stands on `machine`. Others that receive it pause, too, and their replies do not
  // count.
  void Pause(const MachineIdentity& machine, const std::string& actuator, const std::string& skill,
             const http::Respond& respond);
  // {} once it goes on.
  void Resume(const MachineIdentity& machine, const std::string& actuator, const std::string& skill,
              const http::Respond& respond);

 private:
  using Client = transport::ActionClient<msg::SkillExecution>;
  struct Begun {
    http::Respond respond;  // empty: it was answered
    std::string goal_id;
    transport::LoopHandlePtr timer;
  };

  template <class Service>
  using Clients = std::map<std::string, std::unique_ptr<transport::Client<Service>>>;

  Result<Client*> ClientOf(const std::string& action);
  // Of the service `name` of an actuator.
  template <class Service>
  Result<transport::Client<Service>*> ServiceOf(Clients<Service>& clients,
                                                const std::string& actuator,
                                                const std::string& name);
  static void Answer(Begun& begun, http::Response response);
  void Begin(Client& client, const Request& request, const http::Respond& respond);
  // At once. Only the reply of `machine` counts.
  template <class Service>
  void CallMeant(transport::Client<Service>& client, const MachineIdentity& machine,
                 const std::string& actuator, const typename Service::Request& request,
                 Duration timeout, const http::Respond& respond);

  transport::Node& node_;
  const std::string name_space_;
  MeantServers meant_;
  std::map<std::string, std::unique_ptr<Client>> clients_;  // by action
  Clients<msg::PauseSkill> pauses_;                         // by actuator
  // Of each actuator, how often a skill was paused or cancelled: what waits to go on is outdated.
  std::map<std::string, std::uint64_t> rests_;
  Clients<msg::CancelSkill> cancels_;  // by actuator
};

}  // namespace musher::view
