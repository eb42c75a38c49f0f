#include "musher/cli/render/description.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "musher/base/code.hpp"
#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/lifecycle/event_name.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {
namespace {

constexpr std::size_t kLabel = 14;  // columns

// Lines of "LABEL         text".
class Sheet {
 public:
  explicit Sheet(bool colour) : colour_(colour) {}

  void Line(std::string_view label, const std::string& text, Style style = Style::kPlain) {
    if (text.empty()) return;
    std::string head(label);
    head.resize(kLabel, ' ');
    text_ += Paint(head, Style::kDim, colour_) + Paint(Printable(text), style, colour_) + '\n';
  }
  void Raw(const std::string& line) { text_ += line; }
  const std::string& text() const { return text_; }
  bool colour() const { return colour_; }

 private:
  bool colour_;
  std::string text_;
};

std::string SecondsText(Duration duration) {
  return fmt::format("{:g} s", ToSeconds(duration));
}

bool HasGoodHealth(const msg::ActuatorInfo& info) {
  return info.health == HealthName(Health::kWell);
}

// Whether its process is a unit of another host, which other commands reach by ssh.
bool HasHost(const Description& d) {
  return d.config && !d.config->host.empty();
}

std::string KnownStateOf(const Description& d) {
  if (d.info) return d.info->state;
  return d.status ? d.status->state : "";
}

std::string Age(const Description& d, std::int64_t wall_ns) {
  return AgeText(static_cast<double>(d.now_wall_ns - wall_ns) / 1e9);
}

// "held; degraded; …"
std::string FlagsOf(const Description& d) {
  std::vector<std::string> flags;
  if (d.info && d.info->held)
    flags.emplace_back("held: switched alone, until the next switch of all");
  if (d.info && d.info->degraded) flags.emplace_back("degraded");
  if (d.info && d.info->restarting) flags.emplace_back("restarting");
  if (d.status && d.status->emergency_stop != 0) {
    flags.push_back(
        "emergency stop latched, by " + d.status->emergency_stop_by +
        (d.status->emergency_stop_reason.empty() ? "" : ": " + d.status->emergency_stop_reason));
    if (!d.status->stop_trouble.empty()) {
      flags.push_back("NOT STOPPED: " + d.status->stop_trouble);
    }
  } else if (d.status && d.status->held_by_stop) {
    flags.emplace_back("held by a released emergency stop");
  }
  return fmt::format("{}", fmt::join(flags, "; "));
}

void AddState(Sheet& sheet, const Description& d) {
  const std::string state = KnownStateOf(d);
  std::string text = state.empty() ? "not known" : state;
  if (d.info && !d.info->target.empty() && d.info->target != state) {
    text += " \u2192 " + d.info->target;
  }
  if (const std::int64_t since = SinceOf(d); since != 0) {
    text += d.same_clock
                ? fmt::format(", for {} (since {})", Age(d, since), LocalText(since))
                : fmt::format(", since {} by the clock of its controller", LocalText(since));
  }
  if (!d.machine_state.empty()) {
    text += fmt::format("; the machine is in {} ({})", d.machine_state, d.machine_phase);
  }
  sheet.Line("state", text, StyleOfState(state));
  sheet.Line("", FlagsOf(d), Style::kBad);
  if (!d.why_no_machine.empty()) sheet.Line("machine", d.why_no_machine, Style::kBad);
  if (!d.info) return;
  const bool bad = d.info->degraded || !HasGoodHealth(*d.info);
  if (!d.info->message.empty() || d.info->code != 0) {
    const std::string why =
        d.info->message.empty() ? CodeText(d.info->code) : WithCode(d.info->message, d.info->code);
    sheet.Line("why", why, bad ? Style::kBad : Style::kPlain);
  }
}

void AddHealth(Sheet& sheet, const Description& d) {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  if (d.info) add(d.info->health + " (" + d.info->presence + ")");
  if (d.heartbeat) {
    add(fmt::format("heartbeat {:.1f} s ago, due every {:g} s", d.heartbeat_age_s,
                    static_cast<double>(d.heartbeat->period_ns) / 1e9));
    if (d.heartbeat->silent_ns > 0) {
      add(fmt::format(
          "no checkpoint for {:.1f} s{}", static_cast<double>(d.heartbeat->silent_ns) / 1e9,
          d.heartbeat->during.empty() ? "" : " in the callback of " + d.heartbeat->during));
    } else if (d.config && d.config->checkpoint) {
      add("checkpoints in time");
    }
  } else if (d.info && d.info->protocol == ProtocolName(Protocol::kMusher) && d.info->pid != 0) {
    add("no heartbeat received");
  }
  const bool well = d.info && HasGoodHealth(*d.info) && d.info->presence == "present";
  sheet.Line("health", text, well ? Style::kGood : Style::kBad);
}

std::string RestartRuleText(const RestartConfig& restart) {
  if (restart.policy == RestartPolicy::kNo) return "not restarted automatically";
  return fmt::format("restarted {}, {} times in a row at most, after {} up to {}",
                     restart.policy == RestartPolicy::kAlways ? "always" : "on failure",
                     restart.limit, SecondsText(restart.delay), SecondsText(restart.max_delay));
}

// The newest entry of one of these events; nullptr: there is none.
const msg::HistoryEntry* Newest(const Description& d, std::initializer_list<EventName> events) {
  for (std::size_t i = d.history.size(); i-- > 0;) {
    for (const EventName event : events) {
      if (i < d.events.size() && d.events[i] == NameOf(event)) return &d.history[i];
    }
  }
  return nullptr;
}

void AddProcess(Sheet& sheet, const Description& d) {
  const std::int32_t pid = d.info ? d.info->pid : d.status ? d.status->pid : 0;
  if (d.process) {
    const ProcessFacts& p = *d.process;
    sheet.Line("process",
               fmt::format("pid {}, up {} (since {}), CPU {:.1f} % on average, {}, {}{}",
                           p.usage.pid, AgeText(p.age_s), LocalText(p.started_wall_ns),
                           100 * p.usage.cpu_seconds / std::max(p.age_s, 0.01),
                           BytesText(p.usage.resident_bytes), Counted(p.usage.threads, "thread"),
                           p.stopped ? "; STOPPED by a signal or a debugger" : ""),
               p.stopped ? Style::kBad : Style::kPlain);
    sheet.Line("", p.command + (p.cwd.empty() ? "" : "  in " + p.cwd));
  } else if (pid != 0 && d.on_this_host) {
    sheet.Line("process", fmt::format("pid {}, has exited or is not visible", pid));
  } else if (pid != 0 && HasHost(d)) {
    sheet.Line("process", fmt::format("pid {} on host {}: `musher top` shows its CPU and memory",
                                      pid, d.config->host));
  } else if (pid != 0) {
    sheet.Line("process",
               fmt::format("pid {} on another host: its CPU and memory are seen there only", pid));
  } else {
    sheet.Line("process", "none", Style::kBad);
  }
  if (const auto* exit = Newest(d, {EventName::kProcessExited, EventName::kActuatorCrashed,
                                    EventName::kActuatorExited})) {
    sheet.Line("last exit", LocalText(exit->wall_ns) + "  " + WithCode(exit->message, exit->code));
  }
  if (!d.config || d.config->command.empty()) return;
  std::string restarts;
  if (d.info)
    restarts = Counted(static_cast<std::size_t>(d.info->restarts), "restart") + " in a row; ";
  sheet.Line("restarts", restarts + RestartRuleText(d.config->restart));
}

void AddConfig(Sheet& sheet, const Description& d) {
  if (!d.config)
    return sheet.Line("config", d.config_file.empty() ? "" : d.config_file + ", not readable here");
  const ActuatorConfig& c = *d.config;
  std::string text =
      fmt::format("{}:{}  stage {}, {}, protocol {}", d.config_file, d.config_line, c.stage,
                  c.critical ? "critical" : "not critical", ProtocolName(c.protocol));
  if (!c.after.empty()) text += ", after " + Joined(c.after);
  if (!c.binds_to.empty()) text += ", binds to " + Joined(c.binds_to);
  if (!c.on_lost.empty()) text += ", on_lost " + c.on_lost;
  sheet.Line("config", text);
  std::vector<std::string> states;
  for (std::size_t i = 0; i < c.states.size() && i < c.times.size(); ++i) {
    states.push_back(c.states[i] + " " + SecondsText(c.times[i]));
  }
  sheet.Line("time limits", Joined(states));
  if (c.command.empty()) {
    sheet.Line("command", "none: it is started by hand or on another host");
  } else if (!d.process) {
    sheet.Line("command", fmt::format("{}", fmt::join(c.command, " ")) +
                              (c.cwd.empty() ? "" : "  in " + c.cwd) +
                              (c.host.empty() ? "" : "  on host " + c.host));
  }
}

void AddReach(Sheet& sheet, const Description& d) {
  std::vector<std::string> allowed;
  for (const Description::Reach& reach : d.reach) {
    if (reach.allowed) allowed.push_back(reach.state);
  }
  if (!d.reach.empty()) {
    sheet.Line("can go to", allowed.empty() ? "no state now" : Joined(allowed));
    std::string reason;  // many states share one
    std::vector<std::string> states;
    const auto flush = [&] {
      if (!states.empty()) sheet.Line("", "not " + Joined(states) + ": " + reason, Style::kDim);
      states.clear();
    };
    for (const Description::Reach& reach : d.reach) {
      if (reach.allowed) continue;
      const std::string why = WithCode(reach.reason, reach.code);
      if (why != reason) flush();
      reason = why;
      states.push_back(reach.state);
    }
    flush();
  }
  for (const msg::Capability& c : d.capabilities) {
    sheet.Line("capability",
               c.name + (c.allowed ? ": allowed now" : ": " + WithCode(c.reason, c.code)),
               c.allowed ? Style::kGood : Style::kBusy);
  }
  if (!d.offers.empty()) sheet.Line("offers", Joined(d.offers));
}

void AddPast(Sheet& sheet, const Description& d) {
  if (!d.history.empty()) {
    sheet.Raw(Paint("last events\n", Style::kDim, sheet.colour()));
    constexpr std::size_t kMost = 8;
    const std::size_t most = std::min(kMost, d.history.size());
    std::vector<msg::HistoryEntry> entries(d.history.end() - static_cast<std::ptrdiff_t>(most),
                                           d.history.end());
    for (msg::HistoryEntry& entry : entries) {
      const bool backtrace = !entry.data.empty() && !entry.data.starts_with('{');
      if (backtrace) entry.message += " (`musher history --actuator " + d.name + "` shows it)";
      entry.data.clear();
    }
    sheet.Raw(HistoryText(entries, sheet.colour()));
  }
  if (!d.log.empty()) {
    sheet.Raw(Paint("last lines of " + Printable(d.log_file) + '\n', Style::kDim, sheet.colour()));
    for (const LogEntry& entry : d.log) sheet.Raw(LogText(entry, 0, sheet.colour()));
  }
  sheet.Line("log", d.log.empty() ? d.why_no_log : "");
}

}  // namespace

