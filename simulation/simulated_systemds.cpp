#include "musher/simulation/simulated_systemds.hpp"

#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <utility>

#include "musher/controller/process/host_processes.hpp"

namespace musher::simulation {
namespace {

constexpr Duration kShortestDelay = std::chrono::microseconds(100);
constexpr Duration kLongestDelay = Milliseconds(3);
constexpr Duration kLookEach = Milliseconds(50);    // whether a cut link is back
constexpr Duration kWatchEach = Milliseconds(500);  // by ssh
constexpr Duration kSilentLimit = Milliseconds(6'000);
// After a cut the kernel sends again, less and less often.
constexpr Duration kLatestArrival = Milliseconds(15'000);
constexpr Duration kFirstBackOff = Milliseconds(250);
constexpr Duration kLongestBackOff = Milliseconds(10'000);
constexpr Duration kConnectsWithin = Milliseconds(600);
constexpr Duration kGivesUpAfter = Milliseconds(5'000);
constexpr Duration kExecutesWithin = Milliseconds(30);
constexpr Duration kStopsWithin = Milliseconds(300);
constexpr Duration kKilledAfter = Milliseconds(2'000);  // SIGTERM, that a unit ignores

std::string Variable(const ProcessSpec& spec, const char* name) {
  const auto found = spec.env.find(name);
  return found == spec.env.end() ? std::string() : found->second;
}

}  // namespace

// The controller's end of a connection.
class SimulatedSystemds::Connection : public Systemd {
 public:
  Connection(SimulatedSystemds& systemds, std::size_t from, std::size_t to,
             transport::EventLoop& loop, Hooks hooks,
             std::function<void(const std::string&)> on_start)
      : systemds_(systemds),
        from_(from),
        to_(to),
        loop_(loop),
        hooks_(std::move(hooks)),
        on_start_(std::move(on_start)) {}
  ~Connection() override { Connection::Close(); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void Open() override {
    if (state_ == State::kClosed || state_ == State::kWaiting) {
      retry_ = loop_.At(loop_.Now(), [this] { Connect(); });
    }
  }
  void Close() override {
    state_ = State::kClosed;
    retry_ = nullptr;
    Leave();
  }
  bool is_up() const override { return state_ == State::kUp; }
  const std::string& host_id() const override { return host_id_; }
  Duration running() const override { return loop_.Now() - booted_; }
  const std::string& trouble() const override { return trouble_; }

  void Read(const std::string& unit, UnitState& state, OnDone done) override {
    Send([systemds = &systemds_, to = to_, unit, &state,
          done = std::move(done)](const BridgePtr& bridge) {
      systemds->Reply(bridge, [&state, now = systemds->StateOf(to, unit), done] {
        state = now;
        done(std::nullopt);
      });
    });
  }
  void Start(const UnitStart& start,
             std::function<void(const std::optional<SystemdError>&, const std::string& job)> done)
      override {
    if (from_ == to_ && on_start_) on_start_(start.process.name);
    Send([systemds = &systemds_, to = to_, start, done = std::move(done)](const BridgePtr& bridge) {
      const Machine& machine = systemds->machines_[to];
      std::optional<SystemdError> error;
      if (machine.stopping) {
        error = SystemdError{SystemdError::Kind::kShuttingDown, "it is shutting down"};
      } else if (machine.units.contains(start.unit)) {
        error = SystemdError{SystemdError::Kind::kUnitExists, "it exists"};
      }
      const std::string job = "/job/" + std::to_string(systemds->next_job_++);
      systemds->Reply(bridge, [error, done, job] { done(error, error ? "" : job); });
      if (!error) systemds->StartUnit(to, start, job);
    });
  }
  void Cancel(const std::string& /*job*/) override {}  // each job begins at once
  void Kill(const std::string& invocation, int signal, OnDone done) override {
    Send([systemds = &systemds_, to = to_, invocation, signal,
          done = std::move(done)](const BridgePtr& bridge) {
      std::optional<SystemdError> error;
      if (!systemds->Kill(to, invocation, signal)) {
        error = SystemdError{SystemdError::Kind::kGone, "there is no such unit"};
      }
      systemds->Reply(bridge, [error, done] { done(error); });
    });
  }
  void Stop(const std::string& invocation) override {
    Send([systemds = &systemds_, to = to_, invocation](const BridgePtr&) {
      systemds->Stop(to, invocation);
    });
  }
  void Reset(const std::string& unit) override {
    Send([systemds = &systemds_, to = to_, unit](const BridgePtr&) { systemds->Reset(to, unit); });
  }
  void ReadSystemState(
      std::function<void(const std::optional<SystemdError>&, const std::string& state)> done)
      override {
    Send([systemds = &systemds_, to = to_, done = std::move(done)](const BridgePtr& bridge) {
      const std::string state = systemds->machines_[to].stopping ? "stopping" : "running";
      systemds->Reply(bridge, [done, state] { done(std::nullopt, state); });
    });
  }

  // Runs on the loop of the controller, unless this connection is lost or left until then.
  void Post(const BridgePtr& bridge, std::function<void()> what) {
    loop_.Post([bridge, what = std::move(what)] {
      if (bridge->client != nullptr) what();
    });
  }
  const Hooks& hooks() const { return hooks_; }
  void Lose(const std::string& why) { Fail(true, why); }

 private:
  enum class State : std::uint8_t { kClosed, kWaiting, kConnecting, kUp };

  void Send(std::function<void(const BridgePtr&)> what) {
    if (!is_up()) return;
    systemds_.Call(bridge_, [bridge = bridge_, what = std::move(what)] { what(bridge); });
  }

  // What it has sent is still on the way.
  void Leave() {
    if (bridge_) bridge_->client = nullptr;
  }

  void Connect() {
    state_ = State::kConnecting;
    const Duration most = systemds_.IsReached(from_, to_) ? kConnectsWithin : kGivesUpAfter;
    retry_ =
        loop_.At(loop_.Now() + systemds_.random_.Between(most / 4, most), [this] { Connected(); });
  }

  // The shell of the new connection ends what the one before has left there.
  void Connected() {
    retry_ = nullptr;
    const std::string address = "connect to " + systemds_.hosts_.name(to_) + ": ";
    if (!systemds_.IsReached(from_, to_)) return Fail(false, address + "timed out");
    const std::string id = systemds_.hosts_.Id(to_);
    const Duration running = systemds_.hosts_.Uptime(to_);
    const std::string refused = hooks_.refuse ? hooks_.refuse(id, running) : "";
    if (!refused.empty()) return Fail(false, refused);
    if (bridge_) bridge_->alive = false;
    bridge_ = systemds_.MakeBridge(*this, from_, to_);
    host_id_ = id;
    booted_ = loop_.Now() - running;
    state_ = State::kUp;
    back_off_ = kFirstBackOff;
    trouble_.clear();
    hooks_.on_up();
  }

  void Fail(bool was_up, const std::string& why) {
    Leave();
    trouble_ = why;
    state_ = State::kWaiting;
    if (was_up) back_off_ = kFirstBackOff;
    retry_ = loop_.At(loop_.Now() + back_off_, [this] { Connect(); });
    back_off_ = std::min(back_off_ * 2, kLongestBackOff);
    hooks_.on_down(was_up, false);
  }

  SimulatedSystemds& systemds_;
  const std::size_t from_;
  const std::size_t to_;
  transport::EventLoop& loop_;
  const Hooks hooks_;
  const std::function<void(const std::string&)> on_start_;
  State state_ = State::kClosed;
  std::string host_id_;
  Time booted_{};
  std::string trouble_;
  Duration back_off_ = kFirstBackOff;
  BridgePtr bridge_;  // of the last connection
  transport::LoopHandlePtr retry_;
};

SimulatedSystemds::SimulatedSystemds(transport::sim::Network& network, const MachineConfig& config,
                                     Hosts& hosts, SimulatedProcesses& processes)
    : network_(network),
      config_(config),
      hosts_(hosts),
      processes_(processes),
      random_(network.random().Next()),
      node_(network.MakeNode("systemds")),
      machines_(hosts.size()) {
  if (!config.own_units) return;
  for (Machine& host : machines_) {
    host.silent_from = network.now() + random_.Between({}, Milliseconds(15'000));
    const Duration silence = random_.Between(Milliseconds(500), Milliseconds(12'000));
    host.silent_until = host.silent_from + (random_.Bernoulli(0.5) ? silence : Duration());
  }
}

SimulatedSystemds::~SimulatedSystemds() = default;

ConnectSystemd SimulatedSystemds::From(std::size_t from, transport::EventLoop& loop,
                                       std::function<void(const std::string&)> on_start) {
  return [this, from, &loop, on_start = std::move(on_start)](
             const HostConfig& host, const std::vector<std::string>& /*units*/,
             Systemd::Hooks hooks) -> std::unique_ptr<Systemd> {
    std::size_t to = host.name.empty() ? from : 0;
    while (!host.name.empty() && hosts_.name(to) != host.name) ++to;
    return std::make_unique<Connection>(*this, from, to, loop, std::move(hooks), on_start);
  };
}

// --- the connections ---

void SimulatedSystemds::After(Duration delay, std::function<void()> what) {
  const std::uint64_t id = next_event_++;
  transport::EventLoop& loop = node_->loop();
  events_[id] = loop.At(loop.Now() + delay, [this, id, what = std::move(what)] {
    const auto event = events_.extract(id);  // until this returns it is kept
    what();
  });
}

Duration SimulatedSystemds::Delay() {
  return random_.Between(kShortestDelay, kLongestDelay);
}

bool SimulatedSystemds::Reaches(std::size_t from, std::size_t to) const {
  const Time now = network_.now();
  const Machine& host = machines_[to];
  if (from == to) return now < host.silent_from || now >= host.silent_until;
  return hosts_.Reaches(from, to);
}

bool SimulatedSystemds::IsSilent(std::size_t host) const {
  const Time now = network_.now();
  return now + std::chrono::seconds(1) >= machines_[host].silent_from &&
         now < machines_[host].silent_until;
}

bool SimulatedSystemds::IsReached(std::size_t from, std::size_t to) const {
  return machines_[to].on && Reaches(from, to) && Reaches(to, from);
}

SimulatedSystemds::BridgePtr SimulatedSystemds::MakeBridge(Connection& client, std::size_t from,
                                                           std::size_t to) {
  auto bridge = std::make_shared<Bridge>();
  bridge->from = from;
  bridge->to = to;
  bridge->client = &client;
  std::erase_if(bridges_, [](const auto& one) { return one.expired(); });
  bridges_.push_back(bridge);
  After(kWatchEach, [this, bridge] { Watch(bridge); });
  return bridge;
}

// ssh asks whether the host is there. One that was booted again says that it knows of nothing.
void SimulatedSystemds::Watch(const BridgePtr& bridge) {
  if (bridge->client == nullptr) return;
  const bool reached = IsReached(bridge->from, bridge->to);
  bridge->silent_for =
      reached && bridge->alive ? Duration::zero() : bridge->silent_for + kWatchEach;
  if (bridge->silent_for >= kSilentLimit || (reached && !bridge->alive)) {
    Connection& client = *bridge->client;
    return client.Post(bridge, [&client] { client.Lose("the connection was lost"); });
  }
  After(kWatchEach, [this, bridge] { Watch(bridge); });
}

void SimulatedSystemds::Call(const BridgePtr& bridge, std::function<void()> what) {
  bridge->calls.push_back(std::move(what));
  if (bridge->calls.size() == 1) After(Delay(), [this, bridge] { CarryCalls(bridge); });
}

void SimulatedSystemds::CarryCalls(const BridgePtr& bridge) {
  if (!bridge->alive) return bridge->calls.clear();
  if (!Reaches(bridge->from, bridge->to)) {
    bridge->stalled = true;
    return After(kLookEach, [this, bridge] { CarryCalls(bridge); });
  }
  if (std::exchange(bridge->stalled, false) && !std::exchange(bridge->sent_again, true)) {
    const Duration most = bridge->client == nullptr ? kLatestArrival : kLongestDelay;
    return After(random_.Between({}, most), [this, bridge] { CarryCalls(bridge); });
  }
  bridge->sent_again = false;
  const auto what = std::move(bridge->calls.front());
  bridge->calls.pop_front();
  what();
  if (!bridge->calls.empty()) After(Delay(), [this, bridge] { CarryCalls(bridge); });
}

void SimulatedSystemds::Reply(const BridgePtr& bridge, std::function<void()> what) {
  bridge->replies.push_back(std::move(what));
  if (bridge->replies.size() == 1) After(Delay(), [this, bridge] { CarryReplies(bridge); });
}

void SimulatedSystemds::CarryReplies(const BridgePtr& bridge) {
  if (!bridge->alive || bridge->client == nullptr) return bridge->replies.clear();
  if (!Reaches(bridge->to, bridge->from)) {
    return After(kLookEach, [this, bridge] { CarryReplies(bridge); });
  }
  bridge->client->Post(bridge, std::move(bridge->replies.front()));
  bridge->replies.pop_front();
  if (!bridge->replies.empty()) After(Delay(), [this, bridge] { CarryReplies(bridge); });
}

void SimulatedSystemds::SendChange(std::size_t host, const std::string& name,
                                   const UnitState& state) {
  for (const auto& one : bridges_) {
    const BridgePtr bridge = one.lock();
    if (!bridge || bridge->to != host || bridge->client == nullptr) continue;
    Reply(bridge, [bridge, name, state] {
      const auto merge = [&state](UnitState& known) {
        const auto environment = known.environment;  // is not among the changes
        known = state;
        known.environment = environment;
      };
      bridge->client->hooks().on_change(name, merge, true);
    });
  }
}

void SimulatedSystemds::SendJobRemoved(std::size_t host, const std::string& name,
                                       const std::string& job, const std::string& result) {
  for (const auto& one : bridges_) {
    const BridgePtr bridge = one.lock();
    if (!bridge || bridge->to != host || bridge->client == nullptr) continue;
    Reply(bridge, [bridge, name, job, result] {
      bridge->client->hooks().on_job_removed(name, job, result);
    });
  }
}

// --- the units ---

UnitState SimulatedSystemds::StateOf(std::size_t host, const std::string& name) const {
  const auto unit = machines_[host].units.find(name);
  return unit == machines_[host].units.end() ? UnitState() : unit->second.state;
}

void SimulatedSystemds::StartUnit(std::size_t host, const UnitStart& start,
                                  const std::string& job) {
  if (hosts_.Uptime(host) > start.until) {
    return SendJobRemoved(host, start.unit, job, std::string(kJobDone));
  }
  std::string invocation = std::to_string(next_invocation_++);
  invocation.insert(0, 32 - invocation.size(), '0');
  Unit unit{start.process.name, {}, job};
  unit.state.active = "activating";
  unit.state.invocation = invocation;
  for (const auto& [name, value] : start.process.env) {
    unit.state.environment.insert(name + "=" + value);
  }
  names_[invocation] = start.unit;
  SendChange(host, start.unit, unit.state);
  machines_[host].units[start.unit] = std::move(unit);
  After(random_.Between(kShortestDelay, kExecutesWithin),
        [this, host, name = start.unit, invocation, spec = start.process] {
          Execute(host, name, invocation, spec);
        });
}

void SimulatedSystemds::Execute(std::size_t host, const std::string& name,
                                const std::string& invocation, const ProcessSpec& spec) {
  const auto unit = machines_[host].units.find(name);
  if (unit == machines_[host].units.end() || unit->second.state.invocation != invocation ||
      unit->second.job.empty()) {
    return;  // it was stopped
  }
  const std::string job = std::exchange(unit->second.job, "");
  UnitState& state = unit->second.state;
  const std::int32_t pid = processes_.Launch(
      spec.name, host, {Variable(spec, "MUSHER_MACHINE"), Variable(spec, "MUSHER_MACHINE_ID")});
  state.active = "active";
  state.main_pid = state.exec_pid = static_cast<std::uint32_t>(pid);
  SendChange(host, name, state);
  SendJobRemoved(host, name, job, std::string(kJobDone));
}

std::pair<const std::string, SimulatedSystemds::Unit>* SimulatedSystemds::UnitOf(
    std::size_t host, const std::string& invocation) {
  const auto unit = machines_[host].units.find(names_[invocation]);
  if (unit == machines_[host].units.end()) return nullptr;
  return signals_by_name || unit->second.state.invocation == invocation ? &*unit : nullptr;
}

bool SimulatedSystemds::Kill(std::size_t host, const std::string& invocation, int signal) {
  const auto* unit = UnitOf(host, invocation);
  if (unit == nullptr) return false;
  const auto& [actuator, state, job] = unit->second;
  if (state.main_pid == 0) return true;
  if (state.invocation != invocation && on_wrong_process) on_wrong_process(actuator);
  static_cast<void>(processes_.Signal(host, static_cast<std::int32_t>(state.main_pid), signal));
  return true;
}

void SimulatedSystemds::Stop(std::size_t host, const std::string& invocation) {
  auto* unit = UnitOf(host, invocation);
  if (unit == nullptr) return;
  const std::string name = unit->first;
  const std::string job = std::exchange(unit->second.job, "");
  if (!job.empty()) {  // it has not been executed yet
    SendJobRemoved(host, name, job, "canceled");
    return Unload(host, name);
  }
  Kill(host, invocation, SIGTERM);
  After(kKilledAfter, [this, host, invocation] { Kill(host, invocation, SIGKILL); });
}

void SimulatedSystemds::Reset(std::size_t host, const std::string& name) {
  const auto unit = machines_[host].units.find(name);
  if (unit != machines_[host].units.end() && unit->second.state.active == "failed") {
    Unload(host, name);
  }
}

// A unit that has ended well is not kept: what is known of it is gone with it.
void SimulatedSystemds::Unload(std::size_t host, const std::string& name) {
  machines_[host].units.erase(name);
}

void SimulatedSystemds::OnEnd(std::size_t host, std::int32_t pid, const ProcessExit& exit) {
  Machine& machine = machines_[host];
  const auto unit = std::ranges::find_if(machine.units, [pid](const auto& one) {
    return one.second.state.main_pid == static_cast<std::uint32_t>(pid);
  });
  if (!machine.on || unit == machine.units.end()) return;
  UnitState& state = unit->second.state;
  const bool killed = exit.kind == ProcessExit::Kind::kKilled;
  const bool well = killed ? exit.number == SIGTERM : exit.number == 0;
  state.main_pid = 0;
  state.exec_code = killed ? CLD_KILLED : CLD_EXITED;
  state.exec_status = exit.number;
  state.active = well ? "inactive" : "failed";
  state.result = well ? "success" : killed ? "signal" : "exit-code";
  SendChange(host, unit->first, state);
  if (well) Unload(host, std::string(unit->first));
}

// --- the hosts ---

void SimulatedSystemds::ShutDown(std::size_t host) {
  Machine& machine = machines_[host];
  if (!machine.on || std::exchange(machine.stopping, true)) return;
  for (const auto& [name, unit] : machine.units) {
    After(random_.Between({}, kStopsWithin),
          [this, host, pid = unit.state.main_pid, actuator = unit.actuator] {
            const auto own = static_cast<std::int32_t>(pid);
            if (pid == 0 || processes_.PidOf(actuator, host) != own) return;
            if (processes_.IsFrozen(actuator, host)) return;
            processes_.End(actuator, host, {ProcessExit::Kind::kExited, 0});
          });
  }
}

void SimulatedSystemds::PowerOff(std::size_t host) {
  machines_[host] = {};
  machines_[host].on = false;
  for (const auto& one : bridges_) {
    const BridgePtr bridge = one.lock();
    if (bridge && bridge->to == host) bridge->alive = false;
  }
}

void SimulatedSystemds::Boot(std::size_t host) {
  machines_[host].on = true;
}

}  // namespace musher::simulation
