#pragma once
// The requests of a page to the robot, over the services of its controller and its applications.
// Answers are JSON with the fields of the service's response.
//
// Threads: loop thread only, callbacks too. Each `respond` runs once, within a time; never after
// this is dropped. Errors are responses with a status and a sentence:
//   400 the request is malformed        404 no actuator of that name, or it has no such service
//   409 another machine may be meant    503 no controller leads
//   504 no answer in time, or the controller is lost
// A switch that is refused, undone or degraded is an answer, no error.
//
// What acts is refused where another machine may be meant than the one that is followed. An
// emergency stop is never refused: there it is for each machine that may be meant, also for one
// that runs on this host in another namespace.

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/client/leader_call.hpp"
#include "musher/controller/client/machine_here.hpp"
#include "musher/controller/client/stop_latch.hpp"
#include "musher/controller/client/switch_client.hpp"
#include "musher/controller/storage/machine_places.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/tree.hpp"
#include "musher/view/http/server.hpp"
#include "musher/view/json/message_json.hpp"
#include "musher/view/live/stop_beside.hpp"

namespace musher::view {

class RobotRequests {
 public:
  static constexpr Duration kAnswerTime = std::chrono::seconds(5);
  static constexpr Duration kSwitchTime = std::chrono::seconds(120);
  static constexpr Duration kRestartTime = std::chrono::seconds(60);
  static constexpr Duration kStopTime = std::chrono::seconds(3);

  static constexpr std::size_t kMostStops = 8;

  // Searches this host for its machines without waiting: `on_found` runs once, later.
  using FindMachines = std::function<void(std::function<void(std::vector<MachineHere>)> on_found)>;
  struct Options {
    std::string name_space;
    std::string host;          // HostId()
    bool with_keys = false;    // the machine has [security]
    StopScope stops = {};      // where a stop looks for its actuators
    std::string machine = {};  // by which a person has chosen it: see LeaderWatch::Options::word
    FindMachines find = {};    // empty: the machines of `stops` are those of this host
    // Where machines run on this host; empty: not looked for.
    std::function<std::vector<MachinePlace>()> places = {};
  };
  // A person on a page.
  struct Caller {
    std::string by;              // for the history
    MachineIdentity shown = {};  // the machine on the page; empty: it does not say
  };
  // The leading controller, and the machine that is shown.
  using Leader = std::function<const LeaderWatch&()>;

  // The node must outlive it.
  RobotRequests(transport::Node& node, Options options, Leader leader);

  void Plan(const std::string& target, const std::string& actuator, const http::Respond& respond);
  void Set(const Caller& caller, const std::string& target, const std::string& actuator,
           const http::Respond& respond);
  void Restart(const Caller& caller, const std::string& actuator, const http::Respond& respond);
  // {"code":0,"reason":""} once the controller and all actuators that can have latched it, without
  // a controller with the reason that the stop is on no disk; else, after kStopTime, which have
  // not. Only the last kMostStops are followed and stay published.
  void Stop(const Caller& caller, const std::string& reason, const http::Respond& respond);
  // Only if no other stop than these is engaged. `seen`: MachineStatus.stop_ids, as the page has
  // shown them; empty: all that are engaged.
  void Release(const Caller& caller, const std::vector<std::string>& seen,
               const http::Respond& respond);
  // Why the machine that is followed may not be the one that a person on this host means.
  std::optional<Error> WhyNotMeant() const;
  // Whether the caller may act on the machine that is followed; if not, it has responded.
  bool IsMeant(const Caller& caller, const http::Respond& respond) const;
  void History(std::uint32_t limit, const http::Respond& respond);
  // `format` of the graph: "mermaid", "dot" or "".
  void Behavior(const std::string& actuator, const std::string& format,
                const http::Respond& respond);
  void Tree(const std::string& actuator, const http::Respond& respond);

  // The status has changed.
  void OnStatus();

 private:
  struct Switch {
    std::unique_ptr<SwitchClient> client;
    bool ended = false;
  };
  struct RestartCall {
    std::unique_ptr<LeaderCall<msg::RestartActuator>> call;
    bool ended = false;
  };
  // Whom a stop reaches.
  struct StopAddress {
    MachineIdentity machine = {};             // empty: every machine
    std::string id_begins = {};               // and each machine whose id begins so; empty: none
    std::vector<MachineIdentity> by_id = {};  // of these, the known ones
  };
  struct EstopCall {
    std::unique_ptr<StopLatch> latch;
    std::vector<std::unique_ptr<StopBeside>> beside;
    http::Respond respond;  // empty: it was answered
    Time answer_by;
    Time drop_at;  // until then it reaches actuators that join, unless it is released
    StopScope scope;
    StopAddress address;
    std::uint64_t search = 0;  // the first search of this host that began after it …
    bool searched = false;     // … has ended
  };

  template <msg::Service S>
  void Call(const std::string& service, const typename S::Request& request, Duration timeout,
            const http::Respond& respond);
  template <msg::Service S>
  void CallApplication(std::map<std::string, std::unique_ptr<transport::Client<S>>>& clients,
                       const std::string& actuator, const std::string& service,
                       const typename S::Request& request, const http::Respond& respond);
  template <msg::Service S>
  void Answer(const http::Respond& respond, const typename S::Response& response);
  const std::optional<msg::MachineStatus>& status() const { return leader_().leader(); }
  LeaderWatch::Options LeaderOptions();
  bool HasController(const http::Respond& respond);
  bool HasActuator(const std::string& actuator, const http::Respond& respond);
  bool HasActuatorsOfAnother() const;
  StopAddress AddressOfStop(const MachineIdentity& shown) const;
  MachinePlace own_place() const { return {options_.stops.domain_id, options_.name_space}; }
  std::vector<MachinePlace> PlacesBeside() const;
  std::uint64_t SearchHost();
  void OnMachines(const std::vector<MachineHere>& machines);
  void DropOldestStop();
  void AnswerStop(EstopCall& stop, const EstopReport& report, const std::string& why_early = "");
  EstopReport ReportOf(const EstopCall& stop) const;
  void LookAtStops();

  transport::Node& node_;
  const Options options_;
  const Leader leader_;
  MessageJson json_;
  std::map<std::string, std::shared_ptr<void>> clients_;  // of the controller's services
  std::map<std::string, std::unique_ptr<transport::Client<msg::GetBehavior>>> behaviors_;
  std::map<std::string, std::unique_ptr<transport::Client<msg::GetTree>>> trees_;
  std::list<Switch> switches_;
  std::list<RestartCall> restarts_;
  std::optional<std::vector<MachineIdentity>> own_;  // of this host; nullopt: not searched yet
  std::uint64_t searches_ = 0;                       // begun
  bool searching_ = false;
  bool search_again_ = false;
  std::list<EstopCall> stops_;
  transport::LoopHandlePtr stop_timer_;  // while there are stops
};

}  // namespace musher::view
