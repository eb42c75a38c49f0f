// The real server with the page's files and without a robot, for real_test.js: each line of stdin
// is sent to every page, also to those that come later. Prints its port, then a line for each POST.
// Ends with stdin.

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/transport/linux_event_loop.hpp"
#include "musher/view/page/files.hpp"

namespace musher::view {
namespace {

struct Relay {
  std::vector<std::shared_ptr<const std::string>> lines;
  std::vector<std::shared_ptr<http::WebSocket>> pages;
  std::string partial;

  void Read(transport::EventLoop& loop) {
    char buffer[4096];
    const ssize_t count = read(STDIN_FILENO, buffer, sizeof buffer);
    if (count <= 0) return loop.Stop();
    partial.append(buffer, static_cast<std::size_t>(count));
    for (std::size_t end = partial.find('\n'); end != std::string::npos; end = partial.find('\n')) {
      lines.push_back(std::make_shared<const std::string>(partial.substr(0, end)));
      partial.erase(0, end + 1);
      for (const auto& page : pages) page->Send(lines.back(), false);
    }
  }
};

void Answer(const http::Request& request, const http::Respond& respond) {
  if (request.method == "POST") {
    std::printf("%s %s\n", request.path.c_str(), request.body.c_str());
    std::fflush(stdout);
    http::Response response;
    response.body = std::make_shared<const std::string>("{}");
    return respond(std::move(response));
  }
  auto response = http::AssetResponse(PageFiles(), request);
  respond(response ? *response : http::ErrorResponse(404, 0, "not found: " + request.path));
}

int Main() {
  transport::LinuxEventLoop loop;
  Relay relay;
  http::Options options;
  options.port = 0;
  options.subprotocols = {"musher.view.v1"};
  const auto open = [&relay](const std::shared_ptr<http::WebSocket>& page) {
    relay.pages.push_back(page);
    for (const auto& line : relay.lines) page->Send(line, false);
    return http::WebSocketHandlers{};
  };
  auto server = http::Server::Make(loop, options, Answer, open);
  if (!server) {
    std::fprintf(stderr, "%s\n", server.error().message.c_str());
    return 1;
  }
  std::printf("%u\n", server.value()->port());
  std::fflush(stdout);
  const auto watch = loop.WhenReadable(STDIN_FILENO, [&] { relay.Read(loop); });
  loop.Run();
  return 0;
}

}  // namespace
}  // namespace musher::view

int main() {
  return musher::view::Main();
}
