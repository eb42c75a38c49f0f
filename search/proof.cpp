#include "musher/search/proof.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iterator>
#include <map>
#include <mutex>
#include <new>
#include <numeric>
#include <semaphore>
#include <thread>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/base/code.hpp"
#include "musher/base/joined.hpp"
#include "musher/base/suggest.hpp"
#include "musher/base/words.hpp"
#include "musher/lifecycle/config/flow.hpp"
#include "musher/search/fingerprint.hpp"
#include "musher/search/rules.hpp"

namespace musher::search {
namespace {

constexpr auto kProgressPeriod = std::chrono::milliseconds(200);

// Where searches begin.
class Roots {
 public:
  explicit Roots(const MachineConfig& config) : model_(config) {}

  // Call once. `ends` is called before each request that is followed; true: some are missing.
  void Find(const std::function<bool()>& ends) {
    AddAfterStart();
    FollowAll(ends);
    AddInStart();
    FollowAll(ends);
  }

  bool Has(const State& state) const { return worlds_.contains(state); }
  const std::map<State, World>& worlds() const { return worlds_; }

  // The machine before its start.
  static World OfStart(const Model& model) {
    World world = NewWorld(model);
    Notes notes;
    Begin(model, world, false, notes);
    world.from = State(kSelfCheck);
    world.in_start = true;
    return world;
  }

 private:
  // Where the start leads without a fault.
  void AddAfterStart() {
    World world = NewWorld(model_);
    Notes notes;
    Begin(model_, world, false, notes);
    if (RunUntilStable(model_, world, notes) && world.machine.phase == Phase::kRunning) {
      const State state = world.machine.state;
      Add(state, std::move(world));
    }
  }

  void FollowAll(const std::function<bool()>& ends) {
    while (followed_ < order_.size()) Follow(order_[followed_++], ends);
  }

  // What a request leads to from there.
  // A copy: Add() moves those in order_.
  void Follow(State from,  // NOLINT(performance-unnecessary-value-param)
              const std::function<bool()>& ends) {
    for (const State& to : model_.config.states) {
      if (ends()) return;
      if (to == kTearDown || Has(to) || !FlowAllows(model_.config, from, to)) continue;
      World world = worlds_.at(from);
      world.at_start = false;
      Notes notes;
      RequestSwitch(model_, world, to, notes);
      if (RunUntilStable(model_, world, notes) && world.machine.state == to)
        Add(to, std::move(world));
    }
  }

  // A program drives the start: all is set up, or nothing yet.
  void AddInStart() {
    World world = NewWorld(model_);
    Notes notes;
    Begin(model_, world, true, notes);
    if (!Has(State(kUninitialized))) Add(State(kUninitialized), world);
    if (!Has(State(kSetUp)) && RunUntilStable(model_, world, notes) &&
        world.machine.state == kSetUp) {
      Add(State(kSetUp), std::move(world));
    }
  }

  void Add(const State& state, World world) {
    world.requests.clear();
    world.from = state;
    world.at_start = true;
    worlds_.emplace(state, std::move(world));
    order_.push_back(state);
  }

  const Model model_;
  std::map<State, World> worlds_;
  std::vector<State> order_;
  std::size_t followed_ = 0;  // of the order
};

class Prover {
 public:
  Prover(const MachineConfig& config, const ProofOptions& options)
      : config_(config), options_(options), roots_(config) {
    proof_.rule_coverage.resize(options.stable_rules.size());
    proof_.timed_coverage.resize(options.timed_rules.size());
  }

  Proof Run() && {
    roots_.Find([this] { return Ends({}); });
    if (!proof_.why.empty()) return std::move(proof_);
    ListStates();
    proof_.why = WhyThereIsNothing();
    if (!proof_.why.empty()) return std::move(proof_);
    for (int faults = 0; faults <= options_.faults && !proof_.counter_example; ++faults) {
      if (!SearchAllWith(faults)) break;
      if (!proof_.counter_example) proof_.proved_faults = faults;
    }
    AddUpFigures();
    std::erase_if(proof_.left, [&](const ProofTask& task) {
      const auto found = std::ranges::find(proof_.tasks, task, &ProvedTask::task);
      return found != proof_.tasks.end() && found->finished;
    });
    if (proof_.counter_example) {
      proof_.end = ProofEnd::kViolated;
      Replay(*proof_.counter_example);
    } else if (proof_.proved_faults == options_.faults) {
      proof_.end = ProofEnd::kProved;
    }
    return std::move(proof_);
  }

