// musher estop [REASON...]: engages an emergency stop, with or without a controller, and prints
// which actuators have stopped. A stop that not every actuator has confirmed stays published after
// the command's end. musher estop --release: releases it; that alone moves nothing.

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <sstream>

#include "musher/base/host.hpp"
#include "musher/base/user.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/printable.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/machine/machines_beside.hpp"
#include "musher/cli/machine/silent_controller.hpp"
#include "musher/cli/machine/stop_target.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/controller/client/detached_publisher.hpp"
#include "musher/controller/client/stop_latch.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/controller/storage/machines_here.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

struct EstopOptions {
  std::vector<std::string> reason;  // words
  bool release = false;
};

constexpr Duration kStopTimeout = std::chrono::seconds(5);
constexpr Duration kLanStopTimeout = std::chrono::seconds(10);  // a bad link delays discovery
constexpr Duration kFirstTry = std::chrono::seconds(1);  // then the other process publishes, too
constexpr Duration kOthersWithin = Milliseconds(300);    // after the first machine that is meant
constexpr Duration kSaved = std::chrono::seconds(1);     // a save takes less on a disk that works

// It waits for no discovery: without an id --machine may be a name, or the beginning of an id that
// is not known yet.
MachineIdentity TargetOf(const GlobalOptions& global) {
  const int domain = transport::DomainId({}).value();
  StopBelief belief;
  belief.word = global.machine;
  if (const auto led = OriginHere(domain, global.name_space)) belief.led = {led->name, led->id};
  if (belief.word.empty() && !belief.led) {
    const std::string names = NameLock::NameOf(domain, global.name_space, "");
    belief.runs_here =
        NameLock::IsHeld(names + "musher/controller") || !NameLock::HeldBelow(names).empty();
    if (!belief.runs_here) belief.of_files = MachineOfFilesHere(global);
  }
  return MachineToStop(belief);
}

void Address(msg::EmergencyStop& stop, const MachineIdentity& machine) {
  stop.machine = machine.name;
  stop.machine_id = machine.id;
}

// With credentials the stop goes by DDS only, which knows what they permit: an observer may look,
// and nothing else.
void HandOver(const msg::EmergencyStop& stop, const GlobalOptions& global) {
  if (!global.keys.empty()) return;
  const auto domain = transport::DomainId({});
  if (domain) HandOverStop(stop, domain.value(), global.name_space);
}

// The options with which the command reaches every host of the machine: of its own config, where
// the environment and the command line say nothing else. A person who stops a robot on it does not
// think of a profile.
GlobalOptions Reach(const GlobalOptions& global, const MachineIdentity& machine,
                    const std::vector<MachineHere>& machines) {
  GlobalOptions options = global;
  const auto here =
      NameLock::HeldBelow(NameLock::NameOf(transport::DomainId({}).value(), global.name_space, ""));
  const StopReach reach = ReachOf(machine, global.machine, machines, here);
  if (!reach.lan) return options;
  const char* profile = std::getenv("MUSHER_TRANSPORT");  // NOLINT(concurrency-mt-unsafe)
  if (profile == nullptr || *profile == '\0') setenv("MUSHER_TRANSPORT", "lan", /*replace=*/1);
  if (options.interfaces.empty()) options.interfaces = reach.interfaces;
  return options;
}

// A stop, and for whom it is.
struct Stop {
  msg::EmergencyStop message;
  std::string id_begins;               // --machine; empty: not given
  std::vector<MachineIdentity> by_id;  // of this host, whose id begins so
  bool only_now = false;               // not for a machine that is found after the command

  Result<std::unique_ptr<StopLatch>> Publish(transport::Node& node, const GlobalOptions& global,
                                             DetachedPublisher::Notes notes = {}) const {
    StopOptions options;
    options.with_keys = !global.keys.empty();
    options.lan = transport::ReachesOtherHosts();
    options.notes = std::move(notes);
    auto latch = StopLatch::Begin(node, global.name_space, message, std::move(options));
    if (latch && !id_begins.empty()) latch.value()->AddBeginningOfId(id_begins, by_id);
    return latch;
  }
};

