// How many pictures a client of Foxglove's protocol gets: cameras publish numbered pictures, the
// client counts what is missing. All are processes of their own but the client.
//
//   benchmark_foxglove [SECONDS]

#include <cstdlib>

#include "musher/base/check.hpp"
#include "musher/test/benchmark/camera/picture.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/port.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/view/http/websocket_client.hpp"

namespace musher::benchmark {
namespace {

constexpr std::size_t kHead = 13;  // of a message with data, before the sample

// Waits for the channel of the topic and subscribes to it.
void SubscribeTo(http::WebSocketClient& client, const std::string& topic) {
  const std::string name = R"("topic":")" + topic + '"';
  for (;;) {
    const http::Frame frame = client.TakeFrame();
    if (!frame.ok) Fail("musher-view ends the connection");
    const std::size_t at = frame.payload.find(name);
    if (at == std::string::npos) continue;
    const std::size_t id = frame.payload.rfind(R"("id":)", at) + 5;
    const std::string channel =
        frame.payload.substr(id, frame.payload.find_first_not_of("0123456789", id) - id);
    client.SendFrame(
        http::Opcode::kText,
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":)" + channel + "}]}");
    return;
  }
}

void Measure(const Table& table, int width, int height, int hz, double seconds) {
  const Child camera({Program("benchmark_picture_source"), std::to_string(width),
                      std::to_string(height), std::to_string(hz), "camera"});
  const std::uint16_t port = FreePort();
  const Child view({Program("musher-view"), "--port", std::to_string(port)}, {},
                   Child::Output::kPiped);
  view.AwaitOutput();
  http::WebSocketClient client(port, "/", "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n");
  if (!client.open()) Fail("musher-view refuses the client");
  SubscribeTo(client, "/camera");

  std::uint32_t first = 0;
  std::uint32_t last = 0;
  std::uint32_t count = 0;
  double bytes = 0;
  std::vector<double> ages_ms;
  Time begin{};
  const Duration cpu = CostOf(view.pid()).cpu;
  for (Time now = begin; first == 0 || ToSeconds(now - begin) < seconds;
       now = std::chrono::steady_clock::now()) {
    const http::Frame frame = client.TakeFrame();
    if (!frame.ok) Fail("musher-view ends the connection");
    if (frame.opcode != http::Opcode::kBinary || frame.payload.size() < kHead) continue;
    const auto picture =
        msg::Decode<msg::Image>(std::as_bytes(std::span(frame.payload)).subspan(kHead));
    MUSHER_CHECK(picture.has_value(), "the sample is a picture");
    last = ReadNumber(*picture);
    if (first == 0) {
      first = last;
      begin = std::chrono::steady_clock::now();
    }
    ++count;
    bytes += static_cast<double>(frame.payload.size());
    ages_ms.push_back(Microseconds(Age(*picture)) / 1000);
  }
  const double used = ToSeconds(CostOf(view.pid()).cpu - cpu);
  const std::string what = std::to_string(width) + " × " + std::to_string(height) + " at " +
                           std::to_string(hz) + " Hz: ";
  table.Row(what + "MB a second", {bytes / 1e6 / seconds}, "MB/s");
  table.Row(what + "pictures that were lost", {static_cast<double>(last - first + 1 - count)}, "");
  table.Row(what + "age of a picture", ages_ms, "ms");
  table.Row(what + "CPU of musher-view", {100 * used / seconds}, "% of a core");
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  using namespace musher::benchmark;
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10;
  setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  const Table table("Pictures to a client of Foxglove's protocol");
  Measure(table, 640, 480, 30, seconds);
  Measure(table, 1280, 720, 30, seconds);
  Measure(table, 1920, 1080, 30, seconds);
  return 0;
}
