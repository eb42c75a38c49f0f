#include "musher/view/live/robot_requests.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/view/http/reply.hpp"
#include "musher/view/live/machine_feed.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view {
namespace {

constexpr Duration kStopPeriod = Milliseconds(50);
constexpr Duration kStopKept = std::chrono::minutes(1);  // as by `musher estop`
constexpr const char* kNotOnDisk =                       // as it says
    "not on disk: no controller leads that saves it; the stop is lost if the actuators end; it "
    "stays published for a minute";

void RespondJson(const http::Respond& respond, std::string json) {
  http::Response response;
  response.body = std::make_shared<const std::string>(std::move(json));
  respond(std::move(response));
}

void RespondCode(const http::Respond& respond, std::int32_t code, const std::string& reason) {
  RespondJson(respond, R"({"code":)" + std::to_string(code) + R"(,"reason":)" +
                           http::JsonText(reason) + "}");
}

// "musher_msgs::srv::dds_::GetPlan_" gives "musher_msgs::srv::dds_::GetPlan_Response_".
template <msg::Service S>
std::string ResponseType() {
  return std::string(S::kTypeName) + "Response_";
}

// `searched`: what this host has of the machine is known.
std::string NotStopped(const EstopReport& report, bool searched) {
  std::string sentence = WhyNotStopped(report);
  // The list of a controller needs no search.
  if (report.controller || searched) return sentence;
  return sentence + (sentence.empty() ? "" : "; ") +
         "this host is still being searched for its actuators";
}

// The requester, as status and history have it.
std::string OnPage(const RobotRequests::Caller& caller) {
  return caller.by + " on the page";
}

std::vector<MachineIdentity> NamedOf(const std::vector<MachineHere>& machines) {
  std::vector<MachineIdentity> named;
  for (const MachineHere& machine : machines) {
    if (!machine.identity.name.empty()) named.push_back(machine.identity);
  }
  return named;
}

Error DoesNotRun(const MachineIdentity& own, const MachineIdentity& found) {
  const std::string word = own.name == found.name ? "ID" : "NAME";
  return {kCodeNetError, "the machine of this host, " + MachineText(own) +
                             ", does not run; found " + MachineText(found) +
                             ". Nothing was done; `musher view --machine " + word +
                             "` speaks to another machine"};
}

bool IsIn(const std::vector<MachineIdentity>& machines, const MachineIdentity& machine) {
  return std::ranges::any_of(machines, [&](const auto& one) { return SameMachine(one, machine); });
}

}  // namespace

RobotRequests::RobotRequests(transport::Node& node, Options options, Leader leader)
    : node_(node), options_(std::move(options)), leader_(std::move(leader)) {
  if (!options_.find) own_ = NamedOf(options_.stops.machines);
  SearchHost();
}

template <msg::Service S>
void RobotRequests::Answer(const http::Respond& respond, const typename S::Response& response) {
  auto text = json_.ToJson(ResponseType<S>(), transport::internal::EncodeEnvelope({}, response));
  if (!text) return respond(http::ErrorResponse(500, text.error().code, text.error().message));
  RespondJson(respond, std::move(text).value());
}

LeaderWatch::Options RobotRequests::LeaderOptions() {
  LeaderWatch::Options leader{options_.name_space, options_.host, WatchByPidfd(node_.loop())};
  leader.machine = leader_().machine();
  return leader;
}

bool RobotRequests::HasController(const http::Respond& respond) {
  if (status()) return true;
  respond(http::ErrorResponse(503, kCodeNetError, "no controller leads the machine"));
  return false;
}

