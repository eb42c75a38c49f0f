// How fast the server of the page answers, and what it costs to keep pages up to date: a file of
// 4 KB to 1 and to 50 clients that keep their connections, and 50 WebSockets with 10 messages a
// second. The server is a process of its own; all clients are one thread.
//
//   benchmark_page_server [SECONDS]

#include <sys/wait.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <list>
#include <set>

#include "musher/base/check.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/view/http/websocket_client.hpp"

namespace musher::benchmark {
namespace {

constexpr std::size_t kFileSize = 4096;
constexpr std::size_t kMessageSize = 500;
constexpr Duration kMessagePeriod = Milliseconds(100);
constexpr std::size_t kClients = 50;

// In the child process; never returns.
[[noreturn]] void RunServer(int port_pipe) {
  transport::LinuxEventLoop loop;
  http::Options options;
  options.port = 0;
  std::set<std::shared_ptr<http::WebSocket>> open;
  const auto file = http::Shared(std::string(kFileSize, 'x'));
  const auto message = http::Shared(std::string(kMessageSize, 'x'));
  auto server = http::Server::Make(
      loop, options,
      [&](const http::Request&, const http::Respond& respond) {
        http::Response response;
        response.content_type = "text/plain";
        response.body = file;
        respond(response);
      },
      [&](const std::shared_ptr<http::WebSocket>& socket) {
        open.insert(socket);
        http::WebSocketHandlers handlers;
        handlers.on_closed = [&, socket] { open.erase(socket); };
        return handlers;
      });
  MUSHER_CHECK(server.ok(), "the server must start");
  const std::uint16_t port = server.value()->port();
  MUSHER_CHECK(write(port_pipe, &port, sizeof port) == sizeof port);
  const auto timer = loop.Every(kMessagePeriod, [&] {
    for (const auto& socket : open) socket->Send(message, false);
  });
  loop.Run();
  std::abort();
}

class ServerProcess {
 public:
  ServerProcess() {
    std::array<int, 2> ends{};
    MUSHER_CHECK(pipe(ends.data()) == 0);
    pid_ = fork();
    MUSHER_CHECK(pid_ >= 0);
    if (pid_ == 0) RunServer(ends[1]);
    MUSHER_CHECK(read(ends[0], &port_, sizeof port_) == sizeof port_);
    close(ends[0]);
    close(ends[1]);
  }
  ~ServerProcess() {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  pid_t pid() const { return pid_; }
  std::uint16_t port() const { return port_; }

 private:
  pid_t pid_ = 0;
  std::uint16_t port_ = 0;
};

struct Requester {
  explicit Requester(std::uint16_t port) : client(port) { Ask(); }
  void Ask() {
    begin = std::chrono::steady_clock::now();
    client.Send("GET /file HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }

  http::Client client;
  Time begin;
};

// Waits for input of any of the clients; `on_input` takes the index of a client that has some.
template <typename Function>
void Serve(std::vector<pollfd>& polls, const Function& on_input) {
  MUSHER_CHECK(poll(polls.data(), polls.size(), 1000) >= 0);
  for (std::size_t i = 0; i < polls.size(); ++i) {
    if (polls[i].revents != 0) on_input(i);
  }
}

void MeasureRequests(const Table& table, const ServerProcess& server, std::size_t clients,
                     double seconds) {
  std::vector<std::unique_ptr<Requester>> requesters;
  std::vector<pollfd> polls;
  for (std::size_t i = 0; i < clients; ++i) {
    requesters.push_back(std::make_unique<Requester>(server.port()));
    polls.push_back({requesters.back()->client.fd(), POLLIN, 0});
  }
  std::vector<double> latencies;
  const Duration cpu = CostOf(server.pid()).cpu;
  const Time begin = std::chrono::steady_clock::now();
  Time now = begin;
  while (ToSeconds(now - begin) < seconds) {
    Serve(polls, [&](std::size_t i) {
      const auto reply = requesters[i]->client.TakeReply();
      MUSHER_CHECK(reply.status == 200 && reply.body.size() == kFileSize);
      now = std::chrono::steady_clock::now();
      latencies.push_back(Microseconds(now - requesters[i]->begin));
      requesters[i]->Ask();
    });
  }
  const double elapsed = ToSeconds(now - begin);
  const double used = ToSeconds(CostOf(server.pid()).cpu - cpu);
  const std::string what = std::to_string(clients) + (clients == 1 ? " client" : " clients");
  table.Row(what + ", requests a second", {static_cast<double>(latencies.size()) / elapsed}, "");
  table.Row(what + ", latency", latencies, "µs");
  table.Row(what + ", CPU of the server for a request",
            {used * 1e6 / static_cast<double>(latencies.size())}, "µs");
}

void MeasureWebSockets(const Table& table, const ServerProcess& server, double seconds) {
  std::list<http::WebSocketClient> clients;
  std::vector<pollfd> polls;
  for (std::size_t i = 0; i < kClients; ++i) {
    MUSHER_CHECK(clients.emplace_back(server.port()).open());
    polls.push_back({clients.back().fd(), POLLIN, 0});
  }
  const Duration cpu = CostOf(server.pid()).cpu;
  const Time begin = std::chrono::steady_clock::now();
  std::size_t bytes = 0;
  std::vector<char> chunk(65536);
  while (ToSeconds(std::chrono::steady_clock::now() - begin) < seconds) {
    Serve(polls, [&](std::size_t i) {
      const ssize_t size = recv(polls[i].fd, chunk.data(), chunk.size(), 0);
      MUSHER_CHECK(size > 0);
      bytes += static_cast<std::size_t>(size);
    });
  }
  const double elapsed = ToSeconds(std::chrono::steady_clock::now() - begin);
  const Cost cost = CostOf(server.pid());
  table.Row("50 WebSockets, CPU of the server", {ToSeconds(cost.cpu - cpu) / elapsed * 100}, "%");
  table.Row("50 WebSockets, messages a second",
            {static_cast<double>(bytes) / (kMessageSize + 4) / elapsed}, "");
  table.Row("the server, RSS", {cost.resident_mb}, "MB");
}

void Main(double seconds) {
  const ServerProcess server;
  const Table table("the server of the page");
  MeasureRequests(table, server, 1, seconds);
  MeasureRequests(table, server, kClients, seconds);
  MeasureWebSockets(table, server, seconds);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 5;
  if (!(seconds > 0)) {
    std::fprintf(stderr, "benchmark_page_server: '%s' is not a number of seconds\n", argv[1]);
    return 2;
  }
  musher::benchmark::Main(seconds);
}