  // One scenario instead of all.
  Result<CounterExample> Run(const ProofTask& task, const std::string& path) && {
    roots_.Find([] { return false; });
    if (!task.IsStart() && !roots_.Has(task.from)) {
      return Error{kCodeParametersInvalid, NothingLeadsTo(task.from)};
    }
    CounterExample example;
    example.task = task;
    example.path = path;
    example.choices = Fault{{}, path, false}.Choices();
    example.root = RootOf(ModelOf(task), task);
    Replay(example);
    if (!example.steps.empty() && example.steps.back().is_missing) {
      return Error{kCodeParametersInvalid,
                   "event " + std::to_string(example.steps.size()) +
                       " of this scenario is not possible here; its path is of another config, "
                       "another version of Musher, or more faults"};
    }
    if (example.violations.empty()) FindRepetition(example);
    if (example.violations.empty() && !IsWhole(example)) {
      return Error{kCodeParametersInvalid,
                   "this scenario ends before the machine is stable, and violates no rule until "
                   "then; its path is not whole, or of another config"};
    }
    return example;
  }

 private:
  static std::string NothingLeadsTo(const State& state) {
    return "no sequence of requests without a fault leads to " + state;
  }

  void ListStates() {
    for (const State& state : config_.states) {
      if (roots_.Has(state)) {
        proof_.reached.push_back(state);
      } else if (state != kTearDown) {
        proof_.not_reached.push_back(state);
      }
    }
  }

  void AddUpFigures() {
    for (const ProvedTask& task : proof_.tasks) {
      proof_.figures += task.figures;
      for (std::size_t i = 0; i < task.rule_coverage.size(); ++i) {
        proof_.rule_coverage[i] += task.rule_coverage[i];
      }
      for (std::size_t i = 0; i < task.timed_coverage.size(); ++i) {
        proof_.timed_coverage[i] += task.timed_coverage[i];
      }
    }
  }

  // To search for: then nothing would be proved.
  std::string WhyThereIsNothing() const {
    if (options_.from && !roots_.Has(*options_.from)) return NothingLeadsTo(*options_.from);
    if (TasksWith(0).empty()) return "the flow allows no request in " + *options_.from;
    return {};
  }

  std::vector<ProofTask> TasksWith(int faults) const {
    std::vector<ProofTask> tasks;
    if (!options_.from) tasks.push_back({{}, {}, faults});
    for (const auto& [from, world] : roots_.worlds()) {
      if (options_.from && *options_.from != from) continue;
      for (const State& to : config_.states) {
        if (FlowAllows(config_, from, to)) tasks.push_back({from, to, faults});
      }
    }
    // The largest one last would keep one thread busy while the others have ended.
    std::ranges::stable_sort(tasks, std::ranges::greater{},
                             [&](const ProofTask& task) { return WorkOf(task); });
    return tasks;
  }

  // How large the search is, by the one with one fault fewer.
  std::size_t WorkOf(const ProofTask& task) const {
    const auto before = std::ranges::find(
        proof_.tasks, ProofTask{task.from, task.to, task.faults - 1}, &ProvedTask::task);
    return before == proof_.tasks.end() ? 1 : before->figures.nodes + 1;
  }

  Model ModelOf(const ProofTask& task) const {
    Model model(config_, task.to, options_.rules);
    model.stable_rules = options_.stable_rules;
    model.timed_rules = options_.timed_rules;
    model.other_machine = options_.other_machine;
    model.reduces = options_.reduces;
    const auto alike = model.kinds;
    for (const ActuatorIndex i : model.kinds.Indices()) {
      model.kinds[i] = i;
      if (!options_.symmetry || IsInRule(i)) continue;
      for (ActuatorIndex k; k < i && model.kinds[i] == i; ++k) {
        if (alike[k] == alike[i] && !IsInRule(k)) model.kinds[i] = k;
      }
    }
    return model;
  }

