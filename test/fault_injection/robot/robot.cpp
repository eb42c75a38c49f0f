#include "musher/test/fault_injection/robot/robot.hpp"

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/test/fault_injection/robot/processes.hpp"

namespace musher::fault_injection {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStallFile = "disk_stalls";
constexpr const char* kOtherMachine = "other";  // and its folder
constexpr int kPollMs = 2;

std::string Quoted(const std::string& word) {
  return "'" + word + "'";
}

}  // namespace

bool AwaitThat(const std::function<bool()>& is_so, Duration timeout) {
  const Time deadline = std::chrono::steady_clock::now() + timeout;
  while (!is_so()) {
    ThrowIfInterrupted();
    if (std::chrono::steady_clock::now() > deadline) return false;
    poll(nullptr, 0, kPollMs);
  }
  return true;
}

void WriteConfigs(const fs::path& folder, const std::string& robot) {
  std::ofstream(folder / "robot.toml") << robot;
  for (const Member& member : Members()) {
    if (member.wrapped) std::ofstream(folder / (member.name + ".toml")) << ProgramText();
  }
}

Robot::Robot(Shape shape, fs::path folder, int domain)
    : shape_(shape), folder_(std::move(folder)), domain_(domain) {
  const std::string programs = fs::path(benchmark::Program("musher")).parent_path();
  WriteConfigs(folder_, ConfigText(shape, folder_, programs));
  for (const Member& member : Members()) {
    boards_[member.name] = &OpenBoard(folder_ / (member.name + ".board"));
  }
  const bool beside_another = shape == Shape::kOnLan;
  if (shape != Shape::kHere) far_host_ = std::make_unique<FarHost>(folder_, Environment());
  const auto profile = shape == Shape::kHere ? TransportProfile::kLocal : TransportProfile::kLan;
  observer_ = std::make_unique<Observer>(domain, profile, kNameSpace, beside_another);
  if (!beside_another) {
    if (far_host_) far_host_->Go();
    return;
  }
  const fs::path other = folder_ / kOtherMachine;
  fs::create_directories(other);
  WriteConfigs(other, ConfigText(shape, other, programs, kOtherMachine));
  for (const Member& member : Members()) OpenBoard(other / (member.name + ".board"));
}

Robot::~Robot() {
  launchers_.clear();
  observer_.reset();  // while its end of the link exists
  far_host_.reset();
  KillMarked("MUSHER_FAULT_INJECTION_ROBOT=" + folder_.string());
}

benchmark::Child::Environment Robot::Environment() const {
  return {{"ROS_DOMAIN_ID", std::to_string(domain_)},
          {"MUSHER_NAMESPACE", kNameSpace},
          {"MUSHER_FAULT_INJECTION_ROBOT", folder_},
          {"MUSHER_CONFIG", folder_ / "robot.toml"},
          {"MUSHER_TRANSPORT", shape_ == Shape::kHere ? "local" : "lan"}};
}

std::vector<std::string> Robot::ShellLine(const std::vector<std::string>& words,
                                          const std::string& log, Disk disk) const {
  std::string line = "exec ";
  if (disk == Disk::kMayStall) {
    // Without this option AddressSanitizer refuses to run when its library is not the first.
    line += "env ASAN_OPTIONS=\"$ASAN_OPTIONS:verify_asan_link_order=0\" LD_PRELOAD=" +
            Quoted(benchmark::Program("fault_injection_stalling_disk.so")) +
            " MUSHER_STALL_BELOW=" + Quoted(StateFolder()) +
            " MUSHER_STALL_WHILE=" + Quoted(folder_ / kStallFile) + " ";
  }
  line += Quoted(benchmark::Program("musher"));
  for (const std::string& word : words) line += " " + Quoted(word);
  line += " >> " + Quoted(folder_ / log) + " 2>> " + Quoted(folder_ / "errors.log");
  return {"/bin/sh", "-c", line};
}

void Robot::StallDisk(bool stalls) {
  if (stalls) {
    std::ofstream(folder_ / kStallFile) << "remove this file to end the stall\n";
  } else {
    fs::remove(folder_ / kStallFile);
  }
}

