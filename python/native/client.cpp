#include "musher/python/native/client.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <string_view>
#include <system_error>
#include <thread>

#include "musher/base/host.hpp"
#include "musher/controller/client/detached_publisher.hpp"
#include "musher/controller/client/leader_call.hpp"
#include "musher/controller/client/stop_latch.hpp"
#include "musher/controller/client/switch_client.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/controller/storage/machine_places.hpp"
#include "musher/controller/storage/machines_here.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/python/native/node.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::python {
namespace {

enum SwitchKind : int { kSwitchNews, kSwitchEnd };  // of items; musher/_machine.py has the same

// A requested switch; its outcome goes into the mailbox: a SetState.Response in bytes, and how it
// is known.
class Switch : public OnLoop<SwitchClient> {
 public:
  Switch(const PyNodePtr& node, const std::string& target, const std::string& actuator,
         const std::string& by, double timeout_s, double find_s, const MailboxPtr& mailbox,
         const std::string& machine, const std::string& machine_id)
      : OnLoop(node, [&](transport::Node& on) {
          SwitchClient::Options options;
          options.leader = {node->name_space, HostId(), WatchByPidfd(on.loop())};
          options.leader.machine = {machine, machine_id};
          options.by = by;
          options.timeout = Seconds(timeout_s);
          options.find = Seconds(find_s);
          return SwitchClient::Make(
              on, options, target, actuator,
              [mailbox](const std::string& news) {
                Item item;
                item.kind = kSwitchNews;
                item.text = news;
                mailbox->Push(std::move(item));
              },
              [mailbox](const SwitchEnd& end) {
                Item item;
                item.kind = kSwitchEnd;
                item.code = static_cast<std::int32_t>(end.kind);
                item.bytes = msg::Encode(end.result);
                mailbox->Push(std::move(item));
              });
        }) {}
};

// A requested restart of an actuator; its end goes into the mailbox: a RestartActuator.Response in
// bytes, or why there is none.
class Restart : public OnLoop<LeaderCall<msg::RestartActuator>> {
 public:
  Restart(const PyNodePtr& node, const std::string& actuator, const std::string& by,
          double timeout_s, const MailboxPtr& mailbox, const std::string& machine,
          const std::string& machine_id)
      : OnLoop(node, [&](transport::Node& on) {
          LeaderWatch::Options leader{node->name_space, HostId(), WatchByPidfd(on.loop())};
          leader.machine = {machine, machine_id};
          return LeaderCall<msg::RestartActuator>::Make(
              on, std::move(leader), "restart_actuator", {actuator, by}, Seconds(timeout_s),
              [mailbox](const Result<msg::RestartActuator::Response>& answer) {
                Item item;
                if (answer) {
                  item.bytes = msg::Encode(answer.value());
                } else {
                  item.code = answer.error().code;
                  item.text = answer.error().message;
                }
                mailbox->Push(std::move(item));
              });
        }) {}

  bool Found() {
    bool found = false;
    Run([&](LeaderCall<msg::RestartActuator>& call) { found = call.found(); });
    return found;
  }
};

// What an emergency stop needs on the loop.
struct EngagedStop {
  transport::Node& node;
  LeaderWatch::Options of_leader;
  std::function<void()> on_change;
  std::unique_ptr<DetachedPublisher> publisher;  // null: the stop ends with this program
  std::unique_ptr<StopLatch> latch;
  std::unique_ptr<LeaderWatch> leader;  // null: the status of a controller is not received