  // Such an actuator is like no other one.
  bool IsInRule(ActuatorIndex i) const {
    if (std::ranges::count(options_.timed_rules, std::optional(i), &TimedRule::subject) > 0)
      return true;
    return std::ranges::any_of(options_.stable_rules, [&](const StableRule& rule) {
      return rule.never.actuator == i || (rule.condition && rule.condition->actuator == i);
    });
  }

  World RootOf(const Model& model, const ProofTask& task) const {
    World root = task.IsStart() ? Roots::OfStart(model) : roots_.worlds().at(task.from);
    root.faults = root.faults_left = task.faults;
    BeginTimedRules(model, root);
    return root;
  }

  // Where a rule does not hold at the begin of the search, the search that leads there reports it.
  static void BeginTimedRules(const Model& model, World& root) {
    root.timed_checks.clear();
    const Time begun = root.now;
    Notes ignored;
    UpdateTimedRules(model, root, ignored);
    for (const TimedRule& rule : model.timed_rules)
      root.now = std::max(root.now, begun + rule.within);
    UpdateTimedRules(model, root, ignored);
    root.now = begun;
  }

  // Returns whether all searches with so many faults have ended by themselves. The first violation
  // ends all; then its shortest scenario is searched for.
  bool SearchAllWith(int faults) {
    proof_.left = TasksWith(faults);
    const std::vector<ProofTask> tasks = WithoutEarlier(proof_.left);
    ForEach(tasks, [this](const ProofTask& task) { Search(task); });
    if (!proof_.counter_example) return !limits_.stop;
    if (!proof_.why.empty()) return true;
    limits_.stop = false;
    limits_.below = proof_.counter_example->choices;
    ForEach(tasks, [this](const ProofTask& task) { Shorten(task); });
    return true;
  }

  // Takes over what an earlier run has finished of them; returns the others.
  std::vector<ProofTask> WithoutEarlier(const std::vector<ProofTask>& tasks) {
    std::vector<ProofTask> left;
    for (const ProofTask& task : tasks) {
      const auto earlier = std::ranges::find_if(options_.earlier, [&](const ProvedTask& one) {
        return one.finished && one.task == task;
      });
      if (earlier == options_.earlier.end()) {
        left.push_back(task);
        continue;
      }
      proof_.tasks.push_back(*earlier);
      proof_.tasks.back().earlier = true;
      limits_.nodes += earlier->figures.nodes;
    }
    return left;
  }

  // Calls `search` with each task, in several threads.
  void ForEach(const std::vector<ProofTask>& tasks,
               const std::function<void(const ProofTask&)>& search) {
    if (tasks.empty()) return;
    std::vector<std::size_t> work_of;
    work_of.reserve(tasks.size());
    for (const ProofTask& task : tasks) work_of.push_back(WorkOf(task));
    const std::size_t all_work = std::accumulate(work_of.begin(), work_of.end(), std::size_t{});
    std::atomic<std::size_t> next = 0;
    std::atomic<std::size_t> done = 0;
    std::atomic<std::size_t> work_done = 0;
    std::counting_semaphore<> ended(0);
    const auto work = [&] {
      for (std::size_t i = next++; i < tasks.size() && !limits_.stop; i = next++) {
        try {
          search(tasks[i]);
        } catch (const std::bad_alloc&) {
          out_of_memory_ = limits_.stop = true;
        }
        work_done += work_of[i];
        ++done;
      }
      ended.release();
    };
    std::vector<std::jthread> threads;
    for (unsigned i = 0; i < std::max(1U, options_.threads); ++i) threads.emplace_back(work);
    for (std::size_t left = threads.size(); left > 0;) {
      if (ended.try_acquire_for(kProgressPeriod)) --left;
      const double share = static_cast<double>(work_done) / static_cast<double>(all_work);
      if (Ends({tasks.front().faults, done, tasks.size(), limits_.nodes, share})) {
        limits_.stop = true;
      }
      ReportFinished();
    }
    if (out_of_memory_ && proof_.why.empty()) proof_.why = "there is no more memory";
  }

