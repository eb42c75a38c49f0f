// One [actuator.<name>].

#include <algorithm>
#include <limits>

#include "musher/base/suggest.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::config_toml {
namespace {

constexpr int kLastStage = 9;
constexpr std::int64_t kLargestLogMb = 100'000;
constexpr std::int64_t kMostRestarts = 10'000;
constexpr std::int64_t kHighestExitCode = 255;
constexpr std::int64_t kHighestCode = std::numeric_limits<std::int32_t>::max();
constexpr double kFastestGrowth = 100.0;
constexpr std::int64_t kShortestCheckpointMs = 20;  // below this, a busy kernel looks like a hang
// Half of the lease of a ROS 2 participant. Such a node is never killed for it.
constexpr Duration kDefaultRos2Checkpoint = Milliseconds(5000);
constexpr std::int64_t kShortestControllerLostMs = 1000;  // two heartbeats of a controller

// The states of every start and end, and the consequence where one is missing. SetUp is not among
// them: without it there is no start.
constexpr std::pair<std::string_view, std::string_view> kUsualStates[] = {
    {kSelfCheck, "it is never checked"},
    {kActive, "the machine's switch to Active is refused"},
    {kTearDown, "it ends by a signal only"}};

class ActuatorReader {
 public:
  ActuatorReader(const Member& member, const Table& table, Draft& draft)
      : reader_(table, member.value.at, "actuator." + member.key, draft.findings), draft_(draft) {
    actuator_.config.name = member.key;
    actuator_.at = member.value.at;
  }

  ActuatorDraft Read() {
    ReadStates();
    ReadProcess();
    ReadPlace();
    ReadHostOf(reader_, actuator_.config, draft_);
    ReadLimits(reader_, actuator_.config, draft_);
    ReadRestart();
    ReadLosses();
    reader_.RefuseOthers();
    WarnOfNoEffect();
    return std::move(actuator_);
  }

 private:
  void ReadStates() {
    reader_.Require("states", "an array of strings");
    reader_.Require("times", "an array of integers (milliseconds), one for each state");
    const auto states = reader_.Strings("states");
    const auto times = reader_.Times("times");
    if (states) {
      auto& listed = draft_.actuator_states[actuator_.config.name];
      for (const Word& state : *states) {
        listed.emplace(state.text);
        if (CheckState(state, "states", reader_, draft_)) {
          actuator_.config.states.emplace_back(state.text);
        } else {
          listed.emplace(Nearest(state.text, draft_.known_states));
        }
      }
      RequireUsualStates();
    }
    if (states && times) CompareSizes();
    actuator_.config.times = times.value_or(std::vector<Duration>{});
  }

  std::size_t ArraySize(std::string_view key) { return reader_.Get(key)->As<Array>()->size(); }

  bool MayList(const State& state) const {
    return config_toml::MayList(actuator_.config.name, state, draft_);
  }

  void CompareSizes() {
    const std::size_t states = ArraySize("states");
    const std::size_t times = ArraySize("times");
    if (states == times) return;
    reader_.Fault(reader_.At("times"), "times",
                  "expected one time for each of the " + std::to_string(states) +
                      " states, found " + std::to_string(times));
  }

  void RequireUsualStates() {
    const Position at = reader_.At("states");
    if (!MayList(State(kSetUp))) {
      reader_.Fault(at, "states", "expected \"SetUp\" among them, which every start begins with");
    }
    for (const auto& [state, consequence] : kUsualStates) {
      if (MayList(State(state)) || !draft_.listed_states.contains(std::string(state))) continue;
      const bool stays = state == kTearDown && !reader_.Has("command");
      reader_.Warn(at, "states",
                   Quote(state) + " is not listed: " +
                       (stays ? "without a command, too, it keeps running when the machine stops"
                              : std::string(consequence)));
    }
  }

  void ReadProcess() {
    ReadCommand();
    if (const auto cwd = reader_.String("cwd")) {
      if (cwd->text.empty())
        reader_.Fault(cwd->at, "cwd", "expected a path, found an empty string");
      actuator_.config.cwd = Absolute(draft_.folder, cwd->text);
    }
    ReadEnvironment();
    const auto mb = reader_.Integer("log_size_mb", 1, kLargestLogMb);
    actuator_.config.log_size_bytes = mb ? *mb << 20 : draft_.config.log_size_bytes;
    if (reader_.Has("command")) return;
    for (const std::string_view key : {"cwd", "env", "log_size_mb"}) {
      if (reader_.Has(key)) reader_.Warn(reader_.At(key), key, "has no effect without a command");
    }
  }

