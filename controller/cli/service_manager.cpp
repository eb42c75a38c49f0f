#include "musher/controller/cli/service_manager.hpp"

#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>

#include "musher/controller/cli/console.hpp"

namespace musher::cli {
namespace {

constexpr int kPingsInAPeriod = 3;
constexpr Duration kLastMoments = Milliseconds(5000);  // of the process, after the machine's end

void Notify(const std::string& message) {
  sd_notify(/*unset_environment=*/0, message.c_str());
}

// systemd names the main process, our parent, as the one that has to show life.
void TakeOverWatchdogOfParent() {
  const char* pid = std::getenv("WATCHDOG_PID");  // NOLINT(concurrency-mt-unsafe)
  if (pid == nullptr || pid != std::to_string(getppid())) return;
  setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
}

std::string Microseconds(Duration duration) {
  return std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(duration).count());
}

}  // namespace

ServiceManager::ServiceManager(transport::EventLoop& loop, const MachineConfig& config)
    : config_(config),
      enabled_(std::getenv("NOTIFY_SOCKET") != nullptr) {  // NOLINT(concurrency-mt-unsafe)
  if (!enabled_) return;
  TakeOverWatchdogOfParent();
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(/*unset_environment=*/0, &period_us) <= 0) return;
  const Duration period = std::chrono::microseconds(period_us);
  watchdog_ = loop.Every(period / kPingsInAPeriod, [] { Notify("WATCHDOG=1"); });
}

void ServiceManager::StartUpEnded(const action::StartUpEnded& ended) {
  if (!enabled_) return;
  if (ended.usable) return Notify("READY=1");
  Status(ended.message);
}

void ServiceManager::Follow(const Machine& machine) {
  if (!enabled_) return;
  const bool stops = machine.phase == Phase::kStopping || machine.phase == Phase::kStopped;
  if (stops && !stopping_) {
    stopping_ = true;
    // However short the unit's own TimeoutStopSec is.
    Notify("STOPPING=1\nEXTEND_TIMEOUT_USEC=" +
           Microseconds(config_.shutdown_budget + kLastMoments));
  }
  // Why the start failed says more than where it did.
  if (machine.phase != Phase::kFailed) Status(StatusWords(config_, machine));
}

void ServiceManager::Fenced(const std::string& why) {
  if (!enabled_) return;
  stopping_ = true;
  Notify("STOPPING=1");
  Status(why);
}

void ServiceManager::Status(const std::string& words) {
  if (words == told_) return;
  told_ = words;
  Notify("STATUS=" + Printable(words));  // in one line, as systemd wants it
}

std::string StatusWords(const MachineConfig& config, const Machine& machine) {
  std::string words;
  if (machine.phase != Phase::kRunning) words = std::string(PhaseName(machine.phase)) + ", ";
  words += machine.state;
  std::string degraded;
  for (const std::string& name : Degraded(config, machine)) {
    degraded += (degraded.empty() ? "" : ", ") + name;
  }
  if (!degraded.empty()) return words + ", degraded: " + degraded;
  const std::size_t count = config.actuators.size();
  const std::size_t present =
      std::count_if(machine.actuators.begin(), machine.actuators.end(),
                    [](const auto& actuator) { return actuator.presence == Presence::kPresent; });
  words += ", " + (present == count ? "" : std::to_string(present) + " of ");
  return words + std::to_string(count) + (count == 1 ? " actuator" : " actuators");
}

}  // namespace musher::cli
