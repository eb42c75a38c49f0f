#include "musher/cli/machine/link.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "musher/base/host.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/console/output_reader.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/machine/machines_beside.hpp"
#include "musher/cli/machine/silent_controller.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {
namespace {

constexpr Duration kOthersWithin = Milliseconds(300);  // after the first that is discovered
// A controller that is stopped, as by SIGSTOP, answers no request that may take a minute.
constexpr Duration kStoppedWithin = std::chrono::seconds(5);

// A HostId() is "BOOT/PID NAMESPACE".
bool IsOfThisBoot(const msg::MachineInfo& info) {
  const std::string host = HostId();
  return !host.empty() && info.host.starts_with(host.substr(0, host.find('/')));
}

// What answers after the search may be another machine, which a command must not act on.
std::optional<Failure> NoneFound(const Link& link, Link::Purpose purpose) {
  if (purpose == Link::Purpose::kLook) return std::nullopt;
  if (link.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  return link.NotFound("controller");
}

}  // namespace

Link::Link(const GlobalOptions& global, Console* console)
    : global_(global), console_(console), signals_(TakeEndSignals()) {
  signal_watch_ = loop_.WhenReadable(signals_.get(), [this] {
    if (NextSignal(signals_) != 0) interrupted_ = true;
  });
}

Result<std::unique_ptr<Link>> Link::Open(const GlobalOptions& global, Console* console) {
  std::unique_ptr<Link> link(new Link(global, console));
  if (auto joined = link->Join(); !joined) return joined.error();
  return link;
}

Result<std::unique_ptr<Link>> Link::OpenAtOnce(const GlobalOptions& global, Console* console,
                                               const std::string& network) {
  std::unique_ptr<Link> link(new Link(global, console));
  if (auto joined = link->JoinBy(network); !joined) return joined.error();
  return link;
}

std::unique_ptr<Link> Link::OpenForCalls(const GlobalOptions& global, Console* console) {
  return std::unique_ptr<Link>(new Link(global, console));
}

// The user's own settings of Cyclone name their interfaces themselves.
std::vector<std::string> Link::SeparateNetworks(const GlobalOptions& global) {
  const char* settings = std::getenv("CYCLONEDDS_URI");  // NOLINT(concurrency-mt-unsafe)
  const auto profile = transport::Profile({});
  if (!profile || (settings != nullptr && *settings != '\0')) return {};
  auto networks = transport::OuterInterfaces(profile.value(), global.interfaces);
  if (networks.size() < 2) networks.clear();
  return networks;
}

Result<> Link::Join() {
  if (node_) return Ok();
  auto joined = JoinBy({});
  if (!joined && SeparateNetworks(global_).empty()) return joined;
  if (const auto domain = transport::DomainId({}); !domain) return domain.error();
  const bool here = global_.machine.empty() && NameLock::IsHeld(ControllerName());
  return here ? joined : JoinByEachNetwork();
}

// By one after the other, until a machine answers that may be meant; by all if none does. One that
// cannot be joined does not answer.
Result<> Link::JoinByEachNetwork() {
  const std::vector<std::string> networks = SeparateNetworks(global_);
  if (networks.empty()) return Ok();
  const Time end = loop_.Now() + global_.timeout.value_or(std::chrono::hours(1));
  const auto met = [&] {
    return machine_infos_ && IsAnsweredWithin(std::min(discovery(), end - loop_.Now()));
  };
  if (met()) return Ok();
  for (const std::string& network : networks) {
    if (interrupted_ || loop_.Now() >= end) break;
    Leave();
    if (const auto joined = JoinBy(network); joined && met()) return Ok();
  }
  Leave();
  return JoinBy({});
}

// That it is discovered shows only that its samples arrive here.
bool Link::IsAnsweredWithin(Duration limit) {
  const Time end = loop_.Now() + limit;
  if (!RunUntil([this] { return !Candidates().empty(); }, limit)) return false;
  const auto client = transport::MakeClient<msg::GetStatus>(
      *node_, transport::MachineService(global_.name_space, "get_status"));
  if (!client) return false;
  bool answered = false;
  for (const Found& one : Candidates()) {
    client.value()->Call(
        {}, limit, [&answered](const auto& reply) { answered |= reply.ok(); }, one.participant);
  }
  return RunUntil([&answered] { return answered; }, end - loop_.Now());
}

void Link::Leave() {
  machine_infos_.reset();
  node_.reset();
  machines_.clear();
}

// Empty: by all networks.
Result<> Link::JoinBy(const std::string& network) {
  transport::DdsOptions options;
  options.discovery = transport::DiscoveryTiming::kAtOnce;
  options.hidden = true;
  options.interfaces = network.empty() ? global_.interfaces : std::vector{network};
  options.own_networks_only = !network.empty();
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
        if (!transport::IsOwn(machine.participant, info)) return;
        machines_[info.writer] = {machine, info.participant};
        TakeNamed();
      },
      transport::kLatchedFromManyQos, std::move(events));
  if (!infos) return infos.error();
  machine_infos_ = std::move(infos).value();
  return Ok();
}

