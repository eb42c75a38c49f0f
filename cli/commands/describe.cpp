// musher describe ACTUATOR: all that is known about one actuator, from the controller, from itself,
// from its process and from its files; with the machine down, what the files know.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/base/suggest.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/log_files_of.hpp"
#include "musher/cli/config/config_places.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/cli/render/description.hpp"
#include "musher/controller/journal/journal_reader.hpp"
#include "musher/controller/shell/wire.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/tree.hpp"

namespace musher::cli {
namespace {

struct DescribeOptions {
  std::string actuator;
  std::string config;
};

constexpr Duration kAnswers = Milliseconds(1000);    // of all queries together
constexpr Duration kOwnReports = Milliseconds(600);  // the actuator's status and heartbeat
constexpr Duration kServices = Milliseconds(100);    // to be discovered
constexpr std::size_t kHistory = 200;                // entries of the machine's newest
constexpr std::size_t kLogLines = 6;

using FoundFiles = std::variant<MachineFiles, Failure>;

// The names of the actuators that are known by the status or the config.
std::vector<std::string> NamesOf(const std::optional<msg::MachineStatus>& status,
                                 const MachineFiles* files) {
  std::vector<std::string> names;
  if (status) {
    for (const auto& actuator : status->actuators) names.push_back(actuator.name);
  } else if (files != nullptr && files->config) {
    for (const auto& actuator : files->config->actuators) names.push_back(actuator.name);
  }
  return names;
}

void TakeHistory(msg::GetHistory::Response history, Description& d) {
  history.events.resize(history.entries.size());
  for (std::size_t i = 0; i < history.entries.size(); ++i) {
    if (history.entries[i].actuator != d.name) continue;
    d.history.push_back(std::move(history.entries[i]));
    d.events.push_back(std::move(history.events[i]));
  }
}

void TakeConfig(const MachineConfig& config, Description& d) {
  const auto index = config.IndexOf(d.name);
  d.config_file = config.file;
  if (!index) return;
  d.config = config.actuators[*index];
  d.config_line = ConfigPlaces(config.file).LineOf("actuator." + d.name, "");
}

void TakeLog(const MachineFiles& files, Description& d) {
  if (d.config && !d.config->host.empty()) {
    d.why_no_log = "its output is in the journal of host " + d.config->host + "; `musher logs " +
                   d.name + "` shows it";
    return;
  }
  d.log_file = LogPathOf(files, d.name);
  d.why_no_log = WhyUnreadable(files);
  if (!d.why_no_log.empty()) return;
  if (!std::filesystem::exists(d.log_file)) {
    d.why_no_log = WhyNoLog(files, d.name, d.log_file);
    return;
  }
  auto log = ReadLog(d.name, d.log_file, {}, kLogLines);
  if (!log) {
    d.why_no_log = log.error().message;
    return;
  }
  auto& entries = log.value().entries;
  d.log.assign(entries.end() - static_cast<std::ptrdiff_t>(std::min(entries.size(), kLogLines)),
               entries.end());
  if (d.log.empty()) d.why_no_log = d.log_file + " is empty";
}

// The queries to the controller and the actuator, all at the same time.
class Queries {
 public:
  Queries(Link& link, const GlobalOptions& global, Description& description)
      : link_(link), global_(global), d_(description) {}

  void Run(const std::vector<std::string>& states) {
    QueryPlans(states);
    QueryHistory();
    QueryCapabilities();
    Subscribe();
    FindServices();
    link_.RunUntil([this] { return waiting_ == 0; }, kAnswers);
    link_.RunUntil([this] { return d_.heartbeat.has_value(); }, kOwnReports);
    const Time services_end = begin_ + kServices;
    if (link_.loop().Now() < services_end) {
      link_.RunUntil([] { return false; }, services_end - link_.loop().Now());
    }
    TakeServices();
    d_.heartbeat_age_s = ToSeconds(link_.loop().Now() - heartbeat_at_);
  }

 private:
  template <msg::Service S>
  std::unique_ptr<transport::Client<S>> ClientOf(const std::string& name) {
    auto client = transport::MakeClient<S>(link_.node(), name);
    return client ? std::move(client).value() : nullptr;
  }
  template <msg::Service S>
  std::unique_ptr<transport::Client<S>> Machine(const std::string& service) {
    return ClientOf<S>(transport::MachineService(global_.name_space, service));
  }