  bool Ends(const ProofProgress& progress) {
    if (options_.on_progress && proof_.why.empty()) proof_.why = options_.on_progress(progress);
    return !proof_.why.empty();
  }

  void ReportFinished() {
    if (!options_.on_finished) return;
    std::vector<ProvedTask> finished;
    {
      const std::lock_guard lock(mutex_);
      if (proof_.tasks.size() == reported_) return;
      reported_ = proof_.tasks.size();
      std::ranges::copy_if(proof_.tasks, std::back_inserter(finished), &ProvedTask::finished);
    }
    options_.on_finished(finished);
  }

  void Search(const ProofTask& task) {
    const Model model = ModelOf(task);
    const World root = RootOf(model, task);
    const Searched searched = SearchDepthFirst(model, root, limits_);
    const std::lock_guard lock(mutex_);
    const bool finished = searched.finished && !searched.fault;
    proof_.tasks.push_back(
        {task, searched.figures, finished, false, searched.rule_coverage, searched.timed_coverage});
    if (searched.fault) limits_.stop = true;
    KeepIfShorter(task, root, searched);
  }

  void Shorten(const ProofTask& task) {
    const Model model = ModelOf(task);
    const World root = RootOf(model, task);
    const Searched searched = SearchAll(model, root, &limits_);
    const std::lock_guard lock(mutex_);
    KeepIfShorter(task, root, searched);
    limits_.below = proof_.counter_example->choices;
  }

  void KeepIfShorter(const ProofTask& task, const World& root, const Searched& searched) {
    if (!searched.fault) return;
    const std::size_t choices = searched.fault->Choices();
    if (proof_.counter_example && proof_.counter_example->choices <= choices) return;
    proof_.counter_example =
        CounterExample{task, searched.fault->path, choices, searched.fault->repeats, root, {}, {}};
    if (searched.fault->repeats) proof_.counter_example->violations = searched.fault->violations;
  }

  void Replay(CounterExample& example) const {
    const Model model = ModelOf(example.task);
    example.steps = StepsOf(model, example.root, example.path, example.violations);
  }

  // Whether it ends where the machine is stable, in which all rules are checked.
  bool IsWhole(const CounterExample& example) const {
    const World& end = example.steps.empty() ? example.root : example.steps.back().world;
    return IsQuiet(end, Choices(ModelOf(example.task), end));
  }

  // The counter-example of a machine that never comes to rest ends where it was before.
  void FindRepetition(CounterExample& example) const {
    if (example.steps.empty()) return;
    const Model model = ModelOf(example.task);
    const World& end = example.steps.back().world;
    const Fingerprint last = IdentityOf(model, end).fingerprint;
    for (std::size_t i = example.steps.size(); i-- > 0;) {
      const World& before = i == 0 ? example.root : example.steps[i - 1].world;
      if (before.faults_left != end.faults_left) return;  // a fault is part of it
      if (IdentityOf(model, before).fingerprint != last) continue;
      const std::size_t count = example.steps.size() - i;
      example.repeats = true;
      example.violations = {"the machine is where it was before: the last " +
                            Counted(count, "event") + (count == 1 ? " repeats" : " repeat")};
      return;
    }
  }