// With --machine another machine may be meant; one that was chosen by the network is kept; with
// credentials DDS knows what they permit.
std::string Link::HostCallsName() const {
  const auto domain = transport::DomainId({});
  if (!global_.machine.empty() || !global_.keys.empty() || chosen_ || !domain) return "";
  return NameLock::NameOf(domain.value(), global_.name_space, "musher/calls");
}

bool Link::CallsHere() const {
  const std::string name = HostCallsName();
  return !name.empty() && ConnectTo(name).valid();
}

std::optional<std::variant<msg::Bytes, Failure>> Link::CallHere(const std::string& service,
                                                                const msg::Bytes& request,
                                                                Duration timeout, ExitCode lost) {
  const std::string name = HostCallsName();
  if (name.empty()) return std::nullopt;
  std::optional<Result<msg::Bytes>> reply;
  const auto call = transport::HostCall::Make(
      loop_, name, service, request,
      [&reply](Result<msg::Bytes> received) { reply = std::move(received); });
  if (!call) return std::nullopt;
  const auto answered = [&reply] { return reply.has_value(); };
  Duration left = timeout;
  if (timeout > kStoppedWithin && !global_.timeout && !RunUntil(answered, kStoppedWithin)) {
    const bool stopped = RunStateOf(call->server()) == ProcessRunState::kStopped;
    if (stopped && !interrupted_) return NoAnswer(kStoppedWithin);
    left -= kStoppedWithin;
  }
  if (!reply) RunPatiently(answered, left);
  if (!reply && interrupted_) {
    return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  }
  if (!reply) return NoAnswer(timeout);
  if (*reply) return std::move(*reply).value();
  if (reply->error().code == kCodeUnSupport) return std::nullopt;
  if (reply->error().code != kCodeNetError) {
    return Failure{ExitCode::kNoAnswer,
                   {reply->error().code, "the controller: " + reply->error().message}};
  }
  return Failure{
      lost,
      {kCodeNetError,
       fmt::format("the controller (pid {}) has exited before it answered", call->server())}};
}

Result<> Link::FollowStatus(OnStatus on_change) {
  if (auto joined = Join(); !joined) return joined.error();
  if (const auto failure = ChooseMachine()) return failure->error;
  on_status_ = std::move(on_change);
  return Follow();
}

Result<> Link::Follow() {
  LeaderWatch::Options leader{global_.name_space, HostId(), WatchByPidfd(loop_)};
  leader.machine = machine_;
  const auto take = [this](const msg::MachineStatus& last, bool leads) {
    last_leader_ = last;
    status_.reset();
    if (leads) status_ = last;
    if (on_status_) on_status_(status_);
  };
  auto watch = LeaderWatch::Make(
      *node_, std::move(leader), [take](const msg::MachineStatus& status) { take(status, true); },
      [take](const msg::MachineStatus& status, const std::string&) { take(status, false); });
  if (!watch) return watch.error();
  leader_ = std::move(watch).value();
  return Ok();
}

void Link::Choose(MachineIdentity machine) {
  machine_ = std::move(machine);
  chosen_ = true;
}

void Link::ChooseOnceFound() {
  machine_ = {global_.machine, ""};
  chosen_ = true;
  open_ = true;
  TakeNamed();
}

