#include "musher/python/native/client.hpp"

#include "musher/base/host.hpp"
#include "musher/controller/client/leader_call.hpp"
#include "musher/controller/client/stop_latch.hpp"
#include "musher/controller/client/switch_client.hpp"
#include "musher/controller/storage/machine_origin.hpp"
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

// An emergency stop that is published as long as this exists, unless it is released.
class Stop : public OnLoop<StopLatch> {
 public:
  // An item of `key` goes into the mailbox when the report has changed. `config`: the machine's, if
  // the program knows it.
  Stop(const PyNodePtr& node, const std::string& by, const std::string& reason,
       const MailboxPtr& mailbox, std::int64_t key, const std::string& machine,
       const std::string& machine_id, std::optional<int> domain, const std::string& config)
      : OnLoop(node, [&](transport::Node& on) {
          msg::EmergencyStop stop = NewEmergencyStop(by, reason);
          stop.machine = machine;
          stop.machine_id = machine_id;
          return StopLatch::Begin(on, node->name_space, stop,
                                  node->thread->credentials().has_value(), [mailbox, key] {
                                    Item item;
                                    item.key = key;
                                    mailbox->PushLatest(std::move(item));
                                  });
        }) {
    transport::DdsOptions options;
    options.domain_id = domain;
    const auto id = transport::DomainId(options);
    scope_ = {node->name_space, id ? id.value() : 0, false};
    const auto profile = transport::Profile(options);
    scope_.lan = !profile || profile.value() == TransportProfile::kLan;
    std::vector<std::string> configs;
    if (!config.empty()) configs.push_back(config);
    scope_.machines =
        WithoutGil([&] { return MachinesHere(scope_.domain_id, scope_.name_space, configs); });
  }

  // Which actuators are stopped: (there is nothing to wait for any more, [(name, stopped, after_s,
  // trouble)], why there may be more of them, else "").
  using Actuators = std::vector<std::tuple<std::string, bool, double, std::string>>;
  std::tuple<bool, Actuators, std::string> Report(const std::optional<py::bytes>& machine_status) {
    std::optional<msg::MachineStatus> status;
    if (machine_status) {
      const std::string_view bytes = *machine_status;
      status = msg::Decode<msg::MachineStatus>(std::as_bytes(std::span(bytes)));
    }
    EstopReport report;
    bool over = false;
    Run([&](StopLatch& latch) {
      report = latch.Report(ViewFromHere(scope_, status));
      over = latch.IsOver(report);
    });
    Actuators actuators;
    if (!report.found()) return {over, {}, report.unknown};
    for (const EstopReport::Actuator& one : report.actuators) {
      actuators.emplace_back(one.name, one.stopped,
                             std::chrono::duration<double>(one.after).count(), one.trouble);
    }
    return {over, std::move(actuators), report.unknown};
  }

 private:
  StopScope scope_;
};

// (namespace, name) of a valid config.
std::pair<std::string, std::string> ReadMachine(const std::string& file) {
  const auto config = ReadValidConfig(file);
  if (!config) Raise("ConfigError", config.error());
  return {config.value().name_space, config.value().name};
}

// (name, id) of the machine whose controller runs on this host; empty: none.
std::pair<std::string, std::string> FindMachineHere(const std::string& name_space,
                                                    std::optional<int> domain) {
  const auto origin = WithoutGil([&]() -> std::optional<MachineOrigin> {
    transport::DdsOptions options;
    options.domain_id = domain;
    const auto id = transport::DomainId(options);
    return id ? OriginHere(id.value(), name_space) : std::nullopt;
  });
  if (!origin) return {};
  return {origin->name, origin->id};
}

// (name, id) of each machine that has files or processes on this host.
std::vector<std::pair<std::string, std::string>> FindMachinesHere(const std::string& name_space,
                                                                  std::optional<int> domain) {
  std::vector<std::pair<std::string, std::string>> found;
  transport::DdsOptions options;
  options.domain_id = domain;
  const auto id = transport::DomainId(options);
  if (!id) return found;
  const auto machines = WithoutGil([&] { return MachinesHere(id.value(), name_space); });
  for (const MachineHere& machine : machines) {
    if (machine.identity.name.empty()) continue;
    found.emplace_back(machine.identity.name, machine.identity.id);
  }
  return found;
}

}  // namespace

void AddClient(py::module_& native) {
  native.def("read_machine", &ReadMachine);
  native.def("machine_here", &FindMachineHere);
  native.def("machines_here", &FindMachinesHere);
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
  py::class_<Stop>(native, "Stop")
      .def(py::init<const PyNodePtr&, const std::string&, const std::string&, const MailboxPtr&,
                    std::int64_t, const std::string&, const std::string&, std::optional<int>,
                    const std::string&>())
      .def("report", &Stop::Report)
      .def("close", &Stop::Close);
}

}  // namespace musher::python
