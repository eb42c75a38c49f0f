#include "musher/actuator/program/command_line_tool.hpp"

#include <sys/signalfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "musher/base/usage_error.hpp"
#include "musher/base/version.hpp"
#include "musher/base/words.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::program {
namespace {

UniqueFd TakeEndSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return UniqueFd(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
}

void TakeVariable(std::string& value, const char* variable, const char* otherwise) {
  const char* set = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
  if (value.empty()) value = set != nullptr ? set : otherwise;
}

void TakeEnvironment(ToolOptions& options) {
  TakeVariable(options.name_space, "MUSHER_NAMESPACE", "");
  TakeVariable(options.keys, "MUSHER_KEYS", "");
  TakeVariable(options.identity, "MUSHER_IDENTITY", "operator");
  if (!options.name_space.empty() && options.name_space.front() == '/') {
    options.name_space.erase(0, 1);
  }
}

}  // namespace

void SetUpCommandLineTool(CLI::App& app, ToolOptions& options, const std::string& clock_use,
                          const std::string& footer) {
  constexpr int kMostDomain = 232;
  constexpr std::size_t kHelpColumn = 32;
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(footer);
  app.set_version_flag("--version", app.get_name() + " " + std::string(Version()),
                       "Print the version");
  app.get_formatter()->column_width(kHelpColumn);
  app.get_formatter()->label("SUBCOMMAND", "COMMAND");
  app.get_formatter()->label("REQUIRED", "");
  app.add_flag("--json", options.json, "Print a JSON document");
  app.add_option("--namespace", options.name_space,
                 "Namespace of the machine; default $MUSHER_NAMESPACE, else none")
      ->type_name("NAME");
  app.add_option("--domain", options.domain, "DDS domain; default $ROS_DOMAIN_ID, else 0")
      ->check(CLI::Range(0, kMostDomain).description(""))
      ->type_name("N");
  app.add_option("--transport", options.transport,
                 "local: this host; lan: others too; default $MUSHER_TRANSPORT, else local")
      ->check(CLI::IsMember({"local", "lan"}).description(""))
      ->type_name("local|lan");
  app.add_option_function<std::string>(
         "--clock", [&options](const std::string& name) { options.clock_topic = name == "topic"; },
         clock_use)
      ->check(CLI::IsMember({"steady", "topic"}).description(""))
      ->type_name("steady|topic");
  app.add_option("--keys", options.keys, "Folder with credentials; default $MUSHER_KEYS, else none")
      ->type_name("FOLDER");
  app.add_option("--identity", options.identity,
                 "Name of the credentials; default $MUSHER_IDENTITY, else operator")
      ->type_name("NAME");
}

std::optional<ParseEnd> Parse(CLI::App& app, int argc, const char* const* argv,
                              ToolOptions& options) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::ostringstream out;
    std::ostringstream ignored;
    if (app.exit(e, out, ignored) == 0) {
      std::string text = out.str();
      while (text.ends_with('\n')) text.pop_back();  // Print() ends the line
      return ParseEnd{ExitCode::kDone, text};
    }
    return ParseEnd{ExitCode::kUsage, UsageError(app, e)};
  }
  TakeEnvironment(options);
  return std::nullopt;
}

std::function<std::string(const std::string&)> Between(double least, double most) {
  return [least, most](const std::string& text) {
    double value = 0;
    const bool good = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
    std::ostringstream error;
    error << text << " is not between " << least << " and " << most;
    return good ? std::string() : error.str();
  };
}

int Print(const ParseEnd& end, const std::string& program) {
  const bool good = end.exit == ExitCode::kDone;
  (good ? std::cout : std::cerr) << (good ? "" : program + ": ") << end.text << std::endl;
  return static_cast<int>(end.exit);
}

ToolLink::ToolLink(ToolOptions options) : options_(std::move(options)), signals_(TakeEndSignals()) {
  signal_watch_ = loop_.WhenReadable(signals_.get(), [this] {
    signalfd_siginfo signal{};
    if (read(signals_.get(), &signal, sizeof(signal)) == sizeof(signal)) interrupted_ = true;
  });
}

Result<std::unique_ptr<ToolLink>> ToolLink::Open(const ToolOptions& options) {
  std::unique_ptr<ToolLink> link(new ToolLink(options));
  if (auto joined = link->Join(); !joined) return joined.error();
  return link;
}

Result<> ToolLink::Join() {
  // The transport reads it.
  if (options_.transport) setenv("MUSHER_TRANSPORT", options_.transport->c_str(), 1);
  transport::DdsOptions dds;
  dds.domain_id = options_.domain;
  dds.discovery = transport::DiscoveryTiming::kAtOnce;
  dds.unicast = true;  // it may read pictures
  dds.hidden = true;
  if (!options_.keys.empty()) {
    dds.credentials =
        transport::Credentials{std::filesystem::absolute(options_.keys), options_.identity};
  }
  auto node = transport::MakeDdsNode(loop_, dds);
  if (!node) return node.error();
  node_ = std::move(node).value();
  if (!options_.clock_topic) {
    clock_ = transport::Clock::Steady(loop_);
    return Ok();
  }
  auto clock = transport::Clock::FromTopic(*node_);
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  return Ok();
}

bool ToolLink::RunUntil(const std::function<bool()>& done, Duration timeout) {
  loop_.RunUntil([&] { return done() || interrupted_; }, loop_.Now() + timeout);
  return done();
}

bool ToolLink::Find(const std::function<bool()>& found) {
  if (RunUntil(found, discovery())) return true;
  return NamespaceHasProcesses() && !interrupted_ && RunUntil(found, 3 * discovery());
}

bool ToolLink::NamespaceHasProcesses() const {
  const std::string prefix = "/" + Name("");
  return std::ranges::any_of(node_->Peers(), [&prefix](const transport::PeerInfo& peer) {
    return peer.name.starts_with(prefix);
  });
}

bool ToolLink::AwaitClock() {
  return !options_.clock_topic || Find([this] { return clock_->Now() != Time{}; });
}

Error ToolLink::NotFound(const std::string& what) const {
  return {kCodeNetError, "no " + what + " in " + NamespaceText(options_.name_space) +
                             "; use --namespace and --domain, or --transport lan for other hosts"};
}

}  // namespace musher::program
