// musher-view: serves the page of a machine, Foxglove's protocol and metrics. See docs/view.md.

#include <pwd.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <optional>
#include <vector>

#include "musher/base/host.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/base/version.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/view/link_request.hpp"
#include "musher/view/live/live_server.hpp"
#include "musher/view/live/qr_code.hpp"
#include "musher/wire/node_services.hpp"

namespace musher::view {
namespace {

constexpr const char* kViewNode = "musher_view";  // in ROS 2

struct ViewOptions {
  std::string name_space;
  std::string machine;  // its name or the beginning of its id; empty: as MachineFeed does
  std::vector<std::string> interfaces;  // to other hosts, of the profile lan
  std::optional<int> domain;            // none: ROS_DOMAIN_ID, else 0
  std::uint16_t port = 8765;
  std::string bind = "127.0.0.1";
  std::vector<std::string> hosts;
  std::string token_file;  // empty: view.token in the folder of Musher's state
  std::string logs;
  std::string docs;  // empty: as FindDocs() finds it
  std::string name;  // of the person for whom the link is; empty: the user of this process
  bool link = false;
  bool logout = false;
  bool no_link = false;
  bool stop_needs_login = false;
};

std::string FromEnvironment(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value == nullptr ? "" : value;
}

int FailView(const std::string& sentence, int exit = 1) {
  std::fprintf(stderr, "musher-view: %s\n", sentence.c_str());
  return exit;
}

std::string UserName() {
  const passwd* user = getpwuid(getuid());  // NOLINT(concurrency-mt-unsafe)
  return user == nullptr ? std::to_string(getuid()) : user->pw_name;
}

// What a browser on this host, or on another one, connects to.
std::string AddressFor(const ViewOptions& options) {
  if (options.bind == "0.0.0.0" || options.bind == "::") {
    const std::string name = HostName();
    return name.empty() ? "localhost" : name;
  }
  return options.bind.find(':') == std::string::npos ? options.bind : "[" + options.bind + "]";
}

// With a QR code where a phone can connect and a person looks at a terminal.
void PrintLink(const ViewOptions& options, std::uint16_t port, const http::LoginLink& link) {
  const std::string pin = link.pin.empty() ? "" : ", or enter the PIN " + link.pin + " on the page";
  std::printf("To act, open http://%s:%u%s%s (once, within 10 minutes).\n",
              AddressFor(options).c_str(), port, link.path.c_str(), pin.c_str());
  const auto code = QrCode(link.outside + link.path);
  if (!link.outside.empty() && code && isatty(STDOUT_FILENO) == 1) {
    std::printf("From a phone:\n%s", QrText(*code).c_str());
  }
  std::fflush(stdout);
}

std::filesystem::path TokenFile(const ViewOptions& options) {
  if (!options.token_file.empty()) return options.token_file;
  return config_toml::DefaultStateDir("view_token", options.name_space);
}

// Beside the token, which permits no less. With a port that differs each time there are none to
// keep.
std::string SessionsFile(const ViewOptions& options) {
  if (options.port == 0) return "";
  return TokenFile(options).string() + ".sessions-" + std::to_string(options.port);
}

Result<std::string> Token(const ViewOptions& options) {
  const std::filesystem::path file = TokenFile(options);
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  return http::ReadOrMakeToken(file.string(), http::KernelRandom);
}

RunningView Running(const ViewOptions& options, const std::string& token) {
  const bool any = options.bind == "0.0.0.0" || options.bind == "::";
  return {any ? "127.0.0.1" : options.bind, options.port, token};
}

int EndLogins(const ViewOptions& options, const std::string& token) {
  const auto ended = RequestLogout(Running(options, token));
  if (!ended && ended.error().code != kCodeNetError) return FailView(ended.error().message);
  // No server runs: those that the next one would know end with their file.
  if (!ended) std::remove(SessionsFile(options).c_str());
  std::printf("All logins of the page are ended.\n");
  return 0;
}

Result<std::unique_ptr<transport::Node>> JoinForView(transport::EventLoop& loop,
                                                     const ViewOptions& options, bool with_keys) {
  transport::DdsOptions dds;
  dds.domain_id = options.domain;
  dds.interfaces = options.interfaces;
  dds.own_networks_only = options.interfaces.size() == 1;  // see DdsOptions
  dds.discovery = transport::DiscoveryTiming::kAtOnce;
  dds.unicast = true;
  dds.node_name = kViewNode;
  dds.name_space = options.name_space;
  if (with_keys) {
    const std::string identity = FromEnvironment("MUSHER_IDENTITY");
    dds.credentials = transport::Credentials{FromEnvironment("MUSHER_KEYS"),
                                             identity.empty() ? "operator" : identity};
  }
  return transport::MakeDdsNode(loop, dds);
}

int Serve(const ViewOptions& options, const std::string& token) {
  sigset_t ends;
  sigemptyset(&ends);
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&ends, one);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);  // before a thread is started
  const UniqueFd signals(signalfd(-1, &ends, SFD_CLOEXEC | SFD_NONBLOCK));
  if (!signals.valid()) return FailView("signals cannot be received");