// Once one is discovered. By its name it is followed already.
void Link::TakeNamed() {
  const std::vector<Found> named = open_ ? Candidates() : std::vector<Found>();
  if (named.empty()) return;
  open_ = false;
  if (named.front().info.machine == global_.machine) return;
  machine_ = named.front().machine();
  if (!leader_) return;
  // Not inside the callback of the subscription that has discovered it.
  follow_ = loop_.At(loop_.Now(), [this] { static_cast<void>(Follow()); });
}

std::optional<Failure> Link::ChooseMachine(Purpose purpose) {
  if (chosen_) return open_ || machine_.name.empty() ? NoneFound(*this, purpose) : std::nullopt;
  if (auto joined = Join(); !joined) return Failure{ExitCode::kUsage, joined.error()};
  chosen_ = true;
  const Duration limit = global_.timeout.value_or(std::chrono::hours(1));
  const Duration here_within = std::min(discovery_of_one_here(), limit);
  if (!global_.machine.empty()) {
    if (IsNamedHere() && ChooseHere(here_within)) return std::nullopt;
    searched_ = !RunUntil([this] { return !Candidates().empty(); }, std::min(discovery(), limit));
    // Two of one name are discovered one after the other.
    const auto several = [this] { return !AreOne(Candidates()); };
    if (!searched_) RunUntil(several, std::min(kOthersWithin, limit));
    auto failure = ChooseNamed();
    return failure || !open_ ? failure : NoneFound(*this, purpose);
  }
  if (NameLock::IsHeld(ControllerName()) && ChooseHere(here_within)) return std::nullopt;
  const auto any = [this] { return !Candidates().empty(); };
  searched_ = !RunUntil(any, std::min(discovery(), limit));
  if (searched_) return NoneFound(*this, purpose);
  const auto here = [this] {
    const std::vector<Found> found = Candidates();
    return std::any_of(found.begin(), found.end(),
                       [](const Found& one) { return one.info.host == HostId(); });
  };
  // Machines of other hosts are discovered one after the other.
  if (!here()) RunUntil(here, std::min(kOthersWithin, limit));
  return ChooseOf(Candidates(), purpose);
}

// A controller of this host leads, so no other machine is meant, even while it does not answer. The
// processes of another user, or container, cannot be inspected: then its computer has to do. False:
// that controller has ended meanwhile, and another one that answers may be of another machine.
bool Link::ChooseHere(Duration limit) {
  const std::string name = ControllerName();
  bool proven = true;
  bool ended = false;
  const auto found = [&] {
    ended = !NameLock::IsHeld(name);
    if (ended) return true;
    for (const Found& one : Candidates()) {
      if (proven && one.info.host != HostId()) continue;
      if (proven ? !NameLock::CheckHolder(name, one.info.pid) : !IsOfThisBoot(one.info)) continue;
      machine_ = one.machine();
      return true;
    }
    return false;
  };
  if (RunUntil(found, std::min(kOthersWithin, limit))) return !ended;
  proven = false;
  if (RunPatiently(found, limit)) return !ended;
  searched_ = true;
  const auto origin = OriginOfProcess(LeaderHere());
  machine_ = {origin ? origin->name : "the machine of this host", origin ? origin->id : ""};
  return true;
}

// Whether --machine names the machine whose controller runs on this host. Then it is meant, also
// where another one of that name answers, such as a copy of this robot. By the files of that
// controller, which take no discovery.
bool Link::IsNamedHere() const {
  const auto here = OriginHere(transport::DomainId({}).value(), global_.name_space);
  return here && IsNamed({here->name, here->id});
}

std::optional<Failure> Link::ChooseNamed() {
  std::vector<Found> named = Candidates();
  if (named.empty()) {
    ChooseOnceFound();
    return std::nullopt;
  }
  if (!AreOne(named)) return OpenChoice(named, "several machines are named " + global_.machine);
  machine_ = named.front().machine();
  return std::nullopt;
}