  void QueryPlans(const std::vector<std::string>& states) {
    plans_ = Machine<msg::GetPlan>("get_plan");
    if (!plans_) return;
    d_.reach.resize(states.size());
    for (std::size_t i = 0; i < states.size(); ++i) {
      d_.reach[i] = {states[i], false, kCodeTimeout, "the controller did not say in time"};
      ++waiting_;
      plans_->Call({states[i], d_.name}, kAnswers, [this, i](const auto& plan) {
        --waiting_;
        if (!plan) return;
        Description::Reach& reach = d_.reach[i];
        reach.allowed = plan.value().allowed;
        reach.code = plan.value().code;
        reach.reason = plan.value().reason;
        reach.lower = plan.value().direction == DirectionName(Direction::kDown);
      });
    }
  }

  void QueryHistory() {
    history_ = Machine<msg::GetHistory>("get_history");
    if (!history_) return;
    ++waiting_;
    history_->Call({0, kHistory}, kAnswers, [this](auto answer) {
      --waiting_;
      if (answer) TakeHistory(std::move(answer).value(), d_);
    });
  }

  void QueryCapabilities() {
    capabilities_ = Machine<msg::GetCapabilities>("get_capabilities");
    if (!capabilities_) return;
    ++waiting_;
    capabilities_->Call({}, kAnswers, [this](const auto& answer) {
      --waiting_;
      if (!answer) return;
      for (const msg::Capability& c : answer.value().capabilities) {
        const bool uses =
            std::find(c.actuators.begin(), c.actuators.end(), d_.name) != c.actuators.end();
        if (uses) d_.capabilities.push_back(c);
      }
    });
  }

  void Subscribe() {
    transport::Qos qos = transport::kHeartbeatQos;
    qos.partition = transport::ReaderPartition(!global_.keys.empty());
    auto heartbeats = transport::MakeSubscription<msg::ActuatorHeartbeat>(
        link_.node(), transport::ActuatorHeartbeatTopic(global_.name_space),
        [this](const msg::ActuatorHeartbeat& heartbeat, const transport::SampleInfo& info) {
          if (heartbeat.name != d_.name || !transport::IsFrom(heartbeat.name, info)) return;
          d_.heartbeat = heartbeat;
          heartbeat_at_ = link_.loop().Now();
        },
        qos);
    if (heartbeats) heartbeats_ = std::move(heartbeats).value();
  }

  void FindServices() {
    const std::string full = transport::ResolveName(global_.name_space, d_.name);
    behavior_ = ClientOf<msg::GetBehavior>(full + "/get_behavior");
    tree_ = ClientOf<msg::GetTree>(full + "/get_tree");
  }
  void TakeServices() {
    if (behavior_ && behavior_->Ready()) {
      d_.offers.push_back("a state machine: `musher behavior " + d_.name + "`");
    }
    if (tree_ && tree_->Ready()) {
      d_.offers.push_back("a behaviour tree: `musher behavior " + d_.name + " --tree`");
    }
  }