  // Where it may not be received, the stop holds and is not confirmed by a controller.
  void Follow(const MachineIdentity& machine) {
    leader = nullptr;
    of_leader.machine = machine;
    auto watch = LeaderWatch::Make(
        node, of_leader, [this](const msg::MachineStatus&) { on_change(); },
        [this](const msg::MachineStatus&, const std::string&) { on_change(); });
    if (watch) leader = std::move(watch).value();
  }
};

// The search for the machines of this host. It reads the disk and other processes, and one that
// hangs may hold it up for ever: it has a thread of its own, which an emergency stop does not wait
// for.
class MachineSearch {
 public:
  // `on_end` runs on that thread.
  static std::shared_ptr<MachineSearch> Begin(StopScope scope, std::vector<std::string> configs,
                                              std::function<void()> on_end) {
    auto search = std::make_shared<MachineSearch>();
    auto run = [search, scope = std::move(scope), configs = std::move(configs),
                on_end = std::move(on_end)] {
      try {
        auto found = MachinesHere(scope.domain_id, scope.name_space, configs);
        const std::lock_guard lock(search->mutex_);
        search->found_ = std::move(found);
      } catch (const std::exception&) {
        // What this host has stays unknown.
      }
      on_end();
      Count(-1);
    };
    Count(1);
    try {
      std::thread(run).detach();
    } catch (const std::system_error&) {
      WithoutGil(run);  // no thread is left
    }
    return search;
  }
  // Nullopt: it goes on.
  std::optional<std::vector<MachineHere>> found() const {
    const std::lock_guard lock(mutex_);
    return found_;
  }

  // Before the program ends, and with it what a search uses: waits for them, not long for one that
  // hangs.
  static void AwaitAll() {
    RunningCount& running = AllRunning();
    std::unique_lock lock(running.mutex);
    running.changed.wait_for(lock, std::chrono::seconds(1), [&] { return running.count == 0; });
  }

 private:
  struct RunningCount {
    std::mutex mutex;
    std::condition_variable changed;
    int count = 0;
  };
  static RunningCount& AllRunning() {
    static RunningCount& running =
        *std::make_unique<RunningCount>().release();  // outlives each search
    return running;
  }
  static void Count(int change) {
    RunningCount& running = AllRunning();
    const std::lock_guard lock(running.mutex);
    running.count += change;
    running.changed.notify_all();
  }

