// musher top: the processes of the machine, live: what they do and what they use.

#include <signal.h>
#include <unistd.h>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/process_usage.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/console/terminal_screen.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/host_usage.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/cli/render/top_table.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"

namespace musher::cli {
namespace {

struct TopOptions {
  double interval_s = 1;
  bool once = false;
};

constexpr Duration kFirstSample = Milliseconds(500);
constexpr Duration kHostsWithin = Milliseconds(8000);  // ssh gives up after 5 s
constexpr std::uint32_t kLastEntries = 300;  // of the journal, searched for the last event of each

// Collects what the table shows.
class TopWatch {
 public:
  TopWatch(Link& link, const GlobalOptions& global) : link_(link), global_(global) {}

  Result<> Begin() {
    const auto followed = link_.FollowStatus([this](const auto&) { history_due_ = true; });
    if (!followed) return followed.error();
    transport::Qos qos = transport::kHeartbeatQos;
    qos.partition = transport::ReaderPartition(!global_.keys.empty());
    auto heartbeats = transport::MakeSubscription<msg::ActuatorHeartbeat>(
        link_.node(), transport::ActuatorHeartbeatTopic(global_.name_space),
        [this](const msg::ActuatorHeartbeat& heartbeat, const transport::SampleInfo& info) {
          if (transport::IsFrom(heartbeat.name, info)) {
            heartbeats_[heartbeat.name] = {heartbeat, link_.loop().Now()};
          }
        },
        qos);
    if (!heartbeats) return heartbeats.error();
    heartbeat_subscription_ = std::move(heartbeats).value();
    auto history = transport::MakeClient<msg::GetHistory>(
        link_.node(), transport::MachineService(global_.name_space, "get_history"));
    if (!history) return history.error();
    history_ = std::move(history).value();
    return Ok();
  }

  // Once there is a status: from then on the other hosts of the machine send samples.
  void BeginHosts(Duration interval) {
    const auto& status = link_.last_leader();
    if (!status || status->host != HostId() || status->config_file.empty()) return;
    const ConfigReading reading = ReadConfigFile(status->config_file);
    if (!reading.config || reading.config->hosts.empty()) return;
    hosts_ = std::make_unique<HostUsage>(link_.loop(), *reading.config, interval);
  }
  bool HostsKnown() const { return !hosts_ || hosts_->Complete(); }
  void ReportHosts(Console& console) {
    if (!hosts_) return;
    for (const std::string& trouble : hosts_->TakeTroubles()) console.PrintError(trouble);
  }

  // Calls only after a change of the status: without one the journal has nothing new to show.
  void RequestEvents() {
    if (!history_due_ || !history_->Ready()) return;
    history_due_ = false;
    history_->Call({0, kLastEntries}, std::chrono::seconds(5), [this](const auto& answer) {
      events_known_ = true;
      if (!answer) return;
      for (const msg::HistoryEntry& entry : answer.value().entries) {
        Event& event = events_[entry.actuator];
        event = {entry.message, entry.wall_ns};
      }
    });
  }
  bool EventsKnown() const { return events_known_; }

  // The CPU share is that since the last sample.
  TopView Sample() {
    const auto& status = link_.last_leader();
    TopView view;
    if (!status) {
      view.title = "no controller";
      return view;
    }
    view.title = TitleOf(*status, link_.status().has_value());
    const Time now = link_.loop().Now();
    std::map<pid_t, ProcessUsage> usages;
    TopRow controller;
    controller.name = kControllerRow;
    controller.pid = status->pid;
    controller.elsewhere = status->host.empty() || status->host != HostId();
    TakeEvent("", controller);
    TakeUsage(now, usages, controller);
    view.rows.push_back(std::move(controller));
    for (const msg::ActuatorInfo& actuator : status->actuators) {
      TopRow row = RowOf(actuator, now);
      TakeUsage(now, usages, row);
      TakeUsageThere(actuator.name, row);
      view.rows.push_back(std::move(row));
    }
    usages_ = std::move(usages);
    sampled_ = now;
    return view;
  }