std::string AgeText(double seconds) {
  if (seconds < 0) return "0 s";
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 2 * 3600) return fmt::format("{:.0f} min", seconds / 60);
  if (seconds < 48 * 3600) return fmt::format("{:.0f} h", seconds / 3600);
  return fmt::format("{:.0f} d", seconds / 86400);
}

std::string BytesText(std::uint64_t bytes) {
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

std::int64_t SinceOf(const Description& d) {
  const std::string begin = d.name + ": " + KnownStateOf(d) + " ";
  for (std::size_t i = d.history.size(); i-- > 0;) {
    const bool done = i < d.events.size() && d.events[i] == NameOf(EventName::kCommandDone);
    if (done && d.history[i].message.starts_with(begin)) return d.history[i].wall_ns;
    if (done) return 0;  // of another state, or of a check
  }
  return 0;
}

std::vector<Advice> AdviceFor(const Description& d) {
  std::vector<Advice> steps;
  const std::string& name = d.name;
  if (!d.why_no_machine.empty()) {
    if (!d.log.empty()) steps.push_back({"musher logs " + name, "all that it has printed"});
    if (!d.config_file.empty())
      steps.push_back({"musher up " + ShellWord(d.config_file), "start the machine"});
    return steps;
  }
  if (!d.info) return steps;
  const msg::ActuatorInfo& a = *d.info;
  const bool stopped = d.status && (d.status->emergency_stop != 0 || d.status->held_by_stop);
  if (d.status && d.status->emergency_stop != 0) {
    steps.push_back({"musher estop --release", "end the emergency stop once it is safe"});
  } else if (stopped) {
    steps.push_back({"musher set " + d.machine_state, "end what the stop still holds"});
  }
  if (d.process && d.process->stopped) {
    steps.push_back(
        {fmt::format("kill -CONT {}", d.process->usage.pid), "continue the stopped process"});
  }
  const bool has_log = d.why_no_log.empty() || HasHost(d);
  const bool bad = a.degraded || !HasGoodHealth(a) || a.presence != "present";
  if (bad && has_log) {
    steps.push_back({"musher logs " + name + " --level warning", "what it has reported"});
  }
  if (bad) {
    steps.push_back({"musher history --actuator " + name, "what happened to it, in order"});
    if (d.config && !d.config->command.empty() && !a.restarting) {
      steps.push_back({"musher restart " + name, "end its process and start it again"});
    }
  } else if (a.held || (!a.target.empty() && a.target != a.state)) {
    steps.push_back({"musher set " + d.machine_state, "bring it to the state of the machine"});
  } else if (!stopped) {
    if (has_log) steps.push_back({"musher logs -f " + name, "watch what it prints"});
    for (const Description::Reach& reach : d.reach) {
      // Only a rest, never an upgrade or a fault: a newcomer may try it.
      const bool rest =
          reach.lower && reach.state != kTearDown && reach.state != kOta && reach.state != kError;
      if (!reach.allowed || !rest) continue;
      steps.push_back({"musher set " + reach.state + " " + name, "switch it alone"});
      break;
    }
  }
  return steps;
}

std::string DescriptionText(const Description& d, bool colour) {
  Sheet sheet(colour);
  sheet.Raw(Paint(Printable(d.name), Style::kBold, colour) + "  of " + Printable(d.machine) + '\n');
  AddState(sheet, d);
  AddHealth(sheet, d);
  AddProcess(sheet, d);
  AddConfig(sheet, d);
  AddReach(sheet, d);
  AddPast(sheet, d);
  const std::vector<Advice> steps = AdviceFor(d);
  if (!steps.empty()) sheet.Raw(Paint("next\n", Style::kDim, colour));
  std::size_t width = 0;
  for (const Advice& step : steps) width = std::max(width, Width(step.command));
  for (const Advice& step : steps) {
    const std::string command = Printable(step.command);
    sheet.Raw("  " + Paint(command, Style::kBold, colour) +
              std::string(width + 2 - std::min(width + 2, Width(command)), ' ') + step.purpose +
              '\n');
  }
  return sheet.text();
}

}  // namespace musher::cli