// What a process of its own does, without the signals and the terminal of the command. By `network`
// alone; empty: by all.
DetachedPublisher::Publish PublishForAMinute(const GlobalOptions& global, const Stop& stop,
                                             const std::string& network = {}) {
  return [&global, &stop, network](const DetachedPublisher::Notes& notes) -> bool {
    const auto link = Link::OpenAtOnce(global, nullptr, network);
    if (!link) return false;
    const auto latch = stop.Publish(link.value()->node(), global, notes);
    if (!latch) _exit(1);
    link.value()->RunUntil([&] { return latch.value()->withdrawn(); },
                           DetachedPublisher::kKeptPublished);
    _exit(latch.value()->withdrawn() ? 0
                                     : 1);  // DDS waits for ever to leave a network that is lost
  };
}

// Waits until every actuator of the machine has latched the stop.
class Confirmation {
 public:
  Confirmation(Link& link, const StopLatch& latch, const GlobalOptions& global,
               std::vector<MachineHere> machines)
      : link_(link),
        latch_(latch),
        scope_{global.name_space, transport::DomainId({}).value(), transport::ReachesOtherHosts(),
               std::move(machines)} {}

  Duration DefaultTimeout() const { return scope_.lan ? kLanStopTimeout : kStopTimeout; }

  EstopReport Report() const { return latch_.Report(View()); }

  // The controller saves the stop after it has published it.
  void AwaitSaved() {
    if (!Report().complete()) return;
    link_.RunUntil([this] { return Report().not_on_disk.empty(); }, kSaved);
  }

  // Another machine that is meant is discovered after the first one.
  void AwaitOthers(Duration timeout) {
    if (!Report().controller) return;
    link_.RunUntil([] { return false; },
                   std::min(kOthersWithin, begun_ + timeout - link_.loop().Now()));
  }

  // Whether waiting brings no more within `timeout`: every actuator that can latch the stop has, or
  // the stop is released.
  bool AwaitComplete(Duration timeout) {
    return link_.RunUntil(
        [this] {
          const EstopReport report = Report();
          const bool all_known = report.controller || (report.found() && report.complete());
          return latch_.withdrawn() || (all_known && report.settled());
        },
        timeout);
  }

  void Await(Duration timeout) {
    const Time end = begun_ + timeout;
    const auto left = [&] { return end - link_.loop().Now(); };
    const auto led = [this] {
      return latch_.withdrawn() || (Report().controller && Report().settled());
    };
    if (link_.RunUntil(led, std::min(link_.discovery(), timeout))) return;
    if (link_.interrupted()) return;
    const bool none = !HasController() && !Report().found();
    if (none && link_.HasOtherMachine()) return;  // which is not meant
    if (scope_.lan || Report().controller || HasController()) {
      // An actuator that does not stop is reported in time.
      if (HasController()) link_.RunPatiently([this] { return Report().controller; }, left());
      const bool late = left() < -kShortageWindow / 2;  // it was waited for longer
      link_.RunUntil(led, late ? link_.discovery() : left());
    } else if (Report().found()) {
      link_.RunUntil([this] { return Report().settled(); }, left());
    }
  }

 private:
  // Read each time: a robot may be starting while it is stopped.
  StopView View() const {
    StopView view = ViewFromHere(scope_, link_.status());
    view.has_controller |= link_.HasMachine();
    return view;
  }
  bool HasController() const { return View().has_controller; }

  Link& link_;
  const StopLatch& latch_;
  const StopScope scope_;
  const Time begun_ = link_.loop().Now();
};

// The processes of the attempts so far.
using Publishers = std::vector<DetachedPublisher*>;

// "71, 72".
std::string PidsText(const Publishers& publishers) {
  std::string pids;
  for (const DetachedPublisher* one : publishers) {
    if (one->pid() == 0) continue;
    pids += (pids.empty() ? "" : ", ") + std::to_string(one->pid());
  }
  return pids;
}

// Their processes publish the stop for a minute, and to which machines.
std::string StaysPublished(const Publishers& publishers, const Stop& stop) {
  for (DetachedPublisher* one : publishers) one->Begin();
  const std::string pids = PidsText(publishers);
  if (pids.empty()) return "";
  const MachineIdentity machine{stop.message.machine, stop.message.machine_id};
  const std::string text = Printable(MachineText(machine));
  return "; the stop stays published for a minute (pid " + pids + "), for " +
         (text.empty() ? "every machine that receives it" : text);
}

