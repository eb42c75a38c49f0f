#pragma once
// musher-view beside a controller whose config has [view]: started with it, restarted with back-off
// when it ends, ended with it. It never affects the machine: what goes wrong is a line in the log.
//
//   running ──it ends──▶ waiting (1 s, doubled up to a minute; 1 s again after a minute of running)
//      ▲                    │
//      └────────────────────┘      exit code 2, a wrong option: not restarted
//
// Threads: loop thread only. Its output goes to logs/musher-view.log.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/program.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cli {

inline constexpr const char* kViewProgram = "musher-view";

// The program with the options that the config gives. `config` has [view].
std::vector<std::string> ViewCommand(const MachineConfig& config);
// What it gets beside the environment of this process: it reaches the hosts that the controller
// reaches, with an operator's credentials.
std::map<std::string, std::string> ViewEnvironment(const MachineConfig& config);

class ViewProcess {
 public:
  using OnTrouble = std::function<void(const std::string& message)>;

  // Starts it. The loop must outlive it.
  ViewProcess(transport::EventLoop& loop, const MachineConfig& config, OnTrouble on_trouble);
  // SIGTERM, and waits at most a second for its end, then SIGKILL.
  ~ViewProcess();
  ViewProcess(const ViewProcess&) = delete;
  ViewProcess& operator=(const ViewProcess&) = delete;

  pid_t pid() const { return program_ ? program_->pid() : 0; }  // 0: it does not run

 private:
  void Start();
  void OnEnd();
  void StartLater(const std::string& why);

  transport::EventLoop& loop_;
  const std::vector<std::string> command_;
  const std::map<std::string, std::string> environment_;
  const std::string log_;
  const OnTrouble on_trouble_;
  std::optional<ForkedProgram> program_;
  Time started_at_;
  Duration pause_ = std::chrono::seconds(1);
  transport::LoopHandlePtr end_watch_;
  transport::LoopHandlePtr restart_;
};

}  // namespace musher::cli
