#include "musher/cli/machine/host_usage.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <sstream>
#include <utility>

#include "musher/controller/process/host_processes.hpp"

namespace musher::cli {
namespace {

// Each sample: a line for each actuator that runs, and a line with a dot.
std::string ScriptOf(const std::string& machine, const std::vector<std::string>& actuators,
                     Duration interval) {
  std::string script =
      "echo \"units $(getconf CLK_TCK) $(getconf PAGESIZE)\"\n"
      "sample() {\n"
      "  pid=$(systemctl show -p MainPID --value \"$2\")\n"
      "  [ \"$pid\" = 0 ] || echo \"$1 $pid $(cat /proc/$pid/stat 2>/dev/null)\"\n"
      "}\nwhile :; do\n";
  for (const std::string& actuator : actuators) {
    script += "  sample " + actuator + " " + UnitNameOf(machine, actuator) + "\n";
  }
  return script + fmt::format("  echo .\n  sleep {:.1f}\ndone\n", ToSeconds(interval));
}

}  // namespace

HostUsage::HostUsage(transport::EventLoop& loop, const MachineConfig& config, Duration interval)
    : loop_(loop) {
  for (const HostConfig& host : config.hosts) {
    std::vector<std::string> actuators;
    for (const ActuatorConfig& actuator : config.actuators) {
      if (actuator.host == host.name) actuators.push_back(actuator.name);
    }
    if (actuators.empty()) continue;
    auto script = HostScript::Start(host, ScriptOf(config.name, actuators, interval));
    if (!script) {
      troubles_.push_back("host " + host.name + ": " + script.error().message);
      continue;
    }
    auto& made = hosts_.emplace_back(std::make_unique<Host>(Host{host.name, actuators, {}}));
    made->script.emplace(std::move(script).value());
    made->watch =
        loop_.WhenReadable(made->script->output(), [this, &one = *made] { OnLines(one); });
  }
}

void HostUsage::OnLines(Host& host) {
  const bool more = host.script->Read();
  for (const std::string& line : host.script->TakeLines()) Take(host, line);
  if (more) return;
  host.watch = nullptr;
  const std::string trouble = host.script->Trouble();
  troubles_.push_back(trouble.empty() ? "host " + host.name + " sends no more samples" : trouble);
  host.script.reset();
  host.last.clear();
}

void HostUsage::Take(Host& host, const std::string& line) const {
  if (line == ".") {
    ++host.samples;
    host.sampled = loop_.Now();
    host.last = std::exchange(host.now, {});
    return;
  }
  std::istringstream words(line);
  std::string actuator;
  pid_t pid = 0;
  words >> actuator;
  if (actuator == "units") {
    words >> host.ticks_per_second >> host.page_bytes;
    return;
  }
  words >> pid;
  std::string stat;
  std::getline(words, stat);
  const auto usage = ParseUsage(pid, stat, host.ticks_per_second, host.page_bytes);
  if (!usage) return;
  Sample& sample = host.now[actuator];
  sample.usage = *usage;
  const auto before = host.last.find(actuator);
  const double seconds = ToSeconds(loop_.Now() - host.sampled);
  const bool same =
      before != host.last.end() && before->second.usage.start_time == usage->start_time;
  if (same && seconds > 0) {
    sample.cpu_percent = 100 * (usage->cpu_seconds - before->second.usage.cpu_seconds) / seconds;
  }
}

const HostUsage::Sample* HostUsage::Of(const std::string& actuator) const {
  for (const auto& host : hosts_) {
    const auto found = host->last.find(actuator);
    if (found != host->last.end()) return &found->second;
  }
  return nullptr;
}

bool HostUsage::Complete() const {
  for (const auto& host : hosts_) {
    if (host->script && host->samples < 2) return false;
  }
  return true;
}

std::vector<std::string> HostUsage::TakeTroubles() {
  return std::exchange(troubles_, {});
}

}  // namespace musher::cli