// Prints why the stop is not complete. It stays published for a minute, unless it was released:
// then the processes of earlier attempts end as well.
ExitCode NotComplete(const EstopReport& report, const Link& link, const StopLatch& latch,
                     const Stop& stop, const Publishers& publishers, Console& console) {
  std::string kept;
  if (stop.only_now && !report.found()) {
    for (DetachedPublisher* one : publishers) one->Cancel();
  } else if (latch.withdrawn()) {
    for (DetachedPublisher* one : publishers) one->Cancel();
    kept = "; it was released meanwhile";
  } else {
    kept = StaysPublished(publishers, stop);
  }
  if (!report.found()) {
    Failure failure = link.NotFound("controller or actuator");
    failure.error.message += kept;
    return console.Fail(failure);
  }
  console.PrintError(EstopError(report) + kept);
  return link.interrupted() ? ExitCode::kInterrupted : ExitCode::kNotDone;
}

// Follows the machine whose controller --machine means. Where it means several, each of them is
// stopped, one is followed, and the report names them: a stop that asks first would leave them
// moving.
void Choose(Link& link, const MachineIdentity& machine, const GlobalOptions& global) {
  const bool open = !global.machine.empty() && machine.id.empty();
  if (open) return link.ChooseOnceFound();
  link.Choose(machine);
}

// What a search of this host finds: the machine that is meant, and what it has of any.
struct Found {
  MachineIdentity machine;
  std::vector<MachineHere> machines;
};

// Reads the disk and other processes, and one that hangs may hold it up. Before that the controller
// of this host has the stop, and after kFirstTry another process publishes it: to each machine that
// may be meant, as far as is known then.
Found SearchMeanwhile(Stop& stop, const GlobalOptions& global) {
  const auto begun = std::chrono::steady_clock::now();
  Address(stop.message, {global.machine, ""});
  HandOver(stop.message, global);
  std::optional<DetachedPublisher> meanwhile(std::in_place, PublishForAMinute(global, stop),
                                             kFirstTry);
  Found found{TargetOf(global), {}};
  const bool by_id = BeginsIdOf(found.machine, global.machine);
  if (by_id) {
    msg::EmergencyStop here = stop.message;
    Address(here, found.machine);
    HandOver(here, global);
    stop.by_id = {found.machine};
  }
  if (global.machine.empty()) {
    // After a search that hung it is for each machine: another one may have received it.
    const bool published = std::chrono::steady_clock::now() - begun >= kFirstTry;
    if (published) found.machine = {};
    Address(stop.message, found.machine);
  }
  if (by_id || global.machine.empty()) {
    meanwhile->Cancel();
    meanwhile.emplace(PublishForAMinute(global, stop), kFirstTry);
  }
  found.machines = MachinesHere(transport::DomainId({}).value(), global.name_space);
  meanwhile->Cancel();
  for (const MachineHere& one : found.machines) {
    if (BeginsIdOf(one.identity, global.machine)) stop.by_id.push_back(one.identity);
  }
  if (found.machine.id.empty()) {
    found.machine = MachineByFiles(global.machine, found.machines).value_or(found.machine);
  }
  return found;
}

// How many have confirmed the stop, the controller included.
std::ptrdiff_t Confirmed(const EstopReport& report) {
  return std::ranges::count_if(report.actuators, &EstopReport::Actuator::stopped) +
         (report.controller_latched ? 1 : 0);
}

// One try to stop the machine: by `network` alone, or by all.
class Attempt {
 public:
  Attempt(const Stop& stop, const Found& found, const GlobalOptions& global, std::string network)
      : stop_(stop),
        found_(found),
        global_(global),
        network_(std::move(network)),
        detached_(PublishForAMinute(global, stop, network_)) {}
  Attempt(const Attempt&) = delete;
  Attempt& operator=(const Attempt&) = delete;

