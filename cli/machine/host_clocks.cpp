#include "musher/cli/machine/host_clocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/cli/machine/host_query.hpp"

namespace musher::cli {

std::string ClockText(Duration ahead) {
  const double seconds = ToSeconds(ahead);
  const double size = std::abs(seconds);
  const std::string side = seconds < 0 ? "behind" : "ahead";
  if (size < 1) return fmt::format("{:.0f} ms {}", size * 1000, side);
  return fmt::format("{:.1f} s {}", size, side);
}

struct HostClocks::Host {
  HostClock clock;
  std::optional<HostScript> script = {};  // until it has answered, or has failed
  transport::LoopHandlePtr watch = nullptr;
};

HostClocks::HostClocks(transport::EventLoop& loop, const MachineConfig& config) {
  for (const HostConfig& host : config.hosts) {
    HostClock clock{host.name, host.Login(), {}};
    for (const ActuatorConfig& actuator : config.actuators) {
      if (actuator.host == host.name) clock.actuators.push_back(actuator.name);
    }
    if (clock.actuators.empty()) continue;
    Host& made = *hosts_.emplace_back(std::make_unique<Host>(Host{std::move(clock)}));
    // Each script of a host begins with its clock.
    auto script = HostScript::Start(host, "");
    if (!script) {
      made.clock.trouble = "host " + host.name + ": " + script.error().message;
      continue;
    }
    made.script.emplace(std::move(script).value());
    made.watch = loop.WhenReadable(made.script->output(), [&made] { OnLines(made); });
  }
}

HostClocks::~HostClocks() = default;

void HostClocks::OnLines(Host& host) {
  const bool more = host.script->Read();
  if (const auto ahead = host.script->clock_offset_ns()) host.clock.ahead = Duration(*ahead);
  if (more && !host.clock.ahead) return;
  host.watch = nullptr;
  if (!host.clock.ahead) host.clock.trouble = host.script->Trouble();
  host.script.reset();
}

bool HostClocks::Complete() const {
  return std::ranges::none_of(hosts_, [](const auto& host) { return host->script.has_value(); });
}

std::vector<HostClock> HostClocks::Now(Duration within) const {
  std::vector<HostClock> clocks;
  for (const auto& host : hosts_) {
    HostClock& clock = clocks.emplace_back(host->clock);
    if (host->script) clock.trouble = host->script->Late(within);
  }
  return clocks;
}

}  // namespace musher::cli