// Of several machines the one of this host; without a controller here, that of the actuators here.
std::optional<Failure> Link::ChooseOf(const std::vector<Found>& candidates, Purpose purpose) {
  if (candidates.empty()) return NoneFound(*this, purpose);
  for (const Found& one : candidates) {
    if (one.info.host != HostId()) continue;
    machine_ = one.machine();
    return std::nullopt;
  }
  if (auto here = MachineOfActuatorsHere()) {
    // Actuators that have sent no status yet are those of the files here, or of a machine that is
    // not known: not of whichever machine answers.
    if (here->name.empty()) here = MachineOfFilesHere(global_).value_or(*here);
    for (const Found& one : candidates) {
      if (here->name.empty() || !SameMachine(one.machine(), *here)) continue;
      machine_ = one.machine();
      return std::nullopt;
    }
    Failure failure = OpenChoice(
        candidates, "actuators of " + (here->name.empty() ? "a machine" : MachineText(*here)) +
                        " run on this host, but no controller of it answers");
    failure.exit = ExitCode::kNoController;
    return failure;
  }
  if (!AreOne(candidates)) {
    return OpenChoice(candidates, "several machines answer in " +
                                      NamespaceText(global_.name_space) +
                                      ", none of them on this host");
  }
  return ChooseElsewhere(candidates, purpose);
}

// Nothing of a machine runs on this host. A robot whose controller has ended is still the one that
// a command on it means.
std::optional<Failure> Link::ChooseElsewhere(const std::vector<Found>& candidates,
                                             Purpose purpose) {
  const MachineIdentity other = candidates.front().machine();
  const auto here = MachineOfFilesHere(global_);
  const bool another = here && !SameMachine(*here, other);
  const auto beside =
      here && !another ? std::vector<MachineBeside>() : MachinesBeside(global_, here);
  if (!beside.empty() && purpose == Purpose::kAct) {
    return Failure{ExitCode::kNoController,
                   {kCodeNetError, beside.front().InsteadOf(TextOf(candidates), global_)}};
  }
  if (another && purpose == Purpose::kAct) return NotHere(*here, TextOf(candidates));
  machine_ = other;
  if (another && beside.empty() && console_ != nullptr) {
    console_->PrintError("the machine of this host, " + MachineText(*here) +
                         ", does not run; this is " + TextOf(candidates));
  } else if (!beside.empty() && console_ != nullptr) {
    console_->PrintError(beside.front().Text(global_) + "; this is " + TextOf(candidates));
  }
  return std::nullopt;
}

Failure Link::NotHere(const MachineIdentity& here, const std::string& others) const {
  return {ExitCode::kNoController,
          {kCodeNetError, "the machine of this host, " + MachineText(here) + ", does not run in " +
                              NamespaceText(global_.name_space) + "; found " + others +
                              ". Nothing was done; --machine NAME speaks to another machine"}};
}

// Of the actuators whose processes run on this host; an empty one if they send no status; nullopt
// if there are none.
std::optional<MachineIdentity> Link::MachineOfActuatorsHere() {
  const std::string prefix =
      NameLock::NameOf(transport::DomainId({}).value(), global_.name_space, "");
  if (NameLock::HeldBelow(prefix).empty()) return std::nullopt;
  std::optional<MachineIdentity> machine;
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(!global_.keys.empty());
  const auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      *node_, transport::ActuatorStatusTopic(global_.name_space),
      [&machine](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
        if (status.host == HostId() && transport::IsFrom(status, info))
          machine = {status.machine, status.machine_id};
      },
      qos);
  if (statuses) RunUntil([&machine] { return machine.has_value(); }, kOthersWithin);
  return machine ? machine : MachineIdentity{};
}

bool Link::AreOne(const std::vector<Found>& candidates) {
  return std::ranges::all_of(candidates, [&](const Found& one) {
    return SameMachine(one.machine(), candidates.front().machine());
  });
}

std::string Link::TextOf(const std::vector<Found>& candidates) {
  std::string found;
  for (const Found& one : candidates) {
    const std::string text =
        fmt::format("{}, pid {} of {}", MachineText(one.machine()), one.info.pid,
                    one.info.host == HostId() ? "this host" : "another host");
    if (found.find(text) == std::string::npos) found += (found.empty() ? "" : "; ") + text;
  }
  return found;
}

Failure Link::OpenChoice(const std::vector<Found>& candidates, const std::string& what) {
  return {ExitCode::kUsage,
          {kCodeTargetBusy, what + ": " + TextOf(candidates) +
                                ". Nothing was done; --machine NAME speaks to one of them"}};
}