  // Of a series of attempts.
  struct Part {
    std::optional<Duration> limit;  // none: the default
    bool last = false;
    EstopReport best = {};    // of the earlier ones
    Publishers earlier = {};  // their processes
  };
  // Publishes the stop until it is confirmed, at most for the limit. nullopt: it is not the last
  // one, and the network cannot be joined, or the stop is not confirmed within twice the time for
  // discovery; its process publishes on.
  std::optional<ExitCode> Run(const Part& part, Console& console) {
    const auto fail = [&](const Error& error) -> std::optional<ExitCode> {
      detached_.Begin();
      if (!part.last) return std::nullopt;
      return part.best.found() ? FailAfterOthers(error, part, console) : console.Fail(error);
    };
    const auto link = Link::OpenAtOnce(global_, &console, network_);
    if (!link) return fail(link.error());
    const auto latch = stop_.Publish(link.value()->node(), global_);
    if (!latch) return fail(latch.error());
    joined_ = true;
    latch.value()->ContinueWith(detached_);
    const auto second_try = link.value()->loop().At(link.value()->loop().Now() + kFirstTry,
                                                    [this] { detached_.Begin(); });
    Choose(*link.value(), found_.machine, global_);
    if (const auto followed = link.value()->FollowStatus({}); !followed) {
      return fail(followed.error());
    }
    Confirmation confirmation(*link.value(), *latch.value(), global_, found_.machines);
    const Duration limit = part.limit.value_or(confirmation.DefaultTimeout());
    if (part.last) {
      confirmation.Await(limit);
    } else if (!confirmation.AwaitComplete(std::min(limit, 2 * link.value()->discovery()))) {
      report_ = confirmation.Report();
      if (!link.value()->interrupted()) {
        detached_.Begin();
        return std::nullopt;
      }
    }
    // No two machines have the same whole id.
    const bool may_be_several = !global_.machine.empty() && found_.machine.id != global_.machine;
    if (may_be_several) confirmation.AwaitOthers(limit);
    confirmation.AwaitSaved();
    return Conclude(confirmation.Report(), part, *link.value(), *latch.value(), console);
  }

  const std::string& network() const { return network_; }
  // Whether the stop was published by it.
  bool joined() const { return joined_; }
  // What an attempt has found that is not the last.
  const EstopReport& report() const { return report_; }
  DetachedPublisher& publisher() { return detached_; }
  // Whether its process goes on after the stop is confirmed: the stop is on no disk.
  bool stays_published() const { return stays_published_; }

 private:
  // Earlier ones have found the machine.
  ExitCode FailAfterOthers(const Error& error, const Part& part, Console& console) {
    console.Print(console.mode().json ? EstopJson(part.best)
                                      : EstopText(part.best, console.mode().colour));
    Publishers publishers = part.earlier;
    publishers.push_back(&detached_);
    const std::string why = part.best.complete() ? "" : EstopError(part.best) + "; ";
    console.PrintError(why + error.message + StaysPublished(publishers, stop_));
    return ExitCode::kNotDone;
  }

  ExitCode Conclude(EstopReport report, const Part& part, const Link& link, const StopLatch& latch,
                    Console& console) {
    // An actuator that has confirmed an earlier attempt stays stopped.
    if (Confirmed(part.best) > Confirmed(report)) report = part.best;
    if (const pid_t silent = report.controller ? 0 : link.LeaderHere(); silent != 0) {
      report.silent_controller = WhySilent(ExamineSilent(silent, global_), global_);
    }
    const bool led = report.controller || !report.silent_controller.empty();
    if (report.found() && !led && !latch.withdrawn()) {
      report.not_on_disk = "no controller leads that saves it";
    }
    if (report.found()) {
      console.Print(console.mode().json ? EstopJson(report)
                                        : EstopText(report, console.mode().colour));
    }
    Publishers publishers = part.earlier;
    publishers.push_back(&detached_);
    const bool complete = report.found() && report.complete();
    const ExitCode exit =
        complete ? ExitCode::kDone : NotComplete(report, link, latch, stop_, publishers, console);
    if (report.not_on_disk.empty()) return exit;
    stays_published_ = complete && !latch.withdrawn();
    const char* lost = led ? "; the stop is lost if the controller and the actuators end"
                           : "; the stop is lost if the actuators end";
    const std::string kept = stays_published_ ? StaysPublished(publishers, stop_) : "";
    console.PrintError("not on disk: " + report.not_on_disk + lost + kept);
    return exit;
  }

  const Stop& stop_;
  const Found& found_;
  const GlobalOptions& global_;
  const std::string network_;   // empty: all
  DetachedPublisher detached_;  // before the process has a second thread: before a link
  bool joined_ = false;
  bool stays_published_ = false;
  EstopReport report_;
};

// The attempts to stop one machine.
class Series {
 public:
  Series(const Stop& stop, const Found& found, const GlobalOptions& global, Console& console)
      : stop_(stop), found_(found), global_(global), console_(console) {}

