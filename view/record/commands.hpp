#pragma once
// The commands of musher-record. Each prints what it does to stderr and its result to stdout, and
// returns the exit code: 0 done, 1 not done (a full disk, a lost sample is no failure), 2 usage.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::view {

struct DomainOptions {
  std::string name_space;     // default $MUSHER_NAMESPACE
  std::optional<int> domain;  // none: ROS_DOMAIN_ID, else 0
};

struct RecordOptions {
  DomainOptions where;
  std::string output;  // empty: a name of the time
  std::vector<std::string> topics;
  std::vector<std::string> exclude;
  std::string compression = "lz4";
  std::string duration;  // empty: until Ctrl-C
  std::string max_size;
  std::string ring;  // empty: one file
  std::string keep_on;
  std::size_t keep = 20;
};

struct PlayCommandOptions {
  DomainOptions where;
  std::string file;
  double rate = 1.0;
  bool loop = false;
  std::string start;
  std::vector<std::string> topics;
  std::vector<std::string> exclude;
  bool no_clock = false;
  bool machine = false;
  bool beside_a_robot = false;
  std::vector<std::string> remap;
};

int RunRecord(const RecordOptions& options);
int RunPlay(const PlayCommandOptions& options);
int RunInfo(const std::string& file);
int RunRecover(const std::string& damaged, const std::string& out);

// Prints "musher-record: <message>" to stderr and returns the exit code.
int Fail(const Error& error, int exit = 2);
void Print(const std::string& sentence);
// Whether stderr is one; ShowLine() replaces a line on it, which the next Print() overwrites.
bool OnTerminal();
void ShowLine(const std::string& line);

// The node of this program, without a name in ROS 2's list.
Result<std::unique_ptr<transport::Node>> JoinDomain(transport::EventLoop& loop,
                                                    const DomainOptions& where);

// SIGINT, SIGTERM and SIGHUP as a file descriptor; a file that reaches its limit is no signal. Call
// it before a thread is started.
Result<UniqueFd> EndSignals();

}  // namespace musher::view