 private:
  struct Event {
    std::string message;
    std::int64_t wall_ns = 0;
  };

  static std::string TitleOf(const msg::MachineStatus& status, bool led) {
    std::string title = status.machine + "  " + status.state;
    if (!status.target.empty()) title += " \u2192 " + status.target;
    title += "  (" + status.phase + ")  " + LocalTime(WallNow());
    if (status.emergency_stop) title += "  EMERGENCY STOP";
    if (!led) title += "  NO CONTROLLER: last known values; `musher up` takes control again";
    return title;
  }

  TopRow RowOf(const msg::ActuatorInfo& a, Time now) {
    TopRow row;
    row.name = a.name + (a.critical ? "*" : "");
    row.state = a.state;
    row.target = a.target;
    row.health = a.health;
    row.degraded = a.degraded;
    row.pid = a.pid;
    row.restarts = a.restarts;
    row.elsewhere = a.pid != 0 && (a.host.empty() || a.host != HostId());
    if (const auto heartbeat = heartbeats_.find(a.name); heartbeat != heartbeats_.end()) {
      row.heartbeat_age_s = ToSeconds(now - heartbeat->second.second);
      const std::int64_t silent = heartbeat->second.first.silent_ns;
      if (silent > 0)
        row.checkpoint_age_s = static_cast<double>(silent) / 1e9 + *row.heartbeat_age_s;
    }
    TakeEvent(a.name, row);
    return row;
  }

  void TakeEvent(const std::string& actuator, TopRow& row) const {
    const auto found = events_.find(actuator);
    if (found == events_.end()) return;
    row.event = found->second.message;
    // By the clock of the controller.
    if (!IsOfThisBoot(link_.last_leader()->host)) return;
    row.event_age_s = static_cast<double>(WallNow() - found->second.wall_ns) / 1e9;
  }

  void TakeUsage(Time now, std::map<pid_t, ProcessUsage>& usages, TopRow& row) const {
    if (row.elsewhere || row.pid == 0) return;
    const auto usage = UsageOf(row.pid);
    if (!usage) return;
    row.memory_bytes = usage->resident_bytes;
    row.threads = usage->threads;
    const auto before = usages_.find(row.pid);
    const double seconds = ToSeconds(now - sampled_);
    const bool same = before != usages_.end() && before->second.start_time == usage->start_time;
    if (same && seconds > 0) {
      row.cpu_percent = 100 * (usage->cpu_seconds - before->second.cpu_seconds) / seconds;
    }
    usages[row.pid] = *usage;
  }

  void TakeUsageThere(const std::string& actuator, TopRow& row) const {
    const HostUsage::Sample* sample = hosts_ ? hosts_->Of(actuator) : nullptr;
    if (!row.elsewhere || sample == nullptr || sample->usage.pid != row.pid) return;
    row.memory_bytes = sample->usage.resident_bytes;
    row.threads = sample->usage.threads;
    row.cpu_percent = sample->cpu_percent;
  }

  Link& link_;
  const GlobalOptions& global_;
  std::unique_ptr<HostUsage> hosts_;  // null: the machine has none, or they are not known here
  std::map<std::string, std::pair<msg::ActuatorHeartbeat, Time>> heartbeats_;
  std::map<std::string, Event> events_;
  std::map<pid_t, ProcessUsage> usages_;  // of the last sample
  Time sampled_{};
  bool history_due_ = true;
  bool events_known_ = false;
  std::unique_ptr<transport::Client<msg::GetHistory>> history_;
  std::unique_ptr<transport::Subscription> heartbeat_subscription_;
};

// Redraws the table on the terminal until q or Ctrl-C.
class TopScreen {
 public:
  TopScreen(Link& link, TopWatch& watch, Console& console)
      : link_(link),
        watch_(watch),
        console_(console),
        resized_(TakeSignals({SIGWINCH})),
        screen_(console) {}