void Robot::StartController(const std::vector<std::string>& more, Disk disk) {
  std::vector<std::string> words = {"up", folder_ / "robot.toml", "--json"};
  words.insert(words.end(), more.begin(), more.end());
  launchers_.emplace_back(ShellLine(words, "up.jsonl", disk), Environment());
}

benchmark::Child Robot::StartFarController(const std::vector<std::string>& more) {
  std::vector<std::string> words = {"up", folder_ / "robot.toml", "--json"};
  words.insert(words.end(), more.begin(), more.end());
  fs::remove(folder_ / "up-far.jsonl");
  return benchmark::Child(far_host_->There(ShellLine(words, "up-far.jsonl")), Environment());
}

std::string Robot::TimeOfFarLine(const std::string& text) const {
  std::ifstream file(folder_ / "up-far.jsonl");
  std::string time;
  for (std::string line; std::getline(file, line);) {
    const auto json = nlohmann::json::parse(line, nullptr, false);
    if (!json.is_object()) continue;
    if (json.value("message", "").find(text) != std::string::npos) time = json.value("time", "");
  }
  return time;
}

std::string Robot::TimeOfLine(const std::string& text) {
  std::string time;
  for (const nlohmann::json& line : Lines()) {
    if (line.value("message", "").find(text) != std::string::npos) time = line.value("time", "");
  }
  return time;
}

benchmark::Child::Environment Robot::OtherEnvironment() const {
  benchmark::Child::Environment environment = Environment();
  environment["MUSHER_CONFIG"] = folder_ / kOtherMachine / "robot.toml";
  return environment;
}

benchmark::Child Robot::StartOther() {
  const std::string config = folder_ / kOtherMachine / "robot.toml";
  return benchmark::Child(far_host_->There(ShellLine({"up", config, "--json"}, "up-other.jsonl")),
                          OtherEnvironment());
}

int Robot::OtherMusher(const std::vector<std::string>& words) {
  benchmark::Child child(far_host_->There(ShellLine(words, "cli-other.log")), OtherEnvironment());
  return AwaitEnd(child);
}

int Robot::Musher(const std::vector<std::string>& words) {
  benchmark::Child child(ShellLine(words, "cli.log"), Environment());
  return AwaitEnd(child);
}

int Robot::AwaitEnd(benchmark::Child& child) {
  siginfo_t ended{};
  AwaitThat(
      [&] {
        waitid(P_PID, child.pid(), &ended, WEXITED | WNOHANG | WNOWAIT);
        return ended.si_pid != 0;
      },
      kTimeout);
  return ended.si_pid != 0 ? child.Wait() : -1;
}

void Robot::Up() {
  StartController();
  if (!AwaitSettled()) throw std::runtime_error("the robot does not come up");
}

bool Robot::AwaitSettled(const std::string& state) {
  pid_t pid = 0;
  const auto forked = [&] {
    pid = ControllerPid();
    return pid != 0 || ControllerHasEnded();
  };
  if (!AwaitThat(forked, kTimeout) || pid == 0) return false;
  const auto settled = [&](const msg::MachineStatus& status) {
    return status.pid == pid && RankOf(status.state) >= 0 &&
           IsSettled(status, state.empty() ? status.state : state);
  };
  return observer_->Await(settled, kTimeout).has_value();
}

void Robot::Down() {
  (void)AwaitFuture(observer_->SetState("TearDown"));
  if (!AwaitControllerEnd(kTimeout)) throw std::runtime_error("the robot does not go down");
}

void Robot::GoTo(const std::string& state) {
  const auto settled = [&](const msg::MachineStatus& s) { return IsSettled(s, state); };
  const auto latest = observer_->Latest();
  if (!latest || latest->state != state) (void)AwaitFuture(observer_->SetState(state));
  if (!observer_->Await(settled, kTimeout)) {
    throw std::runtime_error("the robot does not settle in " + state);
  }
}

