#pragma once
// What a command reads from the other hosts of a machine, by ssh: one shell script on each of them,
// all at the same time, and no longer than a limit.
//
// Threads: any; blocks.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/program.hpp"
#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher::cli {

// ssh with a script of sh for a host. What its login prints before the script is left out.
class HostScript {
 public:
  static Result<HostScript> Start(const HostConfig& host, const std::string& script);

  HostScript(HostScript&& other) noexcept;
  HostScript& operator=(HostScript&&) = delete;
  ~HostScript();  // ends it

  int output() const { return output_.get(); }  // readable when Read() has something
  // Reads what is there, without waiting; false: it has ended, or prints a line without end.
  bool Read();
  // Its output since the last call, in whole lines.
  std::vector<std::string> TakeLines();
  // The host's clock minus ours, once it has begun; accurate to the delay of the link.
  std::optional<std::int64_t> clock_offset_ns() const { return offset_ns_; }
  // "host vision (root@10.0.0.2): …": why it has not run to its end; after Read() returned false.
  std::string Trouble();
  // It has printed something.
  bool begun() const { return begun_; }
  // The sentence for a script that has not ended in time.
  std::string Late(Duration within) const;

 private:
  HostScript(HostConfig host, ForkedProgram ssh) : host_(std::move(host)), ssh_(std::move(ssh)) {}

  HostConfig host_;
  ForkedProgram ssh_;
  bool ended_ = false;
  UniqueFd output_;
  UniqueFd errors_;
  bool begun_ = false;
  std::string text_;  // that is not a whole line yet
  std::vector<std::string> lines_;
  std::string said_;  // by ssh
  std::optional<std::int64_t> offset_ns_;
};

struct HostAnswer {
  std::vector<std::string> lines;  // also those that had arrived before a trouble
  std::optional<std::int64_t> clock_offset_ns = {};
  std::string trouble = {};  // "host vision (root@10.0.0.2): …; …"; empty: it has answered
  bool cut = false;          // the trouble is that its script has not ended in time
};

struct HostQuery {
  const HostConfig* host = nullptr;
  std::string script;
};

// In the order of the queries. `interrupt`: once this descriptor is readable, what has not ended is
// given up; -1: none.
std::vector<HostAnswer> QueryHosts(const std::vector<HostQuery>& queries, Duration within,
                                   int interrupt = -1);

}  // namespace musher::cli
