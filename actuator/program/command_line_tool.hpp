#pragma once
// What the command-line tools musher-motion, musher-audio and musher-camera share: the options
// that select a machine, and the connection to it.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/result.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/node.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace musher::program {

enum class ExitCode : int {
  kDone = 0,
  kNotDone = 1,  // refused, failed, or no reply
  kUsage = 2,
  kInterrupted = 130  // by Ctrl-C, as shells have it
};

// A command line without a command to run: help, or a usage error.
struct ParseEnd {
  ExitCode exit = ExitCode::kUsage;
  std::string text;
};

// --json, --namespace, --domain, --transport, --clock, --keys, --identity.
struct ToolOptions {
  bool json = false;
  std::string name_space;
  std::optional<int> domain;
  std::optional<std::string> transport;
  bool clock_topic = false;  // time is taken from /clock
  std::string keys;
  std::string identity;
};

// Adds these options to the app and makes it require a command. `options` must outlive the
// parsing. `clock_use` is the help text of --clock.
void SetUpCommandLineTool(CLI::App& app, ToolOptions& options, const std::string& clock_use,
                          const std::string& footer);
// Parses the command line and takes missing options from MUSHER_NAMESPACE, MUSHER_KEYS and
// MUSHER_IDENTITY. Returns nothing when a command is to be run.
std::optional<ParseEnd> Parse(CLI::App& app, int argc, const char* const* argv,
                              ToolOptions& options);
// A validator for an option: a number in the range. Rejects "nan", which CLI::Range accepts.
std::function<std::string(const std::string&)> Between(double least, double most);

// Prints the text on stdout or stderr; returns the exit code.
int Print(const ParseEnd& end, const std::string& program);

// The connection from a command to a module: joins the domain, publishes and subscribes.
//
// Threads: one; RunUntil() runs the loop. Ctrl-C ends a wait, not the program.
class ToolLink {
 public:
  static Result<std::unique_ptr<ToolLink>> Open(const ToolOptions& options);

  // How long discovery of a module may take; it takes longer with credentials.
  Duration discovery() const { return Milliseconds(options_.keys.empty() ? 1200 : 4000); }

  // Runs the loop until `done` holds, at most `timeout` of steady time, or until Ctrl-C. Returns
  // whether `done` held.
  bool RunUntil(const std::function<bool()>& done, Duration timeout);
  // The same, until a module would have been discovered. Where processes of the namespace run, that
  // may take several times as long: a slow computer or link is not taken for a missing module.
  bool Find(const std::function<bool()>& found);
  bool interrupted() const { return interrupted_; }
  // Returns whether Ctrl-C was pressed, and clears it, so that the next wait blocks again.
  bool TakeInterrupt() { return std::exchange(interrupted_, false); }

  transport::Node& node() { return *node_; }
  transport::Clock& clock() { return *clock_; }
  // False when time is to come from /clock and nothing publishes it.
  bool AwaitClock();
  std::string Name(const std::string& name) const {
    return transport::ResolveName(options_.name_space, name);
  }
  // The error for a module that was not found: "no motion manager in namespace …".
  Error NotFound(const std::string& what) const;

 private:
  explicit ToolLink(ToolOptions options);
  Result<> Join();
  bool NamespaceHasProcesses() const;

  const ToolOptions options_;
  UniqueFd signals_;  // before the node: its threads inherit the mask
  transport::LinuxEventLoop loop_;
  bool interrupted_ = false;
  transport::LoopHandlePtr signal_watch_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Clock> clock_;
};

}  // namespace musher::program
