// musher permit: permits the machine to move for as long as the command runs. Of a machine with
// [safety] permit_ms, which stops when the permits end: with the command, its terminal, its
// computer, or the link to the robot.

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "musher/base/host.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {
namespace {

constexpr Duration kPeriod = Milliseconds(50);  // a quarter of the shortest permit_ms
// Actuators of one process have one reader, and some do not answer.
constexpr Duration kAnnouncedWithin = std::chrono::seconds(1);

// Says when the machine is stopped, and when that is over.
class StopReport {
 public:
  explicit StopReport(Console& console) : console_(console) {}

  void Note(const msg::MachineStatus& status) {
    if (status.emergency_stop == engaged_) return;
    engaged_ = status.emergency_stop;
    if (console_.mode().json) return;
    console_.Print(engaged_
                       ? fmt::format("{} is stopped by {}: {}; `musher estop --release` ends that",
                                     status.machine, status.emergency_stop_by,
                                     status.emergency_stop_reason)
                       : status.machine + " is not stopped any more");
  }

 private:
  Console& console_;
  bool engaged_ = false;
};

// It goes on while the computer is suspended, as steady time does not: the permits of a laptop that
// has slept would be late by its sleep, for hours.
std::int64_t SinceBootNs() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
}

msg::Permit NewPermit(const msg::MachineStatus& machine, transport::Node& node) {
  msg::Permit permit;
  permit.machine = machine.machine;
  permit.machine_id = machine.machine_id;
  permit.participant = node.participant().value();
  permit.by = UserAtHost();
  return permit;
}

void Announce(const msg::MachineStatus& machine, Console& console) {
  const std::int64_t permit_ms = ToMilliseconds(Duration(machine.permit_ns));
  if (console.mode().json) {
    return console.Print(OrderedJson{
        {"machine", machine.machine},
        {"permit_ms", permit_ms},
        {"by", UserAtHost()}}.dump());
  }
  console.Print(
      fmt::format("{} may move while this command runs; it stops {} ms after the last permit "
                  "(Ctrl-C ends them)",
                  machine.machine, permit_ms));
}

ExitCode GivePermits(const GlobalOptions& global, Console& console) {
  const auto opened = Link::Open(global, &console);
  if (!opened) return console.Fail(opened.error());
  Link& link = *opened.value();
  if (const auto failure = link.ChooseMachine(Link::Purpose::kAct)) return console.Fail(*failure);
  StopReport stops(console);
  bool announced = false;
  const auto followed = link.FollowStatus([&](const std::optional<msg::MachineStatus>& status) {
    if (announced && status) stops.Note(*status);
  });
  if (!followed) return console.Fail(followed.error());
  if (const auto failure = link.AwaitStatus()) return console.Fail(*failure);
  const msg::MachineStatus machine = *link.status();
  if (machine.permit_ns == 0) {
    return console.Fail(
        {ExitCode::kNotDone,
         {kCodeStateInvalid, machine.machine + " needs no permit to move: its config has no "
                                               "permit_ms in [safety]"}});
  }
  const auto publisher = transport::MakePublisher<msg::Permit>(
      link.node(), transport::PermitTopic(machine.name_space), transport::kHeartbeatQos);
  if (!publisher) return console.Fail(publisher.error());
  msg::Permit permit = NewPermit(machine, link.node());
  const auto give = [&] {
    permit.stamp_ns = SinceBootNs();
    static_cast<void>(publisher.value()->Publish(permit));  // the next one follows
  };
  give();
  const auto timer = link.loop().Every(kPeriod, give);
  // It is said once they arrive: a stop that is released before that is followed by the next one.
  const auto present =
      std::ranges::count(machine.actuators, "present", &msg::ActuatorInfo::presence);
  link.RunUntil([&] { return publisher.value()->MatchedReaders() >= present; }, kAnnouncedWithin);
  Announce(machine, console);
  announced = true;
  stops.Note(machine);
  link.RunUntilInterrupted(console);
  return ExitCode::kDone;
}

}  // namespace

void AddPermit(Grammar& grammar) {
  grammar.Add("permit", "Permit the machine to move while this command runs ([safety] permit_ms)",
              GivePermits, "musher permit");
}

}  // namespace musher::cli
