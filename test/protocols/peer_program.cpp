// A process without Musher's protocol, for tests on real DDS: runs until SIGTERM.
//
//   protocol_peer ros2 <namespace> <name> <lease_ms> [option …]       a ROS 2 managed node; with
//                                    names as "planner,smoother" a container of several
//   protocol_peer cyberdog <namespace> <name> <lease_ms> [option …]   a module with heartbeats
//
//   faulty                  its first replies are lost, as to a client that has not been matched
//   takes=NAME:MS           the duration of the callback of a transition or state
//   fails_while=NAME:FILE   the callback fails while the file exists
//   events=FILE             events are appended to it: "start PID", "activate", "SIGTERM"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <list>
#include <map>
#include <optional>
#include <sstream>
#include <string>

#include "musher/test/protocols/cyberdog_module.hpp"
#include "musher/test/protocols/ros_managed_node.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

using namespace musher;  // NOLINT(google-build-using-namespace): a main program

namespace {

std::array<int, 2> g_terminated{};  // a pipe: the handler writes, the loop reads

void OnTerminate(int) {
  [[maybe_unused]] const ssize_t written = write(g_terminated[1], "T", 1);
}

class Peer {
 public:
  Peer(transport::Node& node, const std::string& kind, const std::string& name_space,
       const std::string& name) {
    if (kind == "ros2") {
      std::istringstream names(name);
      for (std::string one; std::getline(names, one, ',');) {
        ros_.emplace_back(node, transport::ResolveName(name_space, one));
        ros_.back().on_callback = [this](const std::string& callback) { OnCallback(callback); };
      }
    } else {
      module_.emplace(node, name_space, name, name);
      module_->on_callback = [this](const std::string& callback) { OnCallback(callback); };
    }
  }

  void Apply(const std::string& option) {
    const std::size_t equals = option.find('=');
    const std::string value = option.substr(equals == std::string::npos ? 0 : equals + 1);
    for (auto& ros : ros_) {
      if (option == "faulty") ros.lost_change_replies = ros.lost_get_replies = 1;
    }
    if (option.starts_with("events=")) events_ = value;
    const std::size_t colon = value.find(':');
    const std::string callback = value.substr(0, colon);
    const std::string more = colon == std::string::npos ? "" : value.substr(colon + 1);
    if (option.starts_with("fails_while=")) fails_while_[callback] = more;
    if (option.starts_with("takes=")) Take(callback, Milliseconds(std::atoi(more.c_str())));
  }

  void Log(const std::string& event) const {
    if (!events_.empty()) std::ofstream(events_, std::ios::app) << event << std::endl;
  }

 private:
  void OnCallback(const std::string& callback) {
    Log(callback);
    const auto cause = fails_while_.find(callback);
    if (cause == fails_while_.end()) return;
    const bool fails = access(cause->second.c_str(), F_OK) == 0;
    using Outcome = testing::RosManagedNode::Outcome;
    for (auto& ros : ros_) {
      ros.script[callback].outcome = fails ? Outcome::kFailure : Outcome::kSuccess;
    }
    if (module_) module_->script[callback].code = fails ? 1 : 0;
  }
  void Take(const std::string& callback, Duration takes) {
    for (auto& ros : ros_) ros.script[callback].takes = takes;
    if (module_) module_->script[callback].takes = takes;
  }

  std::string events_;
  std::map<std::string, std::string> fails_while_;  // by callback: a file
  std::list<testing::RosManagedNode> ros_;
  std::optional<testing::CyberdogModule> module_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5 || pipe(g_terminated.data()) != 0) return EXIT_FAILURE;
  signal(SIGTERM, OnTerminate);
  transport::LinuxEventLoop loop;
  transport::DdsOptions options;
  options.lease = Milliseconds(std::atoi(argv[4]));
  const auto node = transport::MakeDdsNode(loop, options);
  if (!node) {
    std::fprintf(stderr, "%s\n", node.error().message.c_str());
    return EXIT_FAILURE;
  }
  Peer peer(*node.value(), argv[1], argv[2], argv[3]);
  for (int i = 5; i < argc; ++i) peer.Apply(argv[i]);
  peer.Log("start " + std::to_string(getpid()));
  const auto terminated = loop.WhenReadable(g_terminated[0], [&] {
    peer.Log("SIGTERM");
    loop.Stop();
  });
  loop.Run();
  return EXIT_SUCCESS;
}