  const MachineConfig& config_;
  const ProofOptions& options_;
  Roots roots_;
  SearchLimits limits_;
  std::atomic<bool> out_of_memory_ = false;
  std::mutex mutex_;  // guards what threads add to proof_
  Proof proof_;
  std::size_t reported_ = 0;  // of its tasks, to on_finished
};

}  // namespace

std::string ProofTask::Text() const {
  return IsStart() ? "the start" : "from " + from + " to " + to;
}

std::vector<std::string> LeftOutOf(const MachineConfig& config) {
  std::vector<std::string> left_out;
  const auto add_if = [&](bool is_set, const char* what) {
    if (is_set) left_out.emplace_back(what);
  };
  const auto add_of = [&](const std::string& what, const auto& is_set) {
    std::vector<std::string> names;
    for (const ActuatorConfig& actuator : config.actuators) {
      if (is_set(actuator)) names.push_back(actuator.name);
    }
    if (!names.empty()) left_out.push_back(what + " of " + Joined(names, ""));
  };
  const bool has_battery = config.policy && config.policy->battery;
  add_if(config.policy.has_value(),
         has_battery ? "[policy] but for a battery that falls" : "[policy]");
  add_if(config.permit.has_value(), "[safety] permit_ms");
  add_if(!config.capabilities.empty(), "[capability]");
  add_if(config.ros2.started_by_manager, "[ros2] start = \"manager\"");
  add_if(config.transport == TransportProfile::kLan,
         "[transport]: actuators without `host` run on the controller's");
  add_if(!config.keys.empty(), "[security]");
  add_of("restart_prevent_exit_codes (a process ends without an exit code)",
         [](const ActuatorConfig& actuator) {
           return actuator.restart.prevent_exit_codes != RestartConfig().prevent_exit_codes;
         });
  add_of("controller_lost_ms",
         [](const ActuatorConfig& actuator) { return actuator.controller_lost.has_value(); });
  add_of("protocol (Musher's is searched)",
         [](const ActuatorConfig& actuator) { return actuator.protocol != Protocol::kMusher; });
  return left_out;
}

MachineConfig SearchableConfig(const MachineConfig& config) {
  MachineConfig searched = config;
  searched.policy.reset();
  if (config.policy && config.policy->battery) {
    searched.policy.emplace().battery = config.policy->battery;
    searched.clock = ClockSource::kSteady;
  }
  searched.permit.reset();
  searched.view.reset();
  searched.capabilities.clear();
  searched.ros2.started_by_manager = false;
  for (ActuatorConfig& actuator : searched.actuators) {
    actuator.limits = {};
    // Another program is queried instead.
    if (actuator.protocol != Protocol::kMusher) actuator.checkpoint.reset();
    actuator.protocol = Protocol::kMusher;
    actuator.ros2_states.clear();
    actuator.heartbeat_name.clear();
    // What a process is called does not make two actuators different.
    if (!actuator.command.empty()) actuator.command = {"program"};
    actuator.cwd.clear();
    actuator.env.clear();
    actuator.log_size_bytes = 0;
  }
  return searched;
}

std::string WhyNotSearchable(const MachineConfig& config, const std::optional<State>& from) {
  if (config.actuators.size() > kMostSearchedActuators) {
    return "a machine of at most " + std::to_string(kMostSearchedActuators) +
           " actuators can be searched, and this one has " +
           std::to_string(config.actuators.size());
  }
  if (!from || *from == kUninitialized || *from == kSetUp) return {};
  if (!config.HasState(*from) || *from == kTearDown) {
    return config.name + " has no state '" + *from + "' to search from" +
           DidYouMean(*from, config.states);
  }
  return {};
}

Proof Prove(const MachineConfig& config, const ProofOptions& options) {
  return Prover(config, options).Run();
}

bool IsPath(std::string_view text) {
  constexpr std::size_t kMostDigits = 4;
  std::size_t digits = 0;
  for (const char c : text) {
    const bool is_digit = c >= '0' && c <= '9';
    if (!is_digit && (c != '.' || digits == 0)) return false;
    digits = is_digit ? digits + 1 : 0;
    if (digits > kMostDigits) return false;
  }
  return digits > 0;
}

Result<CounterExample> Replay(const MachineConfig& config, const ProofOptions& options,
                              const ProofTask& task, const std::string& path) {
  MUSHER_CHECK(IsPath(path), "not the path of a scenario");
  return Prover(config, options).Run(task, path);
}

}  // namespace musher::search