  void Run(Duration interval) {
    const auto resize = link_.loop().WhenReadable(resized_.get(), [this] {
      if (NextSignal(resized_) != 0) Draw();
    });
    transport::LoopHandlePtr keys;
    if (screen_.HasKeys()) {
      keys = link_.loop().WhenReadable(STDIN_FILENO, [this, &keys] {
        const char key = TerminalScreen::NextKey();
        if (key == '\0') keys = nullptr;
        OnKey(key);
      });
    }
    view_ = watch_.Sample();
    Draw();
    while (!done_ && !link_.interrupted()) {
      link_.RunUntil([this] { return done_; }, interval);
      if (done_ || link_.interrupted()) break;
      watch_.RequestEvents();
      view_ = watch_.Sample();
      Draw();
    }
  }

 private:
  void OnKey(char key) {
    if (key == 'q' || key == 'Q') done_ = true;
    if (key == 'c') order_ = TopOrder::kCpu;
    if (key == 'm') order_ = TopOrder::kMemory;
    if (key == 'n') order_ = TopOrder::kName;
    if (key == 'o') order_ = TopOrder::kConfig;
    if (!done_) Draw();
  }

  void Draw() {
    TopView view = view_;
    Sort(view.rows, order_);
    const auto [columns, lines] = TerminalScreen::SizeNow();
    const std::string keys = columns < 60 ? "q quit, sort: c m n o\n"
                                          : "q quit   sort by: c CPU, m memory, n name, o config\n";
    console_.Redraw(
        TopFrame(TopText(view, columns, lines > 3 ? lines - 1 : 0, console_.mode().colour) + keys));
  }

  Link& link_;
  TopWatch& watch_;
  Console& console_;
  UniqueFd resized_;
  TerminalScreen screen_;
  TopView view_;
  TopOrder order_ = TopOrder::kConfig;
  bool done_ = false;
};

ExitCode Top(const TopOptions& options, const GlobalOptions& global, Console& console) {
  const auto opened = Link::Open(global, &console);
  if (!opened) return console.Fail(opened.error());
  Link& link = *opened.value();
  TopWatch watch(link, global);
  if (const auto begun = watch.Begin(); !begun) return console.Fail(begun.error());
  if (const auto failure = link.AwaitStatus()) return console.Fail(*failure);
  watch.RequestEvents();
  watch.Sample();
  const Duration interval = Milliseconds(static_cast<std::int64_t>(options.interval_s * 1000));
  const bool screen = !options.once && console.mode().terminal && !console.mode().json;
  watch.BeginHosts(options.once ? kFirstSample : interval);
  // CPU shares are of the time between two samples.
  link.RunUntil([] { return false; }, std::min(interval, kFirstSample));
  watch.RequestEvents();
  if (screen) {
    TopScreen(link, watch, console).Run(interval);
    return ExitCode::kDone;
  }
  while (!link.interrupted() && console.HasReader()) {
    if (options.once) {
      link.RunUntil([&] { return watch.EventsKnown(); }, kFirstSample);
      link.RunUntil([&] { return watch.HostsKnown(); }, kHostsWithin);
    }
    watch.ReportHosts(console);
    const TopView view = watch.Sample();
    console.Print(console.mode().json ? TopJson(view) : TopText(view, 0, 0, console.mode().colour));
    if (options.once) break;
    link.RunUntil([] { return false; }, interval);
    watch.RequestEvents();
  }
  return ExitCode::kDone;
}

}  // namespace

void AddTop(Grammar& grammar) {
  auto [app, options] = grammar.Add("top", "Show what the processes do and use, live; q quits", Top,
                                    "musher top --interval 2");
  app.add_option("--interval", options.interval_s, "Between two samples; default 1")
      ->check(Between(0.1, 3600, "seconds"))
      ->type_name("SECONDS");
  app.add_flag("--once", options.once, "Print one table; CPU shares of 0.5 s");
}

}  // namespace musher::cli