std::optional<Error> RobotRequests::WhyNotMeant() const {
  const LeaderWatch& watch = leader_();
  if (watch.found_here()) return std::nullopt;
  const bool named = !options_.machine.empty();
  const std::string& name = named ? options_.machine : watch.machine().name;
  std::vector<MachineIdentity> alike = watch.candidates();
  if (!named) std::erase_if(alike, [&](const auto& one) { return one.name != name; });
  if (alike.size() > 1) {
    std::string list;
    for (const MachineIdentity& one : alike) list += (list.empty() ? "" : "; ") + MachineText(one);
    return Error{kCodeTargetBusy, "several machines are named " + name + ": " + list +
                                      ". Nothing was done; `musher view --machine ID` speaks to "
                                      "one of them"};
  }
  if (named) {
    // A copy of the machine of this host has its name, and is found first while that one starts.
    const auto own = own_.value_or(std::vector<MachineIdentity>());
    const auto alike_here = std::ranges::find(own, name, &MachineIdentity::name);
    if (alike_here == own.end() || IsIn(own, watch.machine())) return std::nullopt;
    return DoesNotRun(*alike_here, watch.machine());
  }
  if (!own_) {
    return Error{kCodeNetError,
                 "this host is still being searched for a machine of its own. Nothing was done; "
                 "try again, or `musher view --machine NAME` speaks to another machine"};
  }
  if (IsIn(*own_, watch.machine())) return std::nullopt;
  if (options_.places && options_.name_space.empty()) {
    const std::string why =
        WhyNotFrom(own_place(), options_.places(), MachineText(watch.machine()));
    if (!why.empty()) {
      return Error{kCodeNetError, why + "; `musher view --namespace` chooses its namespace"};
    }
  }
  if (own_->empty()) return std::nullopt;
  return DoesNotRun(own_->front(), watch.machine());
}

bool RobotRequests::IsMeant(const Caller& caller, const http::Respond& respond) const {
  std::optional<Error> why = WhyNotMeant();
  const MachineIdentity& machine = leader_().machine();
  if (!why && !SameMachine(caller.shown, machine)) {
    why = Error{kCodeTargetBusy, "the page shows " + MachineText(caller.shown) + ", but " +
                                     MachineText(machine) +
                                     " is followed now. Nothing was done; look at the page again"};
  }
  if (why) respond(http::ErrorResponse(409, why->code, why->message));
  return !why;
}

bool RobotRequests::HasActuator(const std::string& actuator, const http::Respond& respond) {
  if (!HasController(respond)) return false;
  const auto& actuators = status()->actuators;
  const bool known = std::any_of(actuators.begin(), actuators.end(),
                                 [&](const auto& each) { return each.name == actuator; });
  if (known) return true;
  respond(http::ErrorResponse(404, kCodeParametersInvalid,
                              "the machine has no actuator '" + actuator + "'"));
  return false;
}

template <msg::Service S>
void RobotRequests::Call(const std::string& service, const typename S::Request& request,
                         Duration timeout, const http::Respond& respond) {
  if (!HasController(respond)) return;
  typename S::Request meant = request;
  meant.machine = leader_().machine().name;
  meant.machine_id = leader_().machine().id;
  std::shared_ptr<void>& kept = clients_[service];
  if (!kept) {
    auto made =
        transport::MakeClient<S>(node_, transport::MachineService(options_.name_space, service));
    if (!made) return respond(http::ErrorResponse(500, made.error().code, made.error().message));
    kept = std::shared_ptr<transport::Client<S>>(std::move(made).value());
  }
  static_cast<transport::Client<S>*>(kept.get())
      ->Call(
          meant, timeout,
          [this, respond](const Result<typename S::Response>& answer) {
            if (answer) return Answer<S>(respond, answer.value());
            respond(
                http::ErrorResponse(504, answer.error().code,
                                    "the controller has not answered: " + answer.error().message));
          },
          leader_().participant());
}

void RobotRequests::Plan(const std::string& target, const std::string& actuator,
                         const http::Respond& respond) {
  Call<msg::GetPlan>("get_plan", {target, actuator}, kAnswerTime, respond);
}

void RobotRequests::Set(const Caller& caller, const std::string& target,
                        const std::string& actuator, const http::Respond& respond) {
  if (!HasController(respond) || !IsMeant(caller, respond)) return;
  std::erase_if(switches_, [](const Switch& each) { return each.ended; });
  SwitchClient::Options options;
  options.leader = LeaderOptions();
  options.by = OnPage(caller);
  options.timeout = kSwitchTime;
  options.find = kAnswerTime;
  Switch& one = switches_.emplace_back();
  auto client = SwitchClient::Make(
      node_, options, target, actuator, [](const std::string&) {},
      [this, &one, respond](const SwitchEnd& end) {
        one.ended = true;
        if (end.kind != SwitchEnd::Kind::kUnknown) {
          return Answer<msg::SetState>(respond, end.result);
        }
        respond(http::ErrorResponse(504, end.result.code, end.result.reason));
      });
  if (!client) {
    switches_.pop_back();
    return respond(http::ErrorResponse(500, client.error().code, client.error().message));
  }
  one.client = std::move(client).value();
}