  void ReadCommand() {
    const Value* value = reader_.Get("command");
    if (value == nullptr) return;
    if (const auto* line = value->As<std::string>()) {
      reader_.Fault(value->at, "command",
                    "expected an array of strings, found a string; write [\"program\", "
                    "\"argument\"], or [\"sh\", \"-c\", " +
                        Quote(*line) + "] for a shell line");
      return;
    }
    auto words = reader_.Strings("command", {.may_repeat = true});
    if (!words || words->empty()) return;
    std::string& program = words->front().text;
    if (program.empty()) {
      reader_.Fault(words->front().at, "command", "expected a program, found an empty string");
    } else if (program.find('/') != std::string::npos) {
      program = Absolute(draft_.folder, program);
    }
    for (Word& word : *words) actuator_.config.command.push_back(std::move(word.text));
  }

  void ReadEnvironment() {
    const Table* table = reader_.SubTable("env");
    if (table == nullptr) return;
    TableReader env(*table, reader_.At("env"), reader_.path() + ".env", draft_.findings);
    for (const Member& member : *table) {
      if (member.key.empty() ||
          member.key.find_first_of(std::string_view("=\0", 2)) != std::string::npos) {
        reader_.Fault(member.at, "env", "expected a name without '=', found " + Quote(member.key));
      } else if (const auto word = env.String(member.key)) {
        actuator_.config.env.emplace(member.key, word->text);
      }
    }
  }

  void ReadPlace() {
    ActuatorConfig& config = actuator_.config;
    ReadProtocol(reader_, config, draft_);
    config.stage = static_cast<int>(reader_.Integer("stage", 1, kLastStage).value_or(1));
    actuator_.after = reader_.Strings("after", {.may_be_empty = true}).value_or(actuator_.after);
    actuator_.binds_to =
        reader_.Strings("binds_to", {.may_be_empty = true}).value_or(actuator_.binds_to);
    for (const Word& word : actuator_.after) config.after.push_back(word.text);
    for (const Word& word : actuator_.binds_to) config.binds_to.push_back(word.text);
    config.critical = reader_.Bool("critical").value_or(false);
    if (const auto codes =
            reader_.Integers("critical_codes", 1, kHighestCode, {.may_be_empty = true})) {
      config.critical_codes.emplace(codes->begin(), codes->end());
    }
  }

  void ReadRestart() {
    RestartConfig& restart = actuator_.config.restart;
    const auto policy =
        reader_.Choice<RestartPolicy>("restart", {{"no", RestartPolicy::kNo},
                                                  {"on-failure", RestartPolicy::kOnFailure},
                                                  {"always", RestartPolicy::kAlways}});
    const bool is_ours = !actuator_.config.command.empty();
    restart.policy = policy.value_or(is_ours ? RestartPolicy::kOnFailure : RestartPolicy::kNo);
    const auto delay = reader_.Time("restart_delay_ms", 0);
    restart.delay = delay.value_or(restart.delay);
    restart.growth = reader_.Number("restart_growth", 1.0, kFastestGrowth).value_or(restart.growth);
    const auto max_delay = reader_.Time("restart_max_ms");
    restart.max_delay = max_delay.value_or(std::max(restart.max_delay, restart.delay));
    if (restart.max_delay < restart.delay) {
      reader_.Fault(reader_.At("restart_max_ms"), "restart_max_ms",
                    "expected no less than restart_delay_ms (" +
                        std::to_string(ToMilliseconds(restart.delay)) + "), found " +
                        std::to_string(ToMilliseconds(restart.max_delay)));
    }
    const auto limit = reader_.Integer("restart_limit", 0, kMostRestarts);
    restart.limit = static_cast<int>(limit.value_or(restart.limit));
    const auto reset_after = reader_.Time("restart_reset_ms");
    restart.reset_after = reset_after.value_or(restart.reset_after);
    const auto prevent =
        reader_.Integers("restart_prevent_exit_codes", 1, kHighestExitCode, {.may_be_empty = true});
    if (prevent) restart.prevent_exit_codes.assign(prevent->begin(), prevent->end());
    restart.finalized = reader_.Bool("restart_finalized").value_or(false);
  }