  Link& link_;
  const GlobalOptions& global_;
  Description& d_;
  int waiting_ = 0;
  Time begin_ = link_.loop().Now();
  Time heartbeat_at_ = begin_;
  std::unique_ptr<transport::Client<msg::GetPlan>> plans_;
  std::unique_ptr<transport::Client<msg::GetHistory>> history_;
  std::unique_ptr<transport::Client<msg::GetCapabilities>> capabilities_;
  std::unique_ptr<transport::Client<msg::GetBehavior>> behavior_;
  std::unique_ptr<transport::Client<msg::GetTree>> tree_;
  std::unique_ptr<transport::Subscription> heartbeats_;
};

std::vector<std::string> StatesToQuery(const Description& d) {
  std::vector<std::string> states;
  if (d.config) {
    states.assign(d.config->states.begin(), d.config->states.end());
  } else {
    for (const std::string_view state : BuiltInStates()) states.emplace_back(state);
  }
  std::erase_if(states, [&](const auto& state) {
    return state == kSetUp || state == kUninitialized || (d.info && state == d.info->state);
  });
  return states;
}

void TakeStatus(const msg::MachineStatus& status, Description& d) {
  d.machine = status.machine;
  d.machine_state = status.state;
  d.machine_phase = status.phase;
  d.config_file = status.config_file;
  d.same_clock = IsOfThisBoot(status.host);
  const auto info = std::find_if(status.actuators.begin(), status.actuators.end(),
                                 [&](const auto& actuator) { return actuator.name == d.name; });
  if (info != status.actuators.end()) d.info = *info;
}

void TakeProcess(const std::string& host, Description& d) {
  const std::int32_t pid = d.info ? d.info->pid : d.status ? d.status->pid : 0;
  d.on_this_host = pid != 0 && !host.empty() && host == HostId();
  if (d.on_this_host) d.process = FactsOf(pid);
}

// The files with the machine down or its controller on another host.
void TakeFiles(const MachineFiles& files, Description& d) {
  if (d.machine.empty()) d.machine = files.name;
  if (d.config_file.empty()) d.config_file = files.config_file;
  if (files.config) TakeConfig(*files.config, d);
  TakeLog(files, d);
  if (!d.why_no_machine.empty()) {
    const auto journal = ReadJournal(files.state_dir + "/journal.sqlite", 0, kHistory);
    if (journal) TakeHistory(ToMessage(journal.value().entries), d);
  }
}

Failure NoSuchOne(const std::string& name, const std::vector<std::string>& names) {
  return {ExitCode::kUsage, {kCodeParametersInvalid, NoSuch("actuator", name, names)}};
}

ExitCode Describe(const DescribeOptions& options, const GlobalOptions& of_caller,
                  Console& console) {
  Description d;
  d.name = options.actuator;
  d.now_wall_ns = WallNow();
  const FoundFiles found = FindMachineFiles(options.config, of_caller);
  const auto* files = std::get_if<MachineFiles>(&found);
  if (files == nullptr && !options.config.empty()) return console.Fail(std::get<Failure>(found));
  GlobalOptions global = of_caller;
  if (!options.config.empty()) global.name_space = files->config->name_space;
  const auto link = Link::Open(global, &console);
  if (!link) return console.Fail(link.error());
  const auto running =
      RunningActuators::Begin(link.value()->node(), global.name_space, !global.keys.empty());
  if (!running) return console.Fail(running.error());
  const auto answer = link.value()->Call<msg::GetStatus>("get_status", {}, std::chrono::seconds(5));
  std::optional<msg::MachineStatus> status;
  const auto* failure = std::get_if<Failure>(&answer);
  if (failure == nullptr) status = std::get<msg::GetStatus::Response>(answer).status;
  if (!status && files == nullptr) return console.Fail(*failure);
  // The machine that leads the namespace may be another one than that of --config.
  const std::string other =
      status && !options.config.empty() && status->machine != files->name ? status->machine : "";
  if (!other.empty()) status.reset();

  const std::vector<std::string> names = NamesOf(status, files);
  const bool known = std::find(names.begin(), names.end(), d.name) != names.end();
  if (!known && !(names.empty() && files != nullptr)) return console.Fail(NoSuchOne(d.name, names));
  if (status) {
    TakeStatus(*status, d);
  } else {
    const auto beyond = files != nullptr ? InOtherNetwork(*files) : std::nullopt;
    d.why_no_machine =
        beyond ? beyond->Text()
        : !other.empty()
            ? other + " leads " + NamespaceText(global.name_space) + ", not " + files->name
        : failure->exit == ExitCode::kNoController ? "no controller leads " + files->name + " now"
                                                   : failure->error.message;
  }
  // Files of this host belong to the machine only if its controller is here, too.
  const bool files_of_it =
      files != nullptr && (!status || (status->host == HostId() && status->machine == files->name));
  if (files_of_it) {
    TakeFiles(*files, d);
  } else if (status) {
    d.why_no_log = status->host == HostId() ? FilesOfAnotherUser()
                                            : "the logs are on the host of the controller";
  }
  if (status && !link.value()->interrupted()) {
    Queries(*link.value(), global, d).Run(StatesToQuery(d));
  }
  const auto now = running.value()->Now();
  const auto own = now.find(d.name);
  if (own != now.end() && other.empty()) d.status = own->second.status;
  TakeProcess(d.info ? d.info->host : d.status ? d.status->host : "", d);
  if (!d.why_no_machine.empty() && d.process) {
    d.why_no_machine += "; " + d.name + " runs without one";
  }
  if (link.value()->interrupted()) {
    return console.Fail(Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}});
  }
  console.Print(console.mode().json ? DescriptionJson(d)
                                    : DescriptionText(d, console.mode().colour));
  return status ? ExitCode::kDone : ExitCode::kNoController;
}

}  // namespace

void AddDescribe(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("describe", "Show all that is known about one actuator, and what to do", Describe,
                  "musher describe audio");
  grammar
      .Offer(app.add_option("ACTUATOR", options.actuator, "As in the config"), Names::kActuators)
      ->required()
      ->type_name("");
  grammar
      .Offer(
          app.add_option("--config", options.config, "The config of its machine, if that is down"),
          Names::kConfigs)
      ->type_name("FILE");
}

}  // namespace musher::cli
