#include "musher/cli/start/service_manager.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "musher/base/joined.hpp"
#include "musher/cli/console/console.hpp"

namespace musher::cli {
namespace {

constexpr int kPingsInAPeriod = 3;
constexpr Duration kExitTime = Milliseconds(5000);  // of the process, after the machine has stopped

// The watchdog period of systemd. It applies to the main process, our parent.
std::optional<Duration> WatchdogPeriod() {
  const char* pid = std::getenv("WATCHDOG_PID");  // NOLINT(concurrency-mt-unsafe)
  const bool ours =
      pid == nullptr || pid == std::to_string(getpid()) || pid == std::to_string(getppid());
  const char* period = std::getenv("WATCHDOG_USEC");  // NOLINT(concurrency-mt-unsafe)
  if (!ours || period == nullptr) return std::nullopt;
  const std::string_view text = period;
  std::int64_t period_us = 0;
  const auto [end, error] = std::from_chars(text.begin(), text.end(), period_us);
  const bool number = error == std::errc() && end == text.end();
  if (!number || period_us < kPingsInAPeriod) return std::nullopt;
  constexpr auto kLongest = std::chrono::duration_cast<std::chrono::microseconds>(Duration::max());
  return std::min(std::chrono::microseconds(period_us), kLongest);
}

std::string Microseconds(Duration duration) {
  return std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(duration).count());
}

}  // namespace

ServiceManager::ServiceManager(transport::EventLoop& loop, const MachineConfig& config)
    : config_(config), notifier_(loop) {
  if (!notifier_.enabled()) return;
  const auto period = WatchdogPeriod();
  if (period) watchdog_ = loop.Every(*period / kPingsInAPeriod, [this] { notifier_.Ping(); });
}

void ServiceManager::StartUpEnded(const action::StartUpEnded& ended) {
  if (ended.usable) return notifier_.Notify("READY=1");
  Status(ended.message);
}

void ServiceManager::StandsBy(const std::string& why) {
  notifier_.Notify("READY=1");
  Status("stands by: " + why);
}

void ServiceManager::Update(const Machine& machine) {
  const bool stops = machine.phase == Phase::kStopping || machine.phase == Phase::kStopped;
  if (stops && !stopping_) {
    stopping_ = true;
    // systemd counts a service that exits before READY as failed and would restart it.
    if (machine.start_up.finishing) notifier_.Notify("READY=1");
    // The unit's own TimeoutStopSec may be shorter.
    notifier_.Notify("STOPPING=1\nEXTEND_TIMEOUT_USEC=" +
                     Microseconds(config_.shutdown_budget + kExitTime));
  }
  // After a failed start STATUS keeps the reason.
  if (machine.phase != Phase::kFailed) Status(StatusWords(config_, machine));
}

void ServiceManager::Fenced(const std::string& why) {
  stopping_ = true;
  notifier_.Notify("STOPPING=1");
  Status(why);
}

void ServiceManager::Status(const std::string& words) {
  if (words == sent_status_) return;
  sent_status_ = words;
  notifier_.Notify("STATUS=" + Printable(words));  // systemd takes one line
}

std::string StatusWords(const MachineConfig& config, const Machine& machine) {
  std::string words;
  if (machine.phase != Phase::kRunning) words = std::string(PhaseName(machine.phase)) + ", ";
  words += machine.state;
  const std::string degraded = Joined(Degraded(config, machine));
  if (!degraded.empty()) return words + ", degraded: " + degraded;
  const std::size_t count = config.actuators.size();
  const std::size_t present =
      std::count_if(machine.actuators.begin(), machine.actuators.end(),
                    [](const auto& actuator) { return actuator.presence == Presence::kPresent; });
  words += ", " + (present == count ? "" : std::to_string(present) + " of ");
  return words + std::to_string(count) + (count == 1 ? " actuator" : " actuators");
}

}  // namespace musher::cli