void RobotRequests::Restart(const Caller& caller, const std::string& actuator,
                            const http::Respond& respond) {
  if (!HasController(respond) || !IsMeant(caller, respond)) return;
  if (!HasActuator(actuator, respond)) return;
  std::erase_if(restarts_, [](const RestartCall& each) { return each.ended; });
  RestartCall& one = restarts_.emplace_back();
  auto call = LeaderCall<msg::RestartActuator>::Make(
      node_, LeaderOptions(), "restart_actuator", {actuator, OnPage(caller)}, kRestartTime,
      [this, &one, respond](const Result<msg::RestartActuator::Response>& answer) {
        one.ended = true;
        if (answer) return Answer<msg::RestartActuator>(respond, answer.value());
        respond(http::ErrorResponse(504, answer.error().code, answer.error().message));
      });
  if (!call) {
    restarts_.pop_back();
    return respond(http::ErrorResponse(500, call.error().code, call.error().message));
  }
  one.call = std::move(call).value();
}

void RobotRequests::Release(const Caller& caller, const std::vector<std::string>& seen,
                            const http::Respond& respond) {
  if (!HasController(respond) || !IsMeant(caller, respond)) return;
  msg::ReleaseEmergencyStop::Request request;
  request.by = OnPage(caller);
  request.seen_stops = seen;
  Call<msg::ReleaseEmergencyStop>("release_emergency_stop", request, kAnswerTime, respond);
}

// Whether an actuator runs on this host that the followed machine, of another host, does not list.
bool RobotRequests::HasActuatorsOfAnother() const {
  if (leader_().found_here()) return false;
  const auto is_listed = [this](const std::string& name) {
    return status() && std::ranges::any_of(status()->actuators, [&](const msg::ActuatorInfo& one) {
             return one.name == name && one.host == options_.host;
           });
  };
  const StopScope& scope = options_.stops;
  return !std::ranges::all_of(
      NameLock::HeldBelow(NameLock::NameOf(scope.domain_id, scope.name_space, "")), is_listed);
}

// The machine that is followed, by its name while it does not answer, and the one on the page.
// Where another one may be meant, every machine that the word of the person may mean.
RobotRequests::StopAddress RobotRequests::AddressOfStop(const MachineIdentity& shown) const {
  const LeaderWatch& watch = leader_();
  const std::string& word = options_.machine;
  StopAddress address{watch.machine()};
  const bool by_id = BeginsIdOf(address.machine, word);
  if (!status() && !watch.found_here() && !by_id) address.machine.id.clear();
  if (WhyNotMeant() || HasActuatorsOfAnother()) address.machine = {word, ""};
  if (!word.empty() && address.machine.id.empty()) {
    address.id_begins = word;
    address.by_id = watch.candidates();
    for (const MachineIdentity& one : own_.value_or(std::vector<MachineIdentity>())) {
      address.by_id.push_back(one);
    }
  }
  if (SameMachine(address.machine, shown) || BeginsIdOf(shown, address.id_begins)) return address;
  // The server follows another machine than before: it was started again.
  if (!address.id_begins.empty() || !BeginsIdOf(shown, shown.id)) return {};
  address.id_begins = shown.id;
  address.by_id = {shown};
  return address;
}

