#include "musher/view/live/stop_beside.hpp"

#include <utility>

namespace musher::view {

std::string WhyNotStopped(const EstopReport& report) {
  std::string sentence;
  for (const EstopReport::Actuator& actuator : report.actuators) {
    if (actuator.stopped) continue;
    sentence += (sentence.empty() ? "not stopped: " : ", ") + actuator.name;
    if (!actuator.trouble.empty()) sentence += " (" + actuator.trouble + ")";
  }
  const auto add = [&sentence](const std::string& more) {
    sentence += (sentence.empty() ? "" : "; ") + more;
  };
  if (report.controller && !report.controller_latched) add("the controller has not latched it");
  if (const std::string lost = report.WhyNotHeld(); !lost.empty()) add(lost);
  if (!report.unknown.empty()) add(report.unknown);
  return sentence;
}

StopBeside::StopBeside(transport::Node& node, const MachinePlace& place, msg::EmergencyStop stop,
                       const Options& options)
    : place_(place), text_(place.Text(options.own.domain)), lan_(options.lan) {
  stop.machine = options.word;
  stop.machine_id.clear();
  if (!options.with_keys) HandOverStop(stop, place.domain, place.name_space);
  auto latch =
      StopLatch::Begin(node, place.name_space, stop, {options.with_keys, options.lan, {}, {}});
  if (!latch) {
    error_ = latch.error().message;
    return;
  }
  latch_ = std::move(latch).value();
  if (!options.word.empty()) latch_->AddBeginningOfId(options.word);
  LeaderWatch::Options watched{place.name_space, options.host, WatchByPidfd(node.loop())};
  watched.prefer_here = true;
  watched.word = options.word;
  auto leader = LeaderWatch::Make(
      node, std::move(watched), [](const auto&) {}, [](const auto&, const auto&) {});
  if (leader) leader_ = std::move(leader).value();
}

std::string StopBeside::WhyNot() const {
  const std::string where = "the machine of this host in " + text_ + ": ";
  if (!latch_) return where + "the emergency stop could not be sent: " + error_;
  const EstopReport report = latch_->Report(ViewFromHere(
      {place_.name_space, place_.domain, lan_}, leader_ ? leader_->leader() : std::nullopt));
  if (!report.controller) return where + "no controller confirms the stop";
  const std::string why = WhyNotStopped(report);
  return why.empty() ? "" : where + why;
}

}  // namespace musher::view