void Robot::Fix() {
  for (auto& [name, board] : boards_) ClearFaults(*board);
  if (far_host_) far_host_->link().Heal();
  if (ControllerHasEnded()) Up();
  auto status = observer_->GetStatus();
  if (!status) throw std::runtime_error("the controller does not reply");
  if (status.value().emergency_stop) (void)observer_->ReleaseEmergencyStop();
  for (const msg::ActuatorInfo& info : status.value().actuators) {
    const bool down = info.presence != "present" && !info.restarting;
    if (down && !AreThere(shape_)) (void)observer_->Restart(info.name);
  }
  if (status.value().state == "Error") (void)AwaitFuture(observer_->SetState("SelfCheck"));
  GoTo("Active");
}

pid_t Robot::RunningController() {
  const pid_t pid = ControllerPid();
  if (pid <= 0) throw std::runtime_error("there is no controller");
  return pid;
}

pid_t Robot::ControllerPid() {
  if (launchers_.empty()) return 0;
  const std::vector<pid_t> children = ChildrenOf(launchers_.back().pid());
  return children.empty() ? 0 : children.front();
}

std::map<std::string, int> Robot::StartedProcesses() const {
  const std::string prefix = NameLock::NameOf(domain_, kNameSpace, "");
  std::map<std::string, int> running;
  for (const MarkedProcess& process : FindMarked()) {
    const bool ours = process.pid == process.started && process.mark.starts_with(prefix);
    if (ours) ++running[process.mark.substr(prefix.size())];
  }
  return running;
}

pid_t Robot::PidOf(const std::string& name) {
  pid_t pid = 0;
  if (AreThere(shape_)) {
    const std::vector<pid_t> found = FindByArgument(folder_ / (name + ".board"));
    if (!found.empty()) pid = found.front();
  } else if (const auto status = observer_->Latest()) {
    pid = Find(*status, name).pid;
  }
  // A signal to 0 would hit the whole process group of this process.
  if (pid <= 0) throw std::runtime_error(name + " has no process");
  return pid;
}

bool Robot::IsChildOfController(const std::string& name) {
  const std::vector<pid_t> children = ChildrenOf(ControllerPid());
  return std::find(children.begin(), children.end(), PidOf(name)) != children.end();
}

bool Robot::ControllerHasEnded() const {
  return launchers_.empty() || !IsAlive(launchers_.back().pid());
}

bool Robot::AwaitControllerEnd(Duration timeout) {
  const bool ended = AwaitThat([&] { return ControllerHasEnded(); }, timeout);
  if (ended) launchers_.clear();
  return ended;
}

int Robot::AwaitEndOfFirst() {
  benchmark::Child& first = launchers_.front();
  if (!AwaitThat([&] { return !IsAlive(first.pid()); }, kTimeout)) return -1;
  const int exit_code = first.Wait();
  launchers_.erase(launchers_.begin());
  return exit_code;
}

void Robot::KillController() {
  const pid_t pid = ControllerPid();
  if (pid != 0) kill(pid, SIGKILL);
  if (!AwaitControllerEnd(kTimeout)) throw std::runtime_error("the controller has not ended");
}

const std::vector<nlohmann::json>& Robot::Lines() {
  std::ifstream file(folder_ / "up.jsonl");
  file.seekg(read_);
  for (std::string line; std::getline(file, line) && !file.eof();) {
    read_ += static_cast<std::streamoff>(line.size()) + 1;
    auto json = nlohmann::json::parse(line, nullptr, false);
    if (json.is_object()) lines_.push_back(std::move(json));
  }
  return lines_;
}

void Robot::ForgetLines() {
  Lines();
  lines_.clear();
}

int Robot::CountLines(const std::string& kind, const std::string& text) {
  const auto& lines = Lines();
  return static_cast<int>(
      std::count_if(lines.begin(), lines.end(), [&](const nlohmann::json& line) {
        return line.value("kind", "") == kind &&
               line.value("message", "").find(text) != std::string::npos;
      }));
}

std::vector<pid_t> Robot::OwnChildren() const {
  std::vector<pid_t> pids;
  for (const benchmark::Child& launcher : launchers_) pids.push_back(launcher.pid());
  if (far_host_) pids.push_back(far_host_->pid());
  return pids;
}

}  // namespace musher::fault_injection