void RobotRequests::Stop(const Caller& caller, const std::string& reason,
                         const http::Respond& respond) {
  const StopAddress address = AddressOfStop(caller.shown);
  msg::EmergencyStop stop = NewEmergencyStop(caller.by, reason);
  stop.machine = address.machine.name;
  stop.machine_id = address.machine.id;
  auto latch = StopLatch::Begin(node_, options_.name_space, stop,
                                {options_.with_keys, options_.stops.lan, {}, {}});
  if (!latch) {
    return respond(http::ErrorResponse(
        500, latch.error().code, "the emergency stop could not be sent: " + latch.error().message));
  }
  if (!address.id_begins.empty()) {
    latch.value()->AddBeginningOfId(address.id_begins, address.by_id);
  }
  if (stops_.size() >= kMostStops) DropOldestStop();
  const Time now = node_.loop().Now();
  EstopCall& stopping = stops_.emplace_back();
  stopping.latch = std::move(latch).value();
  stopping.respond = respond;
  stopping.answer_by = now + kStopTime;
  stopping.drop_at = now + kStopKept;
  stopping.scope = options_.stops;
  stopping.address = address;
  StopBeside::Options beside{own_place(), options_.host, options_.machine, options_.with_keys,
                             options_.stops.lan};
  for (const MachinePlace& place : PlacesBeside()) {
    stopping.beside.push_back(std::make_unique<StopBeside>(node_, place, stop, beside));
  }
  stopping.searched = !options_.find;
  stopping.search = SearchHost();  // after the stop is published
  if (!stop_timer_) stop_timer_ = node_.loop().Every(kStopPeriod, [this] { LookAtStops(); });
}

// Where machines of this host run that may be meant beside that of the page's namespace. In the
// page's domain: of another one only the disk says whether it is a robot.
std::vector<MachinePlace> RobotRequests::PlacesBeside() const {
  if (!options_.places) return {};
  const MeantPlace meant{own_place(), !options_.name_space.empty(), /*names_domain=*/true};
  std::vector<MachinePlace> places =
      PlacesToStop(meant, options_.places(), [](const MachinePlace&) { return false; });
  if (options_.machine.empty()) return places;
  std::erase_if(places, [this](const MachinePlace& place) {
    const auto origin = OriginHere(place.domain, place.name_space);
    return !origin || (origin->name != options_.machine &&
                       !BeginsIdOf({origin->name, origin->id}, options_.machine));
  });
  return places;
}

// One that was answered, if there is one: a later one has reached what runs, and stays published.
void RobotRequests::DropOldestStop() {
  auto oldest = std::ranges::find_if(stops_, [](const EstopCall& stop) { return !stop.respond; });
  if (oldest == stops_.end()) {
    oldest = stops_.begin();
    AnswerStop(*oldest, ReportOf(*oldest), "too many stops were sent at once");
  }
  stops_.erase(oldest);
}

// The number of a search that begins after this call: now, or after the one that is under way.
std::uint64_t RobotRequests::SearchHost() {
  if (!options_.find) return 0;
  search_again_ |= searching_;
  if (searching_) return searches_ + 1;
  searching_ = true;
  ++searches_;
  options_.find([this](const std::vector<MachineHere>& machines) { OnMachines(machines); });
  return searches_;
}

void RobotRequests::OnMachines(const std::vector<MachineHere>& machines) {
  searching_ = false;
  own_ = NamedOf(machines);
  for (EstopCall& stop : stops_) {
    if (stop.searched || stop.search > searches_) continue;
    stop.searched = true;
    stop.scope.machines = machines;
  }
  if (std::exchange(search_again_, false)) SearchHost();
  LookAtStops();
}

void RobotRequests::OnStatus() {
  LookAtStops();
}

EstopReport RobotRequests::ReportOf(const EstopCall& stop) const {
  // Meanwhile another machine may be followed.
  const MachineIdentity& machine = leader_().machine();
  const bool is_its = status() && (SameMachine(stop.address.machine, machine) ||
                                   BeginsIdOf(machine, stop.address.id_begins));
  return stop.latch->Report(
      ViewFromHere(stop.scope, is_its ? status() : std::optional<msg::MachineStatus>()));
}