  transport::LinuxEventLoop loop;
  LiveServer::Options live;
  live.with_keys = !FromEnvironment("MUSHER_KEYS").empty();
  const auto node = JoinForView(loop, options, live.with_keys);
  if (!node) return FailView(node.error().message);
  live.http.bind = options.bind;
  live.http.port = options.port;
  live.http.hosts = options.hosts;
  live.stop_needs_login = options.stop_needs_login;
  live.name_space = options.name_space;
  transport::DdsOptions dds;
  dds.domain_id = options.domain;
  const auto domain = transport::DomainId(dds);
  live.domain_id = domain ? domain.value() : 0;
  live.lan = transport::ReachesOtherHosts();
  live.machine = options.machine;
  live.token = token;
  live.sessions = SessionsFile(options);
  live.logs = options.logs;
  live.docs = [&options] { return options.docs.empty() ? FindDocs() : options.docs; };
  const auto server = LiveServer::Make(*node.value(), live);
  if (!server) {
    // Perhaps `musher up` has started one: then its link is what the person wants.
    const auto link = RequestLink(Running(options, token), options.name);
    if (!link) return FailView(server.error().message + "; --port takes another one");
    std::printf("The page is at http://%s:%u/ already.\n", AddressFor(options).c_str(),
                options.port);
    PrintLink(options, options.port, link.value());
    return 0;
  }
  std::optional<transport::NodeServices> services;
  if (!live.with_keys) {  // with keys there is no tool of ROS 2 in the domain
    services.emplace(*node.value(), transport::ResolveName(options.name_space, kViewNode),
                     std::vector<transport::NodeParameter>());
  }
  const std::uint16_t port = server.value()->port();
  std::printf("The page is at http://%s:%u/\n", AddressFor(options).c_str(), port);
  std::fflush(stdout);
  if (!options.no_link) PrintLink(options, port, server.value()->NewLink(options.name));
  const auto end = loop.WhenReadable(signals.get(), [&loop] { loop.Stop(); });
  loop.Run();
  return 0;
}

int RunView(ViewOptions options) {
  if (options.name_space.starts_with('/')) options.name_space.erase(0, 1);
  if (options.name.empty()) options.name = UserName();
  const auto token = Token(options);
  if (!token) return FailView(token.error().message, 2);
  if (options.logout) return EndLogins(options, token.value());
  if (!options.link) return Serve(options, token.value());
  const auto link = RequestLink(Running(options, token.value()), options.name);
  if (!link) return FailView(link.error().message);
  PrintLink(options, options.port, link.value());
  return 0;
}

int Main(int argc, char** argv) {
  CLI::App app("Shows a machine in a browser, and gives its metrics to Prometheus.", "musher-view");
  app.set_version_flag("--version", "musher-view " + std::string(Version()));
  app.get_formatter()->column_width(28);
  app.footer("Exit codes: 0 done; 1 not done (reason on stderr); 2 usage.");
  ViewOptions options;
  options.name_space = FromEnvironment("MUSHER_NAMESPACE");
  app.add_option("--namespace", options.name_space,
                 "Namespace of the machine; default $MUSHER_NAMESPACE, else none");
  options.machine = FromEnvironment("MUSHER_MACHINE");
  app.add_option("--machine", options.machine,
                 "Name of the machine, or the beginning of its id;\n"
                 "default $MUSHER_MACHINE, else the one of this host, else the first that answers");
  app.add_option("--domain", options.domain, "DDS domain; default $ROS_DOMAIN_ID, else 0")
      ->check(CLI::Range(0, 232).description(""));
  app.add_option("--interface", options.interfaces,
                 "Network interface to other hosts, with MUSHER_TRANSPORT=lan; may be repeated.\n"
                 "Default: as DDS chooses");
  app.add_option("--port", options.port, "Default 8765; 0: any that is free")
      ->check(CLI::Range(0, 65535).description(""));
  app.add_option("--bind", options.bind,
                 "Address to listen on; default 127.0.0.1, this host only. 0.0.0.0: all");
  app.add_option("--host", options.hosts,
                 "Another name of this host, or an origin (https://app.foxglove.dev), from which\n"
                 "browsers may connect; may be repeated");
  app.add_option("--token-file", options.token_file,
                 "What permits to make links; made if it is missing.\n"
                 "Default: ~/.local/state/musher/view_token");
  app.add_option("--logs", options.logs,
                 "Folder of the actuators' logs; default: as the machine's config says");
  app.add_option("--docs", options.docs,
                 "Folder of the documentation, served under /docs; default: the installed one")
      ->check(CLI::ExistingDirectory.description(""));
  app.add_flag("--link", options.link,
               "Print a link and a PIN for acting, of the musher-view that runs, and exit");
  app.add_flag("--logout", options.logout, "End all logins of the page, and exit");
  app.add_flag("--no-link", options.no_link, "Print no link at the start, for logs");
  app.add_flag("--stop-needs-login", options.stop_needs_login,
               "The emergency stop of the page needs a login, too");
  app.add_option("--name", options.name,
                 "Person for whom the link is, as the history names them; default: this user");
  try {
    app.parse(argc, argv);
    return RunView(options);
  } catch (const CLI::ParseError& e) {
    return EndOfParse(app, e, 2);
  } catch (const std::exception& e) {  // a system resource is exhausted
    return FailView(e.what());
  }
}

}  // namespace
}  // namespace musher::view

int main(int argc, char** argv) {
  return musher::view::Main(argc, argv);
}
