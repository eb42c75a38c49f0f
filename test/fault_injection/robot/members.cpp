#include "musher/test/fault_injection/robot/members.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "musher/test/fault_injection/robot/board.hpp"

namespace musher::fault_injection {
namespace {

std::string StatesKey() {
  std::string key;
  for (const char* state : kStates)
    key += (key.empty() ? "[\"" : ", \"") + std::string(state) + '"';
  return key + "]";
}

std::string TimesKey() {
  std::string key = "[8000";  // SetUp: a process has to start first
  for (std::size_t i = 1; i < std::size(kStates); ++i)
    key += ", " + std::to_string(kCallbackTimeMs);
  return key + "]";
}

std::string CommandKey(const std::vector<std::string>& words) {
  std::string key;
  for (const std::string& word : words) {
    key += (key.empty() ? "command = [\"" : ", \"") + word + '"';
  }
  return key + "]\n";
}

// All starts in a row count, whatever starts the process.
constexpr const char* kResetKey = "restart_reset_ms = 200\n";

std::string RestartKeys(const Member& member) {
  return "restart = \"" + member.restart + "\"\nrestart_delay_ms = 50\nrestart_growth = 1.5\n" +
         "restart_limit = " + std::to_string(kRestartLimit) + "\n";
}

std::string Table(const Member& member, Shape shape, const std::string& folder,
                  const std::string& programs) {
  std::string table = "\n[actuator." + member.name + "]\nstates = " + StatesKey() +
                      "\ntimes = " + TimesKey() + "\n" + member.keys;
  if (member.ros2) table += "protocol = \"ros2_lifecycle\"\n";
  if (member.critical) table += "critical = true\n";
  if (!member.on_lost.empty()) table += "on_lost = \"" + member.on_lost + "\"\n";
  if (member.checkpoint_ms > 0) {
    table += "checkpoint_ms = " + std::to_string(member.checkpoint_ms) + "\n";
  }
  if (!member.ros2) {
    table += "controller_lost_ms = " + std::to_string(ControllerLostMs(shape)) +
             "\non_controller_lost = \"" + kOnControllerLost + "\"\n";
  }
  table += kResetKey;
  if (!AreThere(shape)) {
    table += CommandKey(CommandOf(member, folder, programs)) + RestartKeys(member);
  }
  return table;
}

}  // namespace

const std::vector<Member>& Members() {
  static const std::vector<Member> members = {
      {"legs", true, "on-failure", 400, "Protected", "", false},
      {"arm", false, "on-failure", 300, "", "after = [\"legs\"]\n", false},
      {"eyes", false, "always", 500, "", "", false},
      {"hands", false, "on-failure", 0, "", "after = [\"arm\"]\n", false},
      {"planner", true, "no", 400, "LowPower", "", false},
      {"voice", false, "on-failure", 0, "", "", true},
      {"mapper", false, "on-failure", 0, "", "", false, true},
  };
  return members;
}

const Member& MemberOf(const std::string& name) {
  for (const Member& member : Members()) {
    if (member.name == name) return member;
  }
  throw std::logic_error("no actuator is named " + name);
}

std::vector<std::string> Modules() {
  std::vector<std::string> names;
  for (const Member& member : Members()) {
    if (!member.wrapped && !member.ros2) names.push_back(member.name);
  }
  return names;
}

bool IsOnBoard(const Member& member, Shape shape) {
  return !member.ros2 || shape == Shape::kHere;
}

std::vector<std::string> CommandOf(const Member& member, const std::string& folder,
                                   const std::string& programs) {
  if (member.ros2) return {programs + "/protocol_peer", "ros2", kNameSpace, member.name, "10000"};
  if (member.wrapped) return {programs + "/musher-exec", folder + "/" + member.name + ".toml"};
  return {programs + "/fault_injection_module", member.name, folder + "/" + member.name + ".board",
          std::to_string(kHz)};
}

std::string ProgramText() {
  return "[state.SetUp]\nstart = [\"sleep\", \"infinity\"]\n\n[emergency_stop]\nrun = "
         "[\"true\"]  # nothing of it moves\n";
}

std::string ConfigText(Shape shape, const std::string& folder, const std::string& programs,
                       const std::string& machine) {
  std::string names;
  std::string tables;
  for (const Member& member : Members()) {
    if (!IsOnBoard(member, shape)) continue;
    names += (names.empty() ? "[\"" : ", \"") + member.name + '"';
    tables += Table(member, shape, folder, programs);
  }
  if (shape != Shape::kHere) tables += "\n[transport]\nprofile = \"lan\"\n";
  const std::string failover = shape == Shape::kStandby ? "failover_ms = 3000\n" : "";
  return "[controller]\n" + failover + "name = \"" + machine + "\"\nnamespace = \"" + kNameSpace +
         "\"\nactuators = " + names + "]\nstates = " + StatesKey() +
         "\ndefault_time = 2000\ndefault_state = \"Uninitialized\"\nstate_dir = \"disk/state\"\n"
         "shutdown_budget_ms = " +
         std::to_string(kShutdownBudgetMs) + "\njournal_size_mb = 4\n" + tables;
}

int RankOf(const std::string& state) {
  static const std::map<std::string, int> ranks = {{"TearDown", 0},  {"Error", 1},
                                                   {"LowPower", 3},  {"DeActive", 4},
                                                   {"Protected", 5}, {"Active", 6}};
  const auto rank = ranks.find(state);
  return rank == ranks.end() ? -1 : rank->second;
}

const msg::ActuatorInfo& Find(const msg::MachineStatus& status, const std::string& actuator) {
  const auto found = std::find_if(status.actuators.begin(), status.actuators.end(),
                                  [&](const auto& info) { return info.name == actuator; });
  if (found == status.actuators.end()) throw std::logic_error("the machine has no " + actuator);
  return *found;
}

bool IsSettled(const msg::MachineStatus& status, const std::string& state,
               const std::set<std::string>& without) {
  if (status.phase != "running" || status.state != state || !status.target.empty()) return false;
  return std::all_of(status.actuators.begin(), status.actuators.end(), [&](const auto& info) {
    if (without.count(info.name) > 0) return true;
    return info.presence == "present" && info.state == state && info.target.empty() &&
           info.health == "well" && !info.degraded && !info.restarting && !info.held;
  });
}

}  // namespace musher::fault_injection
