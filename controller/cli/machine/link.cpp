#include "musher/controller/cli/machine/link.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "musher/base/host.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/cli/console/output_reader.hpp"
#include "musher/controller/cli/machine/silent_controller.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {

Link::Link(const GlobalOptions& global) : global_(global), signals_(TakeEndSignals()) {
  signal_watch_ = loop_.WhenReadable(signals_.get(), [this] {
    if (NextSignal(signals_) != 0) interrupted_ = true;
  });
}

Result<std::unique_ptr<Link>> Link::Open(const GlobalOptions& global) {
  std::unique_ptr<Link> link(new Link(global));
  if (auto joined = link->Join(); !joined) return joined.error();
  return link;
}

Result<> Link::Join() {
  transport::DdsOptions options;
  options.discovery = transport::DiscoveryTiming::kAtOnce;
  options.hidden = true;
  if (!global_.keys.empty()) {
    options.credentials =
        transport::Credentials{std::filesystem::absolute(global_.keys), global_.identity};
  }
  auto node = transport::MakeDdsNode(loop_, options);
  if (!node) return node.error();
  node_ = std::move(node).value();
  transport::SubscriptionEvents events;
  events.on_writer_lost = [this](transport::EndpointId writer) { machines_.erase(writer); };
  auto infos = transport::MakeSubscription<msg::MachineInfo>(
      *node_, std::string(transport::kMachinesTopic),
      [this](const msg::MachineInfo& machine, const transport::SampleInfo& info) {
        machines_[info.writer] = machine;
      },
      transport::kLatchedFromManyQos, std::move(events));
  if (!infos) return infos.error();
  machine_infos_ = std::move(infos).value();
  return Ok();
}

Result<> Link::FollowStatus(OnStatus on_change) {
  on_status_ = std::move(on_change);
  const auto take = [this](std::optional<msg::MachineStatus> status, transport::EndpointId writer) {
    status_ = std::move(status);
    if (status_) last_leader_ = status_;
    status_writer_ = writer;
    if (on_status_) on_status_(status_);
  };
  transport::SubscriptionEvents events;
  // A successor may publish before its predecessor is reported lost.
  events.on_writer_lost = [this, take](transport::EndpointId writer) {
    if (writer == status_writer_) take(std::nullopt, 0);
  };
  auto subscription = transport::MakeSubscription<msg::MachineStatus>(
      *node_, transport::MachineStatusTopic(global_.name_space),
      [this, take](const msg::MachineStatus& status, const transport::SampleInfo& info) {
        const bool older = status_ && status.epoch < status_->epoch;
        if (!older) take(status, info.writer);
      },
      transport::kLatchedFromManyQos, std::move(events));
  if (!subscription) return subscription.error();
  machine_status_ = std::move(subscription).value();
  return Ok();
}

const std::optional<msg::MachineStatus>& Link::StatusTowards(const std::string& target) {
  loop_.RunUntil([&] { return status_ && status_->target == target; }, loop_.Now() + discovery());
  return status_;
}

std::optional<Failure> Link::AwaitStatus() {
  const auto received = [this] { return status_.has_value(); };
  return Await(received, received, global_.timeout.value_or(discovery()));
}

bool Link::AwaitEndOf(const msg::MachineStatus& controller, Duration timeout) {
  const Time deadline = loop_.Now() + timeout;
  if (controller.host.empty() || controller.host != HostId()) {
    loop_.RunUntil([this] { return !status_ || interrupted_; }, deadline);
    return !status_;
  }
  const auto process = OpenPidfd(controller.pid);
  if (!process) return true;
  bool ended = false;
  const auto watch = loop_.WhenReadable(process.value().get(), [&ended] { ended = true; });
  loop_.RunUntil([&] { return ended || interrupted_; }, deadline);
  return ended;
}

bool Link::RunUntil(const std::function<bool()>& done, Duration timeout) {
  loop_.RunUntil([&] { return done() || interrupted_; }, loop_.Now() + timeout);
  return done();
}

void Link::RunUntilInterrupted(const Console& console) {
  const auto ended = [&] { return interrupted_ || !console.HasReader(); };
  while (!ended()) loop_.RunUntil(ended, loop_.Now() + std::chrono::hours(24));
}

void Link::EndWithReader() {
  reader_ = TakeReaderOf(STDOUT_FILENO);
  if (!reader_.valid()) return;
  reader_watch_ = loop_.WhenReadable(reader_.get(), [this] {
    interrupted_ = true;
    reader_watch_.reset();  // it stays readable
  });
}

std::optional<Failure> Link::Await(const std::function<bool()>& answered,
                                   const std::function<bool()>& found, Duration timeout) {
  const Time begin = loop_.Now();
  const auto ended = [&] { return answered() || interrupted_; };
  const auto met = [&] { return ended() || found() || HasMachine(); };
  loop_.RunUntil([&] { return ended() || found(); }, begin + std::min(discovery(), timeout));
  if (!met() && LeaderHere() != 0) {
    loop_.RunUntil(met, begin + std::min(discovery_of_one_here(), timeout));
  }
  if (!met()) return NotFound("controller");
  loop_.RunUntil(ended, begin + timeout);
  if (answered()) return std::nullopt;
  if (interrupted_) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  return NoAnswer(timeout);
}

bool Link::HasMachine() const {
  return std::any_of(machines_.begin(), machines_.end(), [this](const auto& machine) {
    return machine.second.name_space == global_.name_space;
  });
}

Failure Link::NotFound(const std::string& what) const {
  std::string message = "no " + what + " in " + NamespaceText(global_.name_space);
  if (const pid_t holder = LeaderHere(); holder != 0 && !HasMachine()) {
    message += fmt::format(" of DDS domain {} answers: ", transport::DomainId({}).value()) +
               WhySilent(ExamineSilent(holder, global_), global_);
  } else if (machines_.empty()) {
    message += fmt::format(
        " of DDS domain {}; `musher up FILE` starts one, --transport lan searches other hosts",
        transport::DomainId({}).value());
  } else {
    std::string found;
    for (const auto& [writer, machine] : machines_) {
      found += fmt::format("{}'{}' ({})", found.empty() ? "" : ", ", machine.name_space,
                           machine.machine);
    }
    const std::string& first = machines_.begin()->second.name_space;
    message += fmt::format("; found {} - use --namespace {}", found, first.empty() ? "''" : first);
  }
  return {ExitCode::kNoController, {kCodeNetError, message}};
}

pid_t Link::LeaderHere() const {
  return NameLock::HolderOf(NameLock::NameOf(transport::DomainId({}).value(), global_.name_space,
                                             "musher/controller"))
      .pid;
}

Failure Link::NoAnswer(Duration timeout) const {
  std::string controller = "the controller";
  for (const auto& [writer, machine] : machines_) {
    if (machine.name_space != global_.name_space) continue;
    controller = fmt::format("the controller of {} (pid {})", machine.machine, machine.pid);
  }
  std::string message =
      fmt::format("{} did not answer within {:g} s", controller, ToSeconds(timeout));
  const pid_t holder = LeaderHere();
  if (holder != 0 && RunStateOf(holder) == ProcessRunState::kStopped) {
    message += "; " + WhySilent(ExamineSilent(holder, global_), global_);
  }
  return {ExitCode::kNoAnswer, {kCodeTimeout, message}};
}

}  // namespace musher::cli
