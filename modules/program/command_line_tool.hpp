#pragma once
// What the tools have in common with which a person works a module by hand: musher-motion,
// musher-audio, musher-camera. How to reach the machine, and the way there.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/lifecycle/result.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/host.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/unique_fd.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace musher::program {

enum class ExitCode : int {
  kDone = 0,
  kNotDone = 1,  // refused, failed, or nobody answered
  kUsage = 2,
  kInterrupted = 130  // by Ctrl-C, as shells have it
};

// A command line that asks for no command: help, or a mistake.
struct ParseEnd {
  ExitCode exit = ExitCode::kUsage;
  std::string text;
};

// --json, --namespace, --domain, --transport, --clock, --keys, --identity.
struct HandOptions {
  bool json = false;
  std::string name_space;
  std::optional<int> domain;
  std::optional<std::string> transport;
  bool clock_topic = false;  // time goes by /clock
  std::string keys;
  std::string identity;
};

// Makes the app a tool of commands with these options. `options` must outlive its parsing.
// `clock_use` is for --help: what goes by that clock.
void SetUpCommandLineTool(CLI::App& app, HandOptions& options, const std::string& clock_use,
                          const std::string& footer);
// Reads the command line, and what it does not give from MUSHER_NAMESPACE, MUSHER_KEYS and
// MUSHER_IDENTITY. Nothing: a command was chosen.
std::optional<ParseEnd> Parse(CLI::App& app, int argc, const char* const* argv,
                              HandOptions& options);
// A check of an option: a number, and not "nan", which is in every CLI::Range.
std::function<std::string(const std::string&)> Between(double least, double most);

// Prints the end on stdout or stderr; the exit code.
int Say(const ParseEnd& end, const std::string& program);

// The way from a command to a module: joins the domain, sends and hears.
//
// Threads: one; RunUntil() runs the loop. Ctrl-C ends a wait, not the program.
class HandLink {
 public:
  static Result<std::unique_ptr<HandLink>> Open(const HandOptions& options);

  // How long a module may take to be found: those with keys introduce themselves longer.
  Duration discovery() const { return Milliseconds(options_.keys.empty() ? 1200 : 4000); }

  // Runs the loop until `done` holds, at most `timeout` of steady time, or until Ctrl-C; says
  // whether it held.
  bool RunUntil(const std::function<bool()>& done, Duration timeout);
  bool interrupted() const { return interrupted_; }
  // Whether there was a Ctrl-C; waits again from now on.
  bool TakeInterrupt() { return std::exchange(interrupted_, false); }

  transport::Node& node() { return *node_; }
  transport::Clock& clock() { return *clock_; }
  // False when /clock is to be followed and nobody publishes it.
  bool AwaitClock();
  std::string Name(const std::string& name) const {
    return transport::ResolveName(options_.name_space, name);
  }
  // That it was not found: "no motion manager in namespace …".
  Error Nobody(const std::string& who) const;

 private:
  explicit HandLink(HandOptions options);
  Result<> Join();

  const HandOptions options_;
  transport::UniqueFd signals_;  // before the node: its threads inherit the mask
  transport::LinuxEventLoop loop_;
  bool interrupted_ = false;
  transport::LoopHandlePtr signal_watch_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<transport::Clock> clock_;
};

}  // namespace musher::program
