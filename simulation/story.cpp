#include "musher/simulation/story.hpp"

#include <algorithm>
#include <utility>

#include "musher/simulation/way.hpp"

namespace musher::simulation {
namespace {

using transport::sim::Random;

constexpr Duration kForEver = std::chrono::hours(24);

// A number that depends on nothing but these.
std::uint64_t Scramble(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  Random dice(a * 0x9e3779b97f4a7c15 + b * 0xbf58476d1ce4e5b9 + c);
  dice.Next();
  return dice.Next();
}

// Nobody publishes /clock: the time of a story is that of its world.
MachineConfig InStorysTime(MachineConfig config) {
  config.clock = ClockSource::kSteady;
  return config;
}

}  // namespace

Story::Story(const MachineConfig& config, std::uint64_t seed, Incidents incidents,
             const StoryOptions& options)
    : config_(config),
      seed_(seed),
      incidents_(std::move(incidents)),
      options_(options),
      supervised_(Scramble(seed, 3, 3) % 2 == 0),
      moods_(config.actuators.size()),
      runs_(config.actuators.size()),
      robot_(
          seed, InStorysTime(config),
          [this](const std::string& name, const State& state) { return DrawAct(name, state); },
          DrawLayout(config, seed, options.shared_processes)),
      judge_(robot_) {
  for (std::size_t i = 0; i < config.actuators.size(); ++i) {
    for (const State& state : config.actuators[i].states) {
      patience_ = std::max(patience_, config.TimeFor(i, state) + Milliseconds(500));
    }
  }
  robot_.on_killed = [this](const ControllerProcess& controller) {
    judge_.ControllerKilled(controller);
  };
  robot_.on_record = [this](const action::Record& record) {
    Mix(record.message);
    judge_.OnRecord(record);
    if (listener.on_record) listener.on_record(robot_.network().now(), record);
  };
}

Story::~Story() = default;

void Story::UseModule(const std::string& actuator,
                      std::function<std::unique_ptr<Module>(const Draw& draw)> make) {
  auto& make_module = robot_.processes().make_module;
  make_module = [this, actuator, make = std::move(make),
                 others = std::move(make_module)](const std::string& name) {
    if (name != actuator) return others(name);
    return make([this, name](const State& state) { return DrawAct(name, state); });
  };
}

Ending TellStory(const MachineConfig& config, std::uint64_t seed, const Incidents& incidents,
                 const StoryOptions& options) {
  return Story(config, seed, incidents, options).Tell();
}

Ending Story::Tell() {
  SwitchOn();
  if (!Over()) Befall();
  if (!Over()) Cease();
  if (!Over()) Rest();
  if (!Over()) Repair();
  if (!Over()) SwitchOff();
  ending_.violation = judge_.violation();
  ending_.judgements = judge_.judgements();
  ending_.steps = robot_.network().steps();
  ending_.simulated = robot_.age();
  return ending_;
}

void Story::Mix(const std::string& text) {
  for (const char c : text) {  // FNV-1a
    ending_.fingerprint = (ending_.fingerprint ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  }
  ending_.fingerprint ^=
      static_cast<std::uint64_t>(robot_.network().now().time_since_epoch().count());
}

// Usually some milliseconds, and never longer than allowed; unless something is wrong.
Act Story::DrawAct(const std::string& name, const State& state) {
  const std::size_t i = *config_.IndexOf(name);
  Random dice(Scramble(seed_, i, ++runs_[i]));
  const Duration limit = config_.TimeFor(i, state);
  Act act;
  act.takes = std::min(limit / 2, dice.Between(std::chrono::microseconds(200), Milliseconds(40)));
  const Time now = robot_.network().now();
  const Mood& mood = moods_[i];
  if (now < mood.fails) act.error = {kCodeFailed, "drawn"};
  if (now < mood.slow) act.takes = dice.Between(limit / 2, limit + limit / 4);
  if (now < mood.hangs) act.takes = kForEver;
  return act;
}

void Story::Later(Duration delay, std::function<void()> what) {
  later_.push_back({robot_.network().now() + delay, std::move(what)});
}

bool Story::RunUntil(const std::function<bool()>& done, Duration limit) {
  const Time end = robot_.network().now() + limit;
  for (;;) {
    const auto next = std::min_element(later_.begin(), later_.end(),
                                       [](const Deed& a, const Deed& b) { return a.at < b.at; });
    const bool first = next != later_.end() && next->at <= end;
    const Time until = first ? next->at : end;
    bool held = false;
    const auto stop = [&] {
      judge_.AfterEvent();
      if (listener.on_change) listener.on_change(robot_.network().now(), robot_);
      held = done();
      return held || Over();
    };
    if (robot_.network().RunUntil(stop, until)) return held;
    if (!first) return false;
    const auto what = std::move(next->what);
    later_.erase(next);
    what();
    judge_.AfterEvent();
  }
}

void Story::RunFor(Duration duration) {
  RunUntil([] { return false; }, duration);
}

void Story::SwitchOn() {
  Random dice(Scramble(seed_, 1, 1));
  for (std::size_t host = 0; host < robot_.hosts().size(); ++host) {
    // Hosts are switched on at different times.
    robot_.hosts().SetUptime(host, dice.Between(std::chrono::seconds(10), std::chrono::hours(1)));
  }
  for (std::size_t i = 0; i < config_.actuators.size(); ++i) {
    if (!IsByHand(i)) continue;
    Later(dice.Between(Duration::zero(), Milliseconds(50)), [this, i] { StartByHand(i); });
  }
  StartController();
}

void Story::StartController(bool restarted) {
  robot_.LaunchController(0, true, robot_.ListenTime(), restarted);
}

bool Story::IsByHand(std::size_t actuator) const {
  return config_.actuators[actuator].command.empty() &&
         robot_.layout().ProcessOf(actuator) == actuator;
}

void Story::StartByHand(std::size_t actuator) {
  const std::string& name = config_.actuators[actuator].name;
  if (!robot_.IsAlive(name)) robot_.StartActuator(name);
}

void Story::Befall() {
  for (const Incident& incident : incidents_) {
    RunFor(incident.at - robot_.age());
    if (incident.when) RunUntil([&] { return Now() == *incident.when; }, patience_);
    if (Over()) return;
    ending_.coverage.Count(incident.kind, Now());
    if (listener.on_incident) listener.on_incident(robot_.network().now(), incident);
    Do(incident);
    judge_.AfterEvent();
  }
  while (!later_.empty() && !Over()) {
    RunFor(later_.back().at - robot_.network().now());
  }
}

Moment Story::Now() const {
  const ControllerProcess* leader = robot_.leader();
  return MomentOf(leader == nullptr ? nullptr : &leader->shell().machine());
}

// The world becomes kind.
void Story::Cease() {
  if (config_.policy) robot_.SetMotion(303);  // who lies still goes to rest by itself
  std::fill(moods_.begin(), moods_.end(), Mood{});
  for (const ActuatorConfig& actuator : config_.actuators) {
    robot_.processes().Misconfigure(actuator.name, false);
  }
  if (!robot_.has_controller()) {
    Note("the controller is started again");
    robot_.CrashController();
    StartController();
  }
}

void Story::Rest() {
  const Time ceased = robot_.network().now();
  if (!ComeToRest(std::to_string(ToMilliseconds(options_.bound)) +
                  " ms after the last fault has ceased")) {
    return;
  }
  ending_.rested = robot_.network().now() - ceased;
  // What is only just noticed comes yet.
  RunFor(std::chrono::seconds(15));
  if (ComeToRest("though it had been")) judge_.JudgeRest(options_.provided);
}

void Story::Note(const std::string& deed) {
  if (listener.on_deed) listener.on_deed(robot_.network().now(), deed);
}

}  // namespace musher::simulation
