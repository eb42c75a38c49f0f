#pragma once
// Processes that a test starts through a supervisor. A child reports that it runs by writing into a
// named pipe, so no test waits for a time.

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <thread>

#include "musher/base/host.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

#include "musher/controller/process/process_supervisor.hpp"

namespace musher {

inline std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline constexpr Duration kLoading = std::chrono::seconds(20);  // also on a busy machine

class Supervisor : public ::testing::Test {
 protected:
  Supervisor() {
    mkfifo(pipe_path_.c_str(), 0600);
    pipe_ = UniqueFd(open(pipe_path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  }

  ~Supervisor() override {
    supervisor_.reset();
    for (const pid_t pid : started_) {
      kill(-pid, SIGKILL);
      kill(pid, SIGKILL);
      waitpid(pid, nullptr, 0);
    }
  }

  // A shell script; $PIPE is the test's named pipe.
  ProcessSpec Script(const std::string& text) const {
    return {"dog", {"sh", "-c", text}, "", {{"PIPE", pipe_path_}}, output_.get()};
  }

  pid_t MustStart(const ProcessSpec& spec) {
    const auto pid = supervisor_->Start(spec, [this](const ProcessExit& exit) { exit_ = exit; });
    if (!pid) {
      ADD_FAILURE() << pid.error().message;
      return 0;
    }
    started_.insert(pid.value());
    return pid.value();
  }

  std::optional<ProcessExit> WaitForExit() {
    loop_.RunUntil([&] { return exit_.has_value(); }, Deadline());
    return exit_;
  }

  // The next line that a child writes into the pipe.
  std::string WaitForLine() {
    const auto watch = loop_.WhenReadable(pipe_.get(), [&] {
      std::array<char, 512> buffer{};
      const ssize_t size = read(pipe_.get(), buffer.data(), buffer.size());
      if (size > 0) received_.append(buffer.data(), static_cast<std::size_t>(size));
    });
    loop_.RunUntil([&] { return received_.find('\n') != std::string::npos; }, Deadline());
    const auto end = received_.find('\n');
    EXPECT_NE(end, std::string::npos) << "no child has written a line";
    std::string line = received_.substr(0, end);
    received_.erase(0, end == std::string::npos ? end : end + 1);
    return line;
  }

  // Whether a process that need not be a child ends after `action`.
  bool EndsAfter(pid_t pid, const std::function<void()>& action) {
    const auto pidfd = OpenPidfd(pid);
    if (!pidfd) return false;
    bool ended = false;
    const auto watch = loop_.WhenReadable(pidfd.value().get(), [&] { ended = true; });
    action();
    return loop_.RunUntil([&] { return ended; }, Deadline());
  }

  Time Deadline() const { return loop_.Now() + std::chrono::seconds(120); }

  TempFolder folder_;
  const std::string log_ = folder_ / "dog.log";
  const UniqueFd output_{open(log_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0600)};
  const std::string pipe_path_ = folder_ / "pipe";
  UniqueFd pipe_;
  std::string received_;
  transport::LinuxEventLoop loop_;
  std::optional<ProcessExit> exit_;
  std::set<pid_t> started_;
  transport::DiskWriter disk_{loop_};
  std::unique_ptr<ProcessSupervisor> supervisor_ =
      std::make_unique<ProcessSupervisor>(loop_, disk_, kLoading);
};

}  // namespace musher