  // By all networks at once, then by each one alone, which reaches a robot that has lost one of
  // them (see Link); last, for the time that is left, by the way on which most have confirmed the
  // stop. --timeout is shared: the last one needs time to discover the robot again.
  ExitCode Run() {
    std::vector<std::string> networks = Link::SeparateNetworks(global_);
    if (!networks.empty()) networks.insert(networks.begin(), std::string());
    for (std::size_t i = 0; i < networks.size(); ++i) {
      const auto exit = RunOne(networks[i], networks.size() - i);
      if (exit) return *exit;
    }
    const Attempt* const best = Best();
    return *RunOne(best == nullptr ? std::string() : best->network(), 0);
  }

 private:
  // `more`: attempts that follow.
  std::optional<ExitCode> RunOne(const std::string& network, std::size_t more) {
    Attempt::Part part;
    part.last = more == 0;
    if (global_.timeout) {
      const Duration left = begun_ + *global_.timeout - std::chrono::steady_clock::now();
      part.limit = left / static_cast<Duration::rep>(more + 1);
      // On most hosts it is the only one that is needed.
      const Duration discovery = global_.keys.empty() ? Link::kDiscovery : Link::kSecuredDiscovery;
      if (attempts_.empty()) part.limit = std::max(*part.limit, std::min(left, discovery));
    }
    if (const Attempt* const best = Best()) part.best = best->report();
    for (const auto& earlier : attempts_) part.earlier.push_back(&earlier->publisher());
    attempts_.push_back(std::make_unique<Attempt>(stop_, found_, global_, network));
    const auto exit = attempts_.back()->Run(part, console_);
    if (exit != ExitCode::kDone || attempts_.back()->stays_published()) return exit;
    for (const auto& attempt : attempts_) attempt->publisher().Cancel();
    return exit;
  }
  // That most have confirmed; null: none has joined its network.
  const Attempt* Best() const {
    const Attempt* best = nullptr;
    for (const auto& one : attempts_) {
      if (!one->joined()) continue;
      if (best == nullptr || Confirmed(one->report()) > Confirmed(best->report())) best = one.get();
    }
    return best;
  }

  const Stop& stop_;
  const Found& found_;
  const GlobalOptions& global_;
  Console& console_;
  const Time begun_ = std::chrono::steady_clock::now();
  std::vector<std::unique_ptr<Attempt>> attempts_;
};

Stop NewStop(const EstopOptions& options, const GlobalOptions& global) {
  Stop stop;
  stop.message =
      NewEmergencyStop(UserAtHostAtOnce(), fmt::format("{}", fmt::join(options.reason, " ")));
  stop.id_begins = global.machine;
  return stop;
}

// `stopped_here`: a machine of this host was stopped in another namespace or domain. Then it is not
// known that another one is meant.
ExitCode EngageThere(Stop& stop, const GlobalOptions& given, bool stopped_here, Console& console) {
  const Found found = SearchMeanwhile(stop, given);
  GlobalOptions global = Reach(given, found.machine, found.machines);
  stop.only_now = stopped_here && (found.machine.name.empty() || !given.machine.empty());
  if (stop.only_now && !global.timeout) {
    global.timeout =
        kOthersWithin + (global.keys.empty() ? Link::kDiscovery : Link::kSecuredDiscovery);
  }
  return Series(stop, found, global, console).Run();
}

// The environment of a stop in another domain, until the end of the scope. Reach() changes the
// transport, too.
class InDomain {
 public:
  explicit InDomain(int domain) {
    setenv("ROS_DOMAIN_ID", std::to_string(domain).c_str(), /*replace=*/1);
  }
  ~InDomain() {
    Restore("ROS_DOMAIN_ID", domain_);
    Restore("MUSHER_TRANSPORT", transport_);
  }
  InDomain(const InDomain&) = delete;
  InDomain& operator=(const InDomain&) = delete;

 private:
  using Value = std::optional<std::string>;

  static Value ValueOf(const char* name) {
    const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
    return value == nullptr ? Value() : Value(value);
  }
  static void Restore(const char* name, const Value& value) {
    if (value) {
      setenv(name, value->c_str(), /*replace=*/1);
    } else {
      unsetenv(name);
    }
  }

  const Value domain_ = ValueOf("ROS_DOMAIN_ID");
  const Value transport_ = ValueOf("MUSHER_TRANSPORT");
};

