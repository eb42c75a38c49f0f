#pragma once
// A host of its own on this computer: namespaces for its network and its processes, which one
// process holds. Needs root.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <fstream>
#include <functional>
#include <future>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/test/support/musher.hpp"
#include "musher/test/support/process.hpp"

namespace musher::testing {

class Host {
 public:
  Host()
      : holder_({"unshare", "--net", "--pid", "--fork", "--kill-child", "--mount-proc", "sh", "-c",
                 "echo $(awk '/^NSpid/ {print}' /proc/self/status); exec tail -f /dev/null"}) {
    up_ = holder_.LineWith("NSpid") != "";
    const std::string pid = std::to_string(holder_.pid());
    std::ifstream("/proc/" + pid + "/task/" + pid + "/children") >> init_;
  }
  bool up() const { return up_ && init_ != 0; }
  pid_t init() const { return init_; }

  // On a thread of its own, which enters the network namespace.
  void InNetwork(const std::function<void()>& work) const {
    std::async(std::launch::async, [&] {
      const std::string path = "/proc/" + std::to_string(init_) + "/ns/net";
      const UniqueFd network(open(path.c_str(), O_RDONLY | O_CLOEXEC));
      ASSERT_EQ(setns(network.get(), CLONE_NEWNET), 0);
      work();
    }).get();
  }

  // The command line that runs `words` on this host.
  std::vector<std::string> Here(std::vector<std::string> words) const {
    words.insert(words.begin(), {"nsenter", "--target", std::to_string(init_), "--net", "--pid",
                                 "--mount", "--root", "--wd", "--"});
    return words;
  }
  Ended Do(std::vector<std::string> words) const { return RunToEnd(Here(std::move(words))); }
  Ended Run(std::vector<std::string> words) const { return Do(Command(std::move(words))); }
  nlohmann::json Status() const {
    const Ended status = Run({"status", "--json"});
    return status.exit == 0 ? Json(status.out) : nlohmann::json();
  }

 private:
  Process holder_;
  pid_t init_ = 0;
  bool up_ = false;
};

}  // namespace musher::testing