  mutable std::mutex mutex_;
  std::optional<std::vector<MachineHere>> found_;  // guarded by it
};

std::string HexOf(const msg::Bytes& bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (const std::byte byte : bytes) {
    text += kDigits[std::to_integer<std::size_t>(byte >> 4U)];
    text += kDigits[std::to_integer<std::size_t>(byte & std::byte{15})];
  }
  return text;
}

msg::Bytes BytesOf(const std::string& hex) {
  msg::Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

// A stop to engage, before it is known which machine is meant.
struct NewStop {
  msg::EmergencyStop message;

  // To the controller of this host, which publishes it.
  void HandOver(const std::string& name_space, std::optional<int> domain,
                const std::string& word) const {
    transport::DdsOptions options;
    options.domain_id = domain;
    const auto id = transport::DomainId(options);
    if (!id) return;
    msg::EmergencyStop here = message;
    here.machine = word;
    HandOverStop(here, id.value(), name_space);
  }
};

// An emergency stop that is published as long as this exists, and a minute longer by a process of
// its own, unless it is released or confirmed.
class Stop : public OnLoop<EngagedStop> {
 public:
  // An item goes into the mailbox when the report has changed. `config`: the machine's, if the
  // program knows it. `word`: the name that was given, which may be the beginning of an id; may be
  // empty.
  Stop(const PyNodePtr& node, const NewStop& begun, const MailboxPtr& mailbox,
       const std::string& machine, const std::string& machine_id, std::optional<int> domain,
       const std::string& config, const std::string& word)
      : OnLoop(node,
               [&](transport::Node& on) -> Result<std::unique_ptr<EngagedStop>> {
                 msg::EmergencyStop stop = begun.message;
                 stop.machine = machine;
                 stop.machine_id = machine_id;
                 const auto on_change = [mailbox] { mailbox->PushLatest({}); };
                 auto latch = StopLatch::Begin(on, node->name_space, stop,
                                               {node->thread->credentials().has_value(),
                                                transport::ReachesOtherHosts(),
                                                on_change,
                                                {}});
                 if (!latch) return latch.error();
                 if (!word.empty()) latch.value()->AddBeginningOfId(word);
                 auto engaged = std::make_unique<EngagedStop>(
                     EngagedStop{on,
                                 {node->name_space, HostId(), WatchByPidfd(on.loop())},
                                 on_change,
                                 nullptr,
                                 std::move(latch).value(),
                                 nullptr});
                 engaged->Follow({machine, machine_id});
                 return engaged;
               }),
        message_(begun.message),
        word_(word) {
    message_.machine = machine;
    message_.machine_id = machine_id;
    transport::DdsOptions options;
    options.domain_id = domain;
    const auto id = transport::DomainId(options);
    scope_ = {node->name_space, id ? id.value() : 0, transport::ReachesOtherHosts()};
    std::vector<std::string> configs;
    if (!config.empty()) configs.push_back(config);
    search_ =
        MachineSearch::Begin(scope_, std::move(configs), [mailbox] { mailbox->PushLatest({}); });
  }

  // Which actuators are stopped: (there is nothing to wait for any more, a controller leads,
  // [(name, stopped, after_s, trouble)], why there may be more of them or this stop does not hold
  // them, else "", why the controller has not saved the stop, else "").
  using Actuators = std::vector<std::tuple<std::string, bool, double, std::string>>;
  std::tuple<bool, bool, Actuators, std::string, std::string> Report() {
    if (auto found = search_ ? search_->found() : std::nullopt) {
      scope_.machines = *std::move(found);
      search_ = nullptr;
      StopByFiles();
    }
    EstopReport report;
    bool over = false;
    Run([&](EngagedStop& stop) {
      report = stop.latch->Report(
          ViewFromHere(scope_, stop.leader ? stop.leader->leader() : std::nullopt));
      over = stop.latch->IsOver(report);
    });
    // A controller has all of its actuators in its status.
    if (search_ && !report.controller) {
      over = false;
      report.unknown = "this host is still being searched";
    }
    if (report.unknown.empty()) report.unknown = report.WhyNotHeld();
    Actuators actuators;
    if (!report.found()) return {over, report.controller, {}, report.unknown, ""};
    for (const EstopReport::Actuator& one : report.actuators) {
      actuators.emplace_back(one.name, one.stopped,
                             std::chrono::duration<double>(one.after).count(), one.trouble);
    }
    return {over, report.controller, std::move(actuators), report.unknown, report.not_on_disk};
  }
  bool Searches() const { return search_ != nullptr; }
  // From now on another process publishes the stop for a minute once this object or this process
  // has ended. `program`: calls publish_stop(); it gets the stop as its last arguments.
  void PublishAfterEnd(std::vector<std::string> program) {
    program.insert(program.end(), {std::to_string(getpid()), word_, HexOf(msg::Encode(message_))});
    Run([&](EngagedStop& stop) {
      stop.publisher = std::make_unique<DetachedPublisher>(program);
      stop.latch->ContinueWith(*stop.publisher);
    });
  }
  // Every actuator has confirmed it, or it is released.
  void Confirm() {
    Run([](EngagedStop& stop) {
      if (stop.publisher) stop.publisher->Cancel();
    });
  }
  // A controller of each machine that has it has released it: it is published no longer.
  bool Withdrawn() {
    bool withdrawn = false;
    Run([&](EngagedStop& stop) { withdrawn = stop.latch->withdrawn(); });
    return withdrawn;
  }
  // It names a machine: a release withdraws it at once.
  bool NamesMachine() const { return !message_.machine.empty(); }
  // Whether a machine that releases the stops with these ids releases it as a whole: it is for no
  // other machine. One by a name is for each robot of that name that was found.
  bool IsOneOf(const std::vector<std::string>& ids) {
    bool is_for_one = false;
    Run([&](EngagedStop& stop) { is_for_one = stop.latch->IsForOneMachine(); });
    return NamesMachine() && is_for_one &&
           std::ranges::count(ids, transport::StopIdText(StopId(message_.id))) != 0;
  }
  pid_t PublisherPid() {
    pid_t pid = 0;
    Run([&](EngagedStop& stop) { pid = stop.publisher ? stop.publisher->pid() : 0; });
    return pid;
  }
  // The controller of this machine confirms it, where only the beginning of its id was given.
  void Follow(const std::string& machine, const std::string& machine_id) {
    Run([&](EngagedStop& stop) { stop.Follow({machine, machine_id}); });
  }

 private:
  // Those of this host whose id begins with the given word.
  void StopByFiles() {
    std::vector<MachineIdentity> by_id;
    for (const MachineHere& machine : scope_.machines) {
      if (BeginsIdOf(machine.identity, word_)) by_id.push_back(machine.identity);
    }
    if (by_id.empty()) return;
    Run([&](EngagedStop& stop) { stop.latch->AddBeginningOfId(word_, by_id); });
  }

  msg::EmergencyStop message_;  // as it is published
  const std::string word_;
  StopScope scope_;
  std::shared_ptr<MachineSearch> search_;  // null: it has ended
};

// For the program of a DetachedPublisher. `engaged`: what Stop::PublishAfterEnd() has added to it.
void PublishStop(const std::string& name_space, const std::string& domain, const std::string& keys,
                 const std::string& identity, const std::string& interface, pid_t parent,
                 const std::string& word, const std::string& engaged) {
  const auto stop = msg::Decode<msg::EmergencyStop>(BytesOf(engaged));
  if (!stop) throw py::value_error("no stop: " + engaged);
  const auto id = domain.empty() ? std::nullopt : std::optional(std::stoi(domain));
  const auto publish = [&](const DetachedPublisher::Notes& notes) {
    const PyNodePtr node = MakeNode("", name_space, id, keys, identity, interface);
    OnLoop<StopLatch> latch(node, [&](transport::Node& on) {
      auto begun = StopLatch::Begin(on, name_space, stop.value(),
                                    {!keys.empty(), transport::ReachesOtherHosts(), {}, notes});
      if (begun && !word.empty()) begun.value()->AddBeginningOfId(word);
      return begun;
    });
    constexpr Duration kLook = Milliseconds(100);
    bool released = false;
    for (Duration left = DetachedPublisher::kKeptPublished; left > Duration{} && !released;
         left -= kLook) {
      latch.Run([&](StopLatch& published) { released = published.withdrawn(); });
      WithoutGil([&] { node->thread->WaitFor(kLook); });
    }
    _exit(released ? 0 : 1);  // DDS waits for ever to leave a network that is lost
  };
  const auto try_to_publish = [&](const DetachedPublisher::Notes& notes) -> bool {
    try {
      publish(notes);
    } catch (const std::exception&) {
      // The network cannot be joined now.
    }
    return false;
  };
  DetachedPublisher::PublishWhenAsked(STDIN_FILENO, parent, std::nullopt, try_to_publish);
}

// (namespace, name) of a valid config.
std::pair<std::string, std::string> ReadMachine(const std::string& file) {
  const auto config = ReadValidConfig(file);
  if (!config) Raise("ConfigError", config.error());
  return {config.value().name_space, config.value().name};
}

std::optional<int> DomainOf(std::optional<int> domain) {
  transport::DdsOptions options;
  options.domain_id = domain;
  const auto id = transport::DomainId(options);
  return id ? std::optional(id.value()) : std::nullopt;
}

// (name, id) of the machine whose controller runs on this host; empty: none, or one of another
// user.
std::pair<std::string, std::string> FindMachineHere(const std::string& name_space,
                                                    std::optional<int> domain) {
  const auto origin = WithoutGil([&]() -> std::optional<MachineOrigin> {
    const auto id = DomainOf(domain);
    return id ? OriginHere(*id, name_space) : std::nullopt;
  });
  if (!origin) return {};
  return {origin->name, origin->id};
}

// The name that the controller of this host holds.
std::optional<std::string> ControllerName(const std::string& name_space,
                                          std::optional<int> domain) {
  const auto id = DomainOf(domain);
  if (!id) return std::nullopt;
  return NameLock::NameOf(*id, name_space, "musher/controller");
}

// Whether a controller of this host leads, also one of another user. It inspects no process.
bool LeadsHere(const std::string& name_space, std::optional<int> domain) {
  const auto name = ControllerName(name_space, domain);
  return name && NameLock::IsHeld(*name);
}

// The process of that controller; 0: none, or one of another user.
pid_t LeaderHere(const std::string& name_space, std::optional<int> domain) {
  const auto name = ControllerName(name_space, domain);
  return name ? WithoutGil([&] { return NameLock::HolderOf(*name).pid; }) : 0;
}

// Whether a controller or an actuator of any machine runs on this host.
bool RunsHere(const std::string& name_space, std::optional<int> domain) {
  const auto id = DomainOf(domain);
  return LeadsHere(name_space, domain) ||
         (id && !NameLock::HeldBelow(NameLock::NameOf(*id, name_space, "")).empty());
}

// (name, id) of each machine that has files or processes on this host.
std::vector<std::pair<std::string, std::string>> FindMachinesHere(const std::string& name_space,
                                                                  std::optional<int> domain) {
  std::vector<std::pair<std::string, std::string>> found;
  const auto id = DomainOf(domain);
  if (!id) return found;
  const auto machines = WithoutGil([&] { return MachinesHere(*id, name_space); });
  for (const MachineHere& machine : machines) {
    if (machine.identity.name.empty()) continue;
    found.emplace_back(machine.identity.name, machine.identity.id);
  }
  return found;
}

// Why a program without a name or a namespace acts on none of another host; "": it may.
std::string WhyNotHere(const std::string& found, std::optional<int> domain) {
  const auto id = DomainOf(domain);
  if (!id) return "";
  return WithoutGil([&] { return WhyNotFrom({*id, ""}, PlacesHere(), found); });
}

// (domain, namespace) of each machine of this host that a stop without an express name has to reach
// beside its own.
std::vector<std::pair<int, std::string>> PlacesBeside(const std::string& name_space,
                                                      std::optional<int> domain,
                                                      bool names_namespace) {
  std::vector<std::pair<int, std::string>> beside;
  const auto id = DomainOf(domain);
  if (!id) return beside;
  const MeantPlace meant{{*id, name_space}, names_namespace, domain.has_value()};
  const auto places = WithoutGil([&] {
    return PlacesToStop(meant, PlacesHere(), [](const MachinePlace& place) {
      return HasFolder(MachineFolders(), place);
    });
  });
  for (const MachinePlace& place : places) beside.emplace_back(place.domain, place.name_space);
  return beside;
}

// "namespace 'dogA'", with the domain where it is another one than the caller's.
std::string PlaceText(int domain, const std::string& name_space, std::optional<int> own_domain) {
  return MachinePlace{domain, name_space}.Text(DomainOf(own_domain).value_or(domain));
}

}  // namespace

void AddClient(py::module_& native) {
  py::module_::import("atexit").attr("register")(
      py::cpp_function([] { WithoutGil([] { MachineSearch::AwaitAll(); }); }));
  native.def("read_machine", &ReadMachine);
  native.def("machine_here", &FindMachineHere);
  native.def("machines_here", &FindMachinesHere);
  native.def("why_not_here", &WhyNotHere);
  native.def("places_to_stop", &PlacesBeside);
  native.def("place_text", &PlaceText);
  native.def("host_id", &HostId);
  native.def("leads_here", &LeadsHere);
  native.def("leader_here", &LeaderHere);
  native.def("runs_here", &RunsHere);
  native.def("machine_service", &transport::MachineService);
  native.def("machine_status_topic", &transport::MachineStatusTopic);
  py::class_<Switch>(native, "Switch")
      .def(py::init<const PyNodePtr&, const std::string&, const std::string&, const std::string&,
                    double, double, const MailboxPtr&, const std::string&, const std::string&>())
      .def("close", &Switch::Close);
  py::class_<Restart>(native, "Restart")
      .def(py::init<const PyNodePtr&, const std::string&, const std::string&, double,
                    const MailboxPtr&, const std::string&, const std::string&>())
      .def("found", &Restart::Found)
      .def("close", &Restart::Close);
  native.def("publish_stop", &PublishStop);
  py::class_<NewStop>(native, "NewStop")
      .def(py::init([](const std::string& by, const std::string& reason) {
        return NewStop{NewEmergencyStop(by, reason)};
      }))
      .def("hand_over", &NewStop::HandOver);
  py::class_<Stop>(native, "Stop")
      .def(py::init<const PyNodePtr&, const NewStop&, const MailboxPtr&, const std::string&,
                    const std::string&, std::optional<int>, const std::string&,
                    const std::string&>())
      .def("publish_after_end", &Stop::PublishAfterEnd)
      .def("publisher_pid", &Stop::PublisherPid)
      .def("is_one_of", &Stop::IsOneOf)
      .def("names_machine", &Stop::NamesMachine)
      .def("withdrawn", &Stop::Withdrawn)
      .def("confirm", &Stop::Confirm)
      .def("report", &Stop::Report)
      .def("follow", &Stop::Follow)
      .def("searches", &Stop::Searches)
      .def("close", &Stop::Close);
}

}  // namespace musher::python