void RobotRequests::AnswerStop(EstopCall& stop, const EstopReport& report,
                               const std::string& why_early) {
  const http::Respond respond = std::exchange(stop.respond, nullptr);
  std::string missing = NotStopped(report, stop.searched);
  const bool only_beside = !report.found() && !stop.beside.empty();
  if (only_beside) missing.clear();
  const auto add = [&missing](const std::string& more) {
    if (!more.empty()) missing += (missing.empty() ? "" : "; ") + more;
  };
  for (const auto& beside : stop.beside) add(beside->WhyNot());
  add(why_early);
  if (!report.found() && !only_beside) {
    respond(http::ErrorResponse(503, kCodeNetError,
                                "neither a controller nor an actuator was there to stop"));
  } else if (!missing.empty()) {
    RespondCode(respond, kCodeFailed, missing);
  } else {
    RespondCode(respond, kCodeOk, report.controller || only_beside ? "" : kNotOnDisk);
  }
}

void RobotRequests::LookAtStops() {
  const Time now = node_.loop().Now();
  for (EstopCall& stop : stops_) {
    if (!stop.respond) continue;
    const EstopReport report = ReportOf(stop);
    const bool known = report.controller || stop.searched;
    const bool over = now >= stop.answer_by;
    const bool is_done = known && report.found() && stop.latch->IsOver(report) &&
                         std::ranges::all_of(stop.beside, [](const auto& beside) {
                           return beside->WhyNot().empty();
                         });
    if (over || is_done) AnswerStop(stop, report);
  }
  std::erase_if(stops_, [now](const EstopCall& stop) { return now >= stop.drop_at; });
  if (stops_.empty()) stop_timer_.reset();
}

void RobotRequests::History(std::uint32_t limit, const http::Respond& respond) {
  if (!HasController(respond)) return;
  std::shared_ptr<void>& kept = clients_["get_history"];
  if (!kept) {
    auto made = transport::MakeClient<msg::GetHistory>(
        node_, transport::MachineService(options_.name_space, "get_history"));
    if (!made) return respond(http::ErrorResponse(500, made.error().code, made.error().message));
    kept = std::shared_ptr<transport::Client<msg::GetHistory>>(std::move(made).value());
  }
  static_cast<transport::Client<msg::GetHistory>*>(kept.get())
      ->Call(
          {0, limit, leader_().machine().name, leader_().machine().id}, kAnswerTime,
          [respond](const Result<msg::GetHistory::Response>& answer) {
            if (!answer) {
              return respond(http::ErrorResponse(504, answer.error().code, answer.error().message));
            }
            const msg::GetHistory::Response& history = answer.value();
            std::string text = R"({"error":)" + http::JsonText(history.error) + R"(,"entries":[)";
            for (std::size_t i = 0; i < history.entries.size(); ++i) {
              const bool named = i < history.events.size();
              text += (i > 0 ? "," : "") +
                      EntryJson(history.entries[i], named ? history.events[i] : "");
            }
            RespondJson(respond, text + "]}");
          },
          leader_().participant());
}

template <msg::Service S>
void RobotRequests::CallApplication(
    std::map<std::string, std::unique_ptr<transport::Client<S>>>& clients,
    const std::string& actuator, const std::string& service, const typename S::Request& request,
    const http::Respond& respond) {
  if (!HasActuator(actuator, respond)) return;
  auto& client = clients[actuator];
  if (!client) {
    auto made = transport::MakeClient<S>(
        node_, transport::ResolveName(options_.name_space, actuator + "/" + service));
    if (!made) return respond(http::ErrorResponse(500, made.error().code, made.error().message));
    client = std::move(made).value();
  }
  client->Call(request, kAnswerTime,
               [this, actuator, service, respond](const Result<typename S::Response>& answer) {
                 if (answer) return Answer<S>(respond, answer.value());
                 respond(http::ErrorResponse(
                     404, answer.error().code,
                     actuator + " does not answer " + service + ": " + answer.error().message));
               });
}

void RobotRequests::Behavior(const std::string& actuator, const std::string& format,
                             const http::Respond& respond) {
  CallApplication<msg::GetBehavior>(behaviors_, actuator, "get_behavior", {format, 50}, respond);
}

void RobotRequests::Tree(const std::string& actuator, const http::Respond& respond) {
  CallApplication<msg::GetTree>(trees_, actuator, "get_tree", {}, respond);
}

}  // namespace musher::view