std::vector<Link::Found> Link::Candidates() const {
  std::vector<Found> candidates;
  for (const auto& [writer, found] : machines_) {
    if (found.info.name_space != global_.name_space || !IsNamed(found.machine())) continue;
    candidates.push_back(found);
  }
  return candidates;
}

bool Link::IsNamed(const MachineIdentity& machine) const {
  const std::string& meant = global_.machine;
  return meant.empty() || machine.name == meant || BeginsIdOf(machine, meant);
}

bool Link::Speaks(const MachineIdentity& machine) const {
  return open_ ? IsNamed(machine) : SameMachine(machine_, machine);
}

transport::ParticipantId Link::Leader() const {
  if (machine_.name.empty()) return 0;
  for (const Found& found : Candidates()) {
    if (Speaks(found.machine())) return found.participant;
  }
  return 0;
}

const std::optional<msg::MachineStatus>& Link::StatusTowards(const std::string& target) {
  loop_.RunUntil([&] { return status_ && status_->target == target; }, loop_.Now() + discovery());
  return status_;
}

std::optional<Failure> Link::AwaitStatus() {
  const auto received = [this] { return status_.has_value(); };
  const Duration limit = LeaderHere() != 0 ? discovery_of_one_here() : discovery();
  return Await(received, received, global_.timeout.value_or(limit));
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

pid_t Link::SpokenToHere() const {
  for (const Found& one : Candidates()) {
    if (Speaks(one.machine())) return one.info.host == HostId() ? one.info.pid : 0;
  }
  return global_.machine.empty() ? LeaderHere() : 0;
}

bool Link::RunPatiently(const std::function<bool()>& done, Duration timeout) {
  const Duration unwatched = std::max(timeout - kShortageWindow, Duration{});
  if (RunUntil(done, unwatched) || interrupted_) return done();
  const Time latest = loop_.Now() + kShortageWindow + kLongestShortage;
  const pid_t controller = SpokenToHere();
  ShortageSample before = SampleShortage(controller, loop_.Now());
  Duration window = std::min(timeout, kShortageWindow);
  while (!RunUntil(done, window)) {
    if (interrupted_ || global_.timeout || controller == 0 || loop_.Now() >= latest) return false;
    ShortageSample after = SampleShortage(controller, loop_.Now());
    const CpuShortage shortage = FindShortage(before, after);
    if (shortage == CpuShortage::kNone) return false;
    ReportShortage(controller, shortage);
    before = std::move(after);
    window = kShortageWindow;
  }
  return true;
}

void Link::ReportShortage(pid_t controller, CpuShortage shortage) {
  if (console_ == nullptr || std::exchange(shortage_reported_, true)) return;
  console_->PrintError(
      shortage == CpuShortage::kOfController
          ? fmt::format("the controller (pid {}) is short of CPU time; waiting", controller)
          : fmt::format("this host is short of CPU time; waiting for the controller (pid {})",
                        controller));
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
  const Duration search = searched_ ? Duration{} : discovery();
  loop_.RunUntil([&] { return ended() || found(); }, begin + std::min(search, timeout));
  if (!met() && !searched_ && LeaderHere() != 0) {
    RunPatiently(met, begin + std::min(discovery_of_one_here(), timeout) - loop_.Now());
  }
  if (!met()) return NotFound("controller");
  RunPatiently(answered, begin + timeout - loop_.Now());
  if (answered()) return std::nullopt;
  if (interrupted_) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  return NoAnswer(
      std::max<Duration>(timeout, std::chrono::floor<std::chrono::seconds>(loop_.Now() - begin)));
}

bool Link::LeaderIsLost() const {
  return last_leader_ && !status_;
}

Failure Link::LostBeforeItAnswered() const {
  return {ExitCode::kNoController,
          {kCodeNetError, fmt::format("the controller (pid {}) was lost before it answered",
                                      last_leader_ ? last_leader_->pid : 0)}};
}

bool Link::HasMachine() const {
  const std::vector<Found> candidates = Candidates();
  return std::any_of(candidates.begin(), candidates.end(),
                     [this](const Found& found) { return Speaks(found.machine()); });
}

bool Link::HasOtherMachine() const {
  const std::vector<Found> candidates = Candidates();
  return std::any_of(candidates.begin(), candidates.end(),
                     [this](const Found& found) { return !Speaks(found.machine()); });
}

// "; found 'dogs' (dog), '' (cat) - use --namespace dogs": how to speak to one of them, and with
// --machine to none that it does not mean.
std::string Link::OthersText() const {
  std::string found;
  const Found* to_use = nullptr;
  for (const auto& [writer, one] : machines_) {
    found += fmt::format("{}'{}' ({})", found.empty() ? "" : ", ", one.info.name_space,
                         one.info.machine);
    if (to_use == nullptr && IsNamed(one.machine())) to_use = &one;
  }
  std::string use;
  if (to_use != nullptr) {
    const std::string& name_space = to_use->info.name_space;
    use = name_space == global_.name_space ? " - use --machine " + to_use->info.machine
                                           : " - use --namespace " + ShellWord(name_space);
  }
  return "; found " + found + use;
}

Failure Link::NotFound(const std::string& what) const {
  std::string message = "no " + what + " in " + NamespaceText(global_.name_space);
  if (!global_.machine.empty())
    message = "no " + what + " of machine " + global_.machine + " in " +
              NamespaceText(global_.name_space);
  const pid_t holder = global_.machine.empty() ? LeaderHere() : 0;
  if (global_.machine.empty() && holder == 0 && !machine_.name.empty()) {
    message =
        "no " + what + " of " + MachineText(machine_) + " in " + NamespaceText(global_.name_space);
  }
  const auto beyond = holder == 0 && !HasMachine() ? FindInOtherNetwork(global_) : std::nullopt;
  if (holder != 0 && !HasMachine()) {
    message += fmt::format(" of DDS domain {} answers: ", transport::DomainId({}).value()) +
               WhySilent(ExamineSilent(holder, global_), global_);
  } else if (beyond) {
    message += " is reached from here: " + beyond->Text();
  } else if (const auto here = MachinesBeside(global_); !here.empty() && here.front().runs) {
    message += "; " + here.front().Text(global_) + " - use " +
               here.front().place.Options(PlaceOf(global_));
  } else if (const auto other = global_.machine.empty() ? std::nullopt : SilentHere()) {
    message += "; " + *other;
  } else if (machines_.empty()) {
    message += fmt::format(
        " of DDS domain {}; `musher up FILE` starts one, --transport lan searches other hosts",
        transport::DomainId({}).value());
  } else {
    message += OthersText();
  }
  return {ExitCode::kNoController, {kCodeNetError, message}};
}

// The machine whose controller leads here and answers nothing, for a person who has named another
// one.
std::optional<std::string> Link::SilentHere() const {
  const pid_t holder = LeaderHere();
  const auto origin = holder == 0 ? std::nullopt : OriginOfProcess(holder);
  if (!origin || !machines_.empty()) return std::nullopt;
  return MachineText({origin->name, origin->id}) + " leads here (pid " + std::to_string(holder) +
         "), and does not answer";
}

pid_t Link::LeaderHere() const {
  return NameLock::HolderOf(ControllerName()).pid;
}

std::string Link::ControllerName() const {
  return NameLock::NameOf(transport::DomainId({}).value(), global_.name_space, "musher/controller");
}

Failure Link::NoAnswer(Duration timeout) const {
  const pid_t holder = LeaderHere();
  std::string controller =
      holder == 0 ? "the controller" : fmt::format("the controller (pid {})", holder);
  for (const Found& one : Candidates()) {
    if (!Speaks(one.machine())) continue;
    controller = fmt::format("the controller of {} (pid {})", one.info.machine, one.info.pid);
  }
  std::string message =
      fmt::format("{} did not answer within {:g} s", controller, ToSeconds(timeout));
  if (holder != 0 && RunStateOf(holder) == ProcessRunState::kStopped) {
    message += "; " + WhySilent(ExamineSilent(holder, global_), global_);
  }
  return {ExitCode::kNoAnswer, {kCodeTimeout, message}};
}

}  // namespace musher::cli
