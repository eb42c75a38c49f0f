#pragma once
// A robot of real processes: `musher up` as a person runs it, its actuators, and an observer beside
// it.
//
// Threads: the fault-injection suite's. Errors: throws std::runtime_error when the robot cannot be
// brought into the state that a run begins in; that is a failed run, too.

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
#include "musher/test/fault_injection/robot/crew.hpp"
#include "musher/test/fault_injection/robot/observer.hpp"

namespace musher::fault_injection {

class Robot {
 public:
  // Its files are in `folder`, which has to be there.
  Robot(Shape shape, std::filesystem::path folder, int domain);
  // Kills what is left of it.
  ~Robot();
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  // kMayStall: below the state folder it stalls while StallDisk() says so, for those processes that
  // are started with this.
  enum class Disk { kWorks, kMayStall };
  // Starts a controller in the foreground, as `musher up robot.toml --json [more]`.
  void StartController(const std::vector<std::string>& more = {}, Disk disk = Disk::kWorks);
  void StallDisk(bool stalls);
  // The same on the other host, which has a disk of its own. The child lives as long as its front.
  benchmark::Child StartFarController(const std::vector<std::string>& more);
  // The same and waits until the machine is settled: in Active, or where it is adopted.
  void Up();
  // Waits until the present controller leads and all is settled in `state` (empty: any state with a
  // rank).
  bool AwaitSettled(const std::string& state = "");
  // TearDown, and waits for the end of all.
  void Down();
  // Brings the machine to `state` and waits until it is settled there.
  void GoTo(const std::string& state);
  // Whatever a run left: boards relieved, those given up restarted, emergency stop released.
  // Throws when the robot does not settle in Active.
  void Fix();

  // Runs a command of the CLI to its end; gives its exit code, what it prints goes to cli.log.
  int Musher(const std::vector<std::string>& words);

  Observer& observer() { return *observer_; }
  Board& board(const std::string& name) { return *boards_.at(name); }
  pid_t ControllerPid();  // 0: there is none
  // To be sent a signal: throws std::runtime_error when there is none.
  pid_t LivingController();
  // Of an actuator, as this pid namespace numbers it. Throws std::runtime_error when there is none.
  pid_t PidOf(const std::string& name);
  // How many processes run on this host that a controller has started, by actuator.
  std::map<std::string, int> StartedProcesses() const;
  // Whether the present controller has started its process; of others it cannot know how they end.
  bool IsChildOfController(const std::string& name);
  // Whether the front of the present controller has ended.
  bool ControllerHasEnded() const;
  bool AwaitControllerEnd(Duration patience);
  // The front of the one before the present one; -1: it still runs.
  int AwaitEndOfFirst();
  void KillController();

  // What controllers have printed since ForgetLines(): documents of `up --json`.
  const std::vector<nlohmann::json>& Lines();
  void ForgetLines();
  // How many of them are of this kind, with this text in their message.
  int CountLines(const std::string& kind, const std::string& text = "");

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path StateFolder() const { return folder_ / "disk" / "state"; }
  Shape shape() const { return shape_; }
  // Processes that are this one's children and not to be reaped by others.
  std::vector<pid_t> OwnChildren() const;

  FarHost* far_host() { return far_host_.get(); }  // null when all are here

 private:
  benchmark::Child::Environment Environment() const;
  std::vector<std::string> ShellLine(const std::vector<std::string>& words, const std::string& log,
                                     Disk disk = Disk::kWorks) const;

  const Shape shape_;
  const std::filesystem::path folder_;
  const int domain_;
  std::map<std::string, Board*> boards_;
  std::unique_ptr<FarHost> far_host_;  // before the observer, which needs its link
  std::unique_ptr<Observer> observer_;
  std::list<benchmark::Child> fronts_;  // the last is the present one's
  std::streamoff read_ = 0;             // of up.jsonl
  std::vector<nlohmann::json> lines_;
};

inline constexpr Duration kPatience = std::chrono::seconds(30);

// A poll of what no event tells; throws Interrupted.
bool AwaitThat(const std::function<bool()>& is_so, Duration patience);

}  // namespace musher::fault_injection