// Stops the machines of this host in other namespaces, and in other domains, beside what is stopped
// without them: a shell that lacks the MUSHER_NAMESPACE of a robot does not leave it moving. Their
// controllers have the stop before anything is searched for, and after kFirstTry a process
// publishes each one that is not under way yet.
class StopsOfThisHost {
 public:
  StopsOfThisHost(const EstopOptions& options, const GlobalOptions& given, Console& console)
      : options_(options), given_(given), console_(console) {}

  ExitCode Run(const std::vector<MachinePlace>& beside) {
    for (const MachinePlace& place : beside) Add(place);
    Add(own_);
    for (const auto& one : stops_) {
      const InDomain in_domain(one->place.domain);
      HandOver(one->stop.message, one->global);
    }
    for (const auto& one : stops_) {
      const InDomain in_domain(one->place.domain);
      one->meanwhile.emplace(PublishForAMinute(one->global, one->stop), kFirstTry);
    }
    if (!given_.machine.empty()) DropOthers();
    for (const auto& one : stops_) {
      if (!interrupted_) RunOne(*one);
    }
    return RunRemote(exit_.value_or(ExitCode::kNoController));
  }
  // Those that only have actuators on other hosts; their state folders say so. `exit`: of what was
  // stopped before.
  ExitCode RunRemote(ExitCode exit) {
    if (exit != ExitCode::kNoController) exit_ = exit;
    for (const MachinePlace& place : PlacesOfRemoteActuators(given_)) {
      if (interrupted_) break;
      Add(place);
      RunOne(*stops_.back());
    }
    if (!documents_.empty()) console_.Print(Document());
    return exit_.value_or(exit);
  }

 private:
  struct One {
    MachinePlace place;
    GlobalOptions global;
    Stop stop;
    std::optional<DetachedPublisher> meanwhile;
  };

  void Add(const MachinePlace& place) {
    auto one = std::make_unique<One>();
    one->place = place;
    one->global = given_;
    one->global.name_space = place.name_space;
    one->stop = NewStop(options_, given_);
    Address(one->stop.message, {given_.machine, ""});
    stops_.push_back(std::move(one));
  }
  // Those that --machine does not mean.
  void DropOthers() {
    const auto meant = MachinesBeside(given_);
    std::erase_if(stops_, [&](const std::unique_ptr<One>& one) {
      const bool is_meant = std::ranges::count(meant, one->place, &MachineBeside::place) != 0;
      if (is_meant || one->place == own_) return false;
      one->meanwhile->Cancel();
      return true;
    });
  }
  void RunOne(One& one) {
    const InDomain in_domain(one.place.domain);
    if (one.meanwhile) one.meanwhile->Cancel();
    const bool own = one.place == own_;
    const bool stopped_here =
        own && exit_ == ExitCode::kDone && std::ranges::count(PlacesHere(), own_) == 0;
    std::ostringstream out;
    std::ostringstream err;
    Console captured(out, err, {console_.mode().json, console_.mode().colour, false});
    const ExitCode exit = EngageThere(one.stop, one.global, stopped_here, captured);
    interrupted_ = exit == ExitCode::kInterrupted;
    if (exit == ExitCode::kNoController && one.stop.only_now) return;
    Print(one.place, out.str(), err.str());
    if (exit_.value_or(ExitCode::kDone) == ExitCode::kDone || interrupted_) exit_ = exit;
  }
  void Print(const MachinePlace& place, const std::string& out, const std::string& err) {
    if (console_.mode().json) {
      documents_.emplace_back(place, out);
    } else if (!out.empty() && (stops_.size() > 1 || place != own_)) {
      const std::string options = place == own_ ? "" : " (" + place.Options(own_) + ")";
      const bool here = std::ranges::count(PlacesHere(), place) != 0;
      console_.Print((here ? "in " : "on other hosts in ") + place.Text(own_.domain) + options +
                     ":\n" + out);
    } else if (!out.empty()) {
      console_.Print(out);
    }
    std::istringstream lines(err);
    for (std::string line; std::getline(lines, line);) console_.Note(line);
  }
  // The first one, and the others in its list `beside`.
  std::string Document() const {
    if (documents_.size() == 1) return documents_.front().second;
    OrderedJson document;
    for (const auto& [place, text] : documents_) {
      OrderedJson one = OrderedJson::parse(text, nullptr, /*allow_exceptions=*/false);
      if (!one.is_object()) one = OrderedJson::object();
      one["namespace"] = place.name_space;
      one["domain"] = place.domain;
      if (document.is_null()) {
        document = std::move(one);
        document["beside"] = OrderedJson::array();
      } else {
        document["beside"].push_back(std::move(one));
      }
    }
    return JsonLine(document);
  }

