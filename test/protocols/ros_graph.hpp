#pragma once
// What a ROS 2 process sees of us: runs ros_graph_peer and reads what it prints.

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::testing {

// One of what the peer prints; see ros_graph_peer.c.
struct RosGraph {
  int samples = 0;
  std::map<std::string, std::set<std::string>> nodes;  // "service /dog1/reset" and so on
  std::map<std::string, std::string> hashes;           // of types, "std_msgs/msg/String"
  std::vector<std::string> unknown;
  std::vector<std::string> log;
  int endpoints = 0;
  int bytes = 0;

  bool Has(const std::string& node) const { return nodes.contains(node); }
  bool Has(const std::string& node, const std::string& endpoint) const {
    return Has(node) && nodes.at(node).contains(endpoint);
  }
};

// In the domain of ROS_DOMAIN_ID.
class RosGraphPeer {
 public:
  explicit RosGraphPeer(const std::string& settings = transport::kRosOnLoopback) {
    std::array<int, 2> in{}, out{};
    if (pipe2(in.data(), O_CLOEXEC) != 0 || pipe2(out.data(), O_CLOEXEC) != 0) std::abort();
    input_ = UniqueFd(in[1]);
    output_ = UniqueFd(out[0]);
    const UniqueFd child_in(in[0]), child_out(out[1]);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, in[0], 0);
    posix_spawn_file_actions_adddup2(&actions, out[1], 1);
    std::vector<std::string> texts;
    for (char** each = environ; *each != nullptr; ++each) {
      if (!std::string_view(*each).starts_with("CYCLONEDDS_URI=")) texts.emplace_back(*each);
    }
    texts.push_back("CYCLONEDDS_URI=" + settings);
    std::vector<char*> environment;
    for (std::string& text : texts) environment.push_back(text.data());
    environment.push_back(nullptr);
    std::string program = BinDir() + "/ros_graph_peer";
    std::array<char*, 2> arguments = {program.data(), nullptr};
    if (posix_spawn(&pid_, program.c_str(), &actions, nullptr, arguments.data(),
                    environment.data()) != 0) {
      std::abort();
    }
    posix_spawn_file_actions_destroy(&actions);
    watch_ = loop_.WhenReadable(output_.get(), [this] { Read(); });
  }
  RosGraphPeer(const RosGraphPeer&) = delete;
  RosGraphPeer& operator=(const RosGraphPeer&) = delete;
  ~RosGraphPeer() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

  // Waits until `done` accepts what the peer sees; false if it never does.
  template <class Done>
  bool Sees(const Done& done) {
    return loop_.RunUntil([&] { return done(graph_); }, loop_.Now() + std::chrono::seconds(120));
  }
  const RosGraph& graph() const { return graph_; }
  const std::string& text() const { return last_; }

 private:
  void Read() {
    std::array<char, 65536> buffer;
    const ssize_t count = read(output_.get(), buffer.data(), buffer.size());
    if (count <= 0) {
      watch_ = nullptr;
      return;
    }
    text_.append(buffer.data(), static_cast<std::size_t>(count));
    const std::string end = "\nend\n";
    const std::size_t last = text_.rfind(end);
    if (last == std::string::npos) return;
    const std::size_t before = last == 0 ? std::string::npos : text_.rfind(end, last - 1);
    const std::size_t begin = before == std::string::npos ? 0 : before + end.size();
    last_ = text_.substr(begin, last + 1 - begin);
    text_.erase(0, last + end.size());
    graph_ = Parse(last_);
  }

  static RosGraph Parse(const std::string& text) {
    RosGraph graph;
    std::istringstream lines(text);
    std::string node;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string kind, name, type, hash;
      words >> kind >> name >> type >> hash;
      if (kind == "samples") {
        graph.samples = std::stoi(name);
      } else if (kind == "node") {
        node = name;
        graph.nodes[node];
      } else if (kind == "unknown") {
        graph.unknown.push_back(name);
      } else if (kind == "bytes") {
        graph.endpoints = std::stoi(name);
        graph.bytes = std::stoi(type);
      } else if (kind == "log") {
        graph.log.push_back(line);
      } else {
        graph.nodes[node].insert(kind + " " + name);
        graph.hashes[type] = hash;
      }
    }
    return graph;
  }

  transport::LinuxEventLoop loop_;
  UniqueFd input_, output_;
  pid_t pid_ = 0;
  std::string text_;  // not complete yet
  std::string last_;
  RosGraph graph_;
  transport::LoopHandlePtr watch_;
};

}  // namespace musher::testing
