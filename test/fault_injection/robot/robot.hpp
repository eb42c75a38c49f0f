#pragma once
// A robot of real processes: `musher up` as an operator runs it, its actuators, and an observer.
//
// Threads: the fault-injection suite's. Errors: throws std::runtime_error when the robot does not
// reach the state in which a run begins; that run has failed.

#include <sys/types.h>

#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/fault_injection/host/far_host.hpp"
#include "musher/test/fault_injection/robot/board.hpp"
#include "musher/test/fault_injection/robot/members.hpp"
#include "musher/test/fault_injection/robot/observer.hpp"

namespace musher::fault_injection {

class Robot {
 public:
  // Its files are in `folder`, which must exist.
  Robot(Shape shape, std::filesystem::path folder, int domain);
  // Kills all of its processes.
  ~Robot();
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  // kMayStall: writes of the started process below the state folder stall while StallDisk() is set.
  enum class Disk { kWorks, kMayStall };
  // Starts a controller in the foreground, as `musher up robot.toml --json [more]`.
  void StartController(const std::vector<std::string>& more = {}, Disk disk = Disk::kWorks);
  void StallDisk(bool stalls);
  // The same on the other host, which has a disk of its own. The child is the launcher.
  benchmark::Child StartFarController(const std::vector<std::string>& more);
  // The same, and waits until the machine is settled in Active, or in the state in which it is
  // adopted.
  void Up();
  // Another robot on the other host, of the same actuators, namespace and domain: starts it, and
  // runs a command there. The child is the launcher.
  benchmark::Child StartOther();
  int OtherMusher(const std::vector<std::string>& words);
  // Waits until the current controller leads and the machine is settled in `state` (empty: any
  // state with a rank).
  bool AwaitSettled(const std::string& state = "");
  // TearDown, and waits for the end of all processes.
  void Down();
  // Brings the machine to `state` and waits until it is settled there.
  void GoTo(const std::string& state);
  // Repairs what a run left: clears the boards, restarts actuators that were given up, releases the
  // emergency stop. Throws when the robot does not settle in Active.
  void Fix();

  // Runs a command of the CLI to its end; returns its exit code, its output goes to cli.log.
  int Musher(const std::vector<std::string>& words);

  Observer& observer() { return *observer_; }
  Board& board(const std::string& name) { return *boards_.at(name); }
  pid_t ControllerPid();  // 0: there is none
  // For signals: throws std::runtime_error when there is none.
  pid_t RunningController();
  // Of an actuator, as this pid namespace numbers it. Throws std::runtime_error when there is none.
  pid_t PidOf(const std::string& name);
  // The number of processes on this host that a controller has started, by actuator.
  std::map<std::string, int> StartedProcesses() const;
  // Whether the current controller has started its process; it knows the exit code of its children
  // only.
  bool IsChildOfController(const std::string& name);
  // Whether the launcher of the current controller has ended.
  bool ControllerHasEnded() const;
  bool AwaitControllerEnd(Duration timeout);
  // Waits for the first launcher; returns its exit code, -1: it still runs.
  int AwaitEndOfFirst();
  void KillController();

  // The output of the controllers since ForgetLines(): documents of `up --json`.
  const std::vector<nlohmann::json>& Lines();
  void ForgetLines();
  // How many of them are of this kind, with this text in their message.
  // When the controller here, and the last one of the other host, has printed a line with `text`;
  // "": not yet.
  std::string TimeOfLine(const std::string& text);
  std::string TimeOfFarLine(const std::string& text) const;
  int CountLines(const std::string& kind, const std::string& text = "");

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path StateFolder() const { return folder_ / "disk" / "state"; }
  Shape shape() const { return shape_; }
  // Children of this process that the robot itself reaps.
  std::vector<pid_t> OwnChildren() const;

  FarHost* far_host() { return far_host_.get(); }  // null when all are here

 private:
  benchmark::Child::Environment Environment() const;
  benchmark::Child::Environment OtherEnvironment() const;
  static int AwaitEnd(benchmark::Child& child);
  std::vector<std::string> ShellLine(const std::vector<std::string>& words, const std::string& log,
                                     Disk disk = Disk::kWorks) const;

  const Shape shape_;
  const std::filesystem::path folder_;
  const int domain_;
  std::map<std::string, Board*> boards_;
  std::unique_ptr<FarHost> far_host_;  // before the observer, which needs its link
  std::unique_ptr<Observer> observer_;
  std::list<benchmark::Child> launchers_;  // the last one is the current controller's
  std::streamoff read_ = 0;                // of up.jsonl
  std::vector<nlohmann::json> lines_;
};

inline constexpr Duration kTimeout = std::chrono::seconds(30);

// Polls a condition that has no event; throws Interrupted.
bool AwaitThat(const std::function<bool()>& is_so, Duration timeout);

}  // namespace musher::fault_injection