  const EstopOptions& options_;
  const GlobalOptions& given_;
  Console& console_;
  const MachinePlace own_ = PlaceOf(given_);  // of the command
  std::vector<std::unique_ptr<One>> stops_;
  std::optional<ExitCode> exit_;  // the first that is not kDone; none: nothing was found yet
  bool interrupted_ = false;
  std::vector<std::pair<MachinePlace, std::string>> documents_;
};

ExitCode Engage(const EstopOptions& options, const GlobalOptions& given, Console& console) {
  if (const auto domain = transport::DomainId({}); !domain) return console.Fail(domain.error());
  const std::vector<MachinePlace> beside = PlacesToStop(given);
  if (!beside.empty()) return StopsOfThisHost(options, given, console).Run(beside);
  Stop stop = NewStop(options, given);
  const ExitCode exit = EngageThere(stop, given, /*stopped_here=*/false, console);
  if (exit == ExitCode::kInterrupted) return exit;
  return StopsOfThisHost(options, given, console).RunRemote(exit);
}

// Not empty, which means all stops: one that is engaged after an answer without any was not seen.
std::vector<std::string> SeenStops(const msg::MachineStatus& shown) {
  if (shown.emergency_stop) return shown.stop_ids;
  return {transport::StopIdText(StopId(0))};
}

// The release covers the stops that are printed before it is sent, and no other one: a person may
// engage one at the same time.
ExitCode Release(const GlobalOptions& global, Console& console) {
  const auto link = Link::OpenForCalls(global, &console);
  const auto fail = [&console](Failure failure, const char* what) {
    if (failure.exit == ExitCode::kNoController) {
      failure.error.message += "; only a controller can release an emergency stop";
    } else {
      failure.error.message.insert(0, what);
    }
    return console.Fail(failure);
  };
  constexpr const char* kUnseen = "not released, because the engaged stops are not known: ";
  if (!link->CallsHere()) {
    if (const auto failure = link->ChooseMachine(Link::Purpose::kAct)) return fail(*failure, "");
  }
  const auto before = link->Call<msg::GetStatus>("get_status", {}, kStopTimeout);
  if (const auto* failure = std::get_if<Failure>(&before)) return fail(*failure, kUnseen);
  const msg::MachineStatus& shown = std::get<msg::GetStatus::Response>(before).status;
  if (shown.emergency_stop && !console.mode().json) console.Print(StopsToRelease(shown));
  msg::ReleaseEmergencyStop::Request request{UserAtHost()};
  request.seen_stops = SeenStops(shown);
  const auto answer =
      link->Call<msg::ReleaseEmergencyStop>("release_emergency_stop", request, kStopTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return fail(*failure, "");
  const auto& released = std::get<msg::ReleaseEmergencyStop::Response>(answer);
  if (released.code != kCodeOk) {
    return console.Fail({ExitCode::kNotDone, {released.code, released.reason}});
  }
  const auto status = link->Call<msg::GetStatus>("get_status", {}, kStopTimeout);
  if (const auto* failure = std::get_if<Failure>(&status)) {
    Failure unknown = *failure;
    unknown.error.message.insert(
        0, "the emergency stop is released, but the machine's status is not known: ");
    return console.Fail(unknown);
  }
  const msg::MachineStatus& machine = std::get<msg::GetStatus::Response>(status).status;
  console.Print(console.mode().json ? ReleaseJson(machine, shown.stop_ids)
                                    : ReleaseText(machine, console.mode().colour));
  return ExitCode::kDone;
}

ExitCode Estop(const EstopOptions& options, const GlobalOptions& global, Console& console) {
  return options.release ? Release(global, console) : Engage(options, global, console);
}

}  // namespace

void AddEstop(Grammar& grammar) {
  auto [app, options] = grammar.Add("estop", "Emergency stop; works without a controller, too",
                                    Estop, "musher estop \"smoke\"");
  auto* reason =
      app.add_option("REASON", options.reason, "Why; `musher status` shows it")->type_name("");
  app.add_flag("--release", options.release, "Release it; needs the controller, changes no state")
      ->excludes(reason);
}

}  // namespace musher::cli