  void ReadLosses() {
    ActuatorConfig& config = actuator_.config;
    config.checkpoint = reader_.Time("checkpoint_ms", kShortestCheckpointMs);
    const bool started_elsewhere =
        config.protocol == Protocol::kRos2Lifecycle && !reader_.Has("command");
    if (started_elsewhere && !config.checkpoint) config.checkpoint = kDefaultRos2Checkpoint;
    ReadCheckpointIn();
    config.controller_lost = reader_.Time("controller_lost_ms", kShortestControllerLostMs);
    config.on_controller_lost = HighestUpToProtected();
    if (const auto state = reader_.String("on_controller_lost")) {
      if (CheckRankedState(*state, "on_controller_lost", reader_, draft_) &&
          !MayList(State(state->text))) {
        reader_.Fault(state->at, "on_controller_lost",
                      Quote(state->text) + " is not among its states");
      }
      config.on_controller_lost = State(state->text);
    }
    const bool has_protected = draft_.listed_states.contains(std::string(kProtected));
    if (config.critical && has_protected) config.on_lost = kProtected;
    if (const auto state = reader_.String("on_lost")) {
      CheckRankedState(*state, "on_lost", reader_, draft_);
      config.on_lost = State(state->text);
    }
  }

  void ReadCheckpointIn() {
    const Table* table = reader_.SubTable("checkpoint_ms_in");
    if (table == nullptr) return;
    TableReader allowances(*table, reader_.At("checkpoint_ms_in"),
                           reader_.path() + ".checkpoint_ms_in", draft_.findings);
    for (const Member& member : *table) {
      const auto allowance = allowances.Time(member.key, kShortestCheckpointMs);
      if (!CheckState({member.key, member.at}, "checkpoint_ms_in", reader_, draft_)) continue;
      if (!MayList(State(member.key))) {
        reader_.Fault(member.at, "checkpoint_ms_in",
                      Quote(member.key) + " is not among its states");
      } else if (allowance) {
        actuator_.config.checkpoint_in.emplace(member.key, *allowance);
      }
    }
  }

  State HighestUpToProtected() const {
    State highest;
    Rank highest_rank = -1;
    for (const State& state : actuator_.config.states) {
      const auto rank = draft_.config.RankOf(state);
      if (!rank || *rank <= highest_rank || *rank > *BuiltInRank(kProtected)) continue;
      highest = state;
      highest_rank = *rank;
    }
    return highest;
  }

  // Warns of keys that have no effect.
  void WarnOfNoEffect() {
    const ActuatorConfig& config = actuator_.config;
    if (reader_.Has("host") && reader_.Has("command") && reader_.Has("log_size_mb")) {
      reader_.Warn(reader_.At("log_size_mb"), "log_size_mb",
                   "has no effect with a host: its output is in the journal there");
    }
    if (config.restart.policy != RestartPolicy::kNo && !reader_.Has("command")) {
      reader_.Warn(reader_.At("restart"), "restart", "has no effect without a command");
    }
    if (reader_.Has("on_controller_lost") && !config.controller_lost) {
      reader_.Warn(reader_.At("on_controller_lost"), "on_controller_lost",
                   "has no effect without controller_lost_ms");
    }
    if (config.restart.finalized &&
        (config.command.empty() || config.protocol != Protocol::kRos2Lifecycle)) {
      reader_.Warn(reader_.At("restart_finalized"), "restart_finalized",
                   "has no effect without a command and protocol = \"ros2_lifecycle\"");
    }
    if (config.protocol == Protocol::kMusher) return;
    const bool can_be_queried = config.protocol == Protocol::kRos2Lifecycle;
    for (const std::string_view key : {"checkpoint_ms", "checkpoint_ms_in", "controller_lost_ms"}) {
      if (reader_.Has(key) && !(can_be_queried && key == "checkpoint_ms")) {
        reader_.Warn(reader_.At(key), key,
                     "has no effect with this protocol, which does not support it");
      }
    }
  }

  TableReader reader_;
  Draft& draft_;
  ActuatorDraft actuator_;
};

}  // namespace

ActuatorDraft ReadActuator(const Member& member, const Table& table, Draft& draft) {
  return ActuatorReader(member, table, draft).Read();
}

}  // namespace musher::config_toml
