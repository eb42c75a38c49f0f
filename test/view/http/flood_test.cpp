// Clients that want to keep the server from its work, beside one that it serves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <list>

#include "musher/test/view/http/websocket_client.hpp"

namespace musher::http::flood_test {

// As many connections as this process may have, up to 10,000.
std::size_t HalfOpenCount() {
  rlimit limit{};
  getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
  constexpr rlim_t kOthers = 600;  // the server's and the test's own
  return std::min<rlim_t>(10000, limit.rlim_cur - kOthers);
}

TEST(Flood, OfHalfOpenConnectionsLeavesRoomForOthers) {
  RunningServer server({}, Echo, EchoWebSocket);
  WebSocketClient before(server.port());
  ASSERT_TRUE(before.open());
  const std::size_t count = HalfOpenCount();
  ASSERT_GE(count, 1000u);
  std::list<Client> half_open;
  for (std::size_t i = 0; i < count; ++i) {
    Client& client = half_open.emplace_back(server.port());
    ASSERT_TRUE(client.connected()) << i;
    client.Send("GET / HTTP/1.1\r\nHo");
    if (i % 500 != 0) continue;
    Client other(server.port());
    const Time begin = server.loop().Now();
    ASSERT_EQ(other.Get("/a").status, 200u) << i;
    EXPECT_LT(server.loop().Now() - begin, std::chrono::seconds(20)) << i;
  }
  before.SendFrame(Opcode::kText, "here");
  EXPECT_EQ(before.TakeMessage().payload, "here");
}

TEST(Flood, OfConnectionsInUseIsRefused) {
  Options options;
  options.max_connections = 3;
  std::promise<void> ended;
  const auto on_websocket = [&](const std::shared_ptr<WebSocket>& socket) {
    WebSocketHandlers handlers;
    if (socket->request().path == "/ends") handlers.on_closed = [&] { ended.set_value(); };
    return handlers;
  };
  RunningServer server(options, Echo, on_websocket);
  std::list<WebSocketClient> open;
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(open.emplace_back(server.port(), i == 0 ? "/ends" : "/").open());
  }
  Client refused(server.port());
  EXPECT_EQ(refused.TakeReply().status, 503u);
  EXPECT_TRUE(refused.Ends());
  open.pop_front();
  ASSERT_EQ(ended.get_future().wait_for(kTestTimeout), std::future_status::ready);
  EXPECT_EQ(Client(server.port()).Get("/").status, 200u);
}

TEST(Flood, TheConnectionThatIsSilentForLongestMakesRoom) {
  Options options;
  options.max_connections = 3;
  RunningServer server(options, Echo, EchoWebSocket);
  Client idle(server.port());
  ASSERT_EQ(idle.Get("/").status, 200u);
  Client silent(server.port());
  Client later(server.port());
  Client last(server.port());
  EXPECT_EQ(last.Get("/").status, 200u);
  EXPECT_TRUE(silent.Ends());
  EXPECT_EQ(later.Get("/").status, 200u);
  EXPECT_EQ(idle.Get("/").status, 200u);
}

// The loop is blocked meanwhile: what is received waits in the kernel, not in memory.
TEST(Flood, OfMessagesWaitsForTheLoop) {
  std::promise<void> blocked;
  std::promise<void> go;
  std::shared_future<void> gone = go.get_future().share();
  std::atomic<std::size_t> received = 0;
  std::promise<void> all;
  const auto on_websocket = [&](const std::shared_ptr<WebSocket>&) {
    WebSocketHandlers handlers;
    handlers.on_message = [&](const std::string&, bool) {
      if (++received == 1) blocked.set_value();
      gone.wait();
    };
    handlers.on_closed = [&] { all.set_value(); };
    return handlers;
  };
  RunningServer server({}, Echo, on_websocket);
  WebSocketClient client(server.port());
  const std::string frame = FrameBytes(Opcode::kBinary, std::string(100000, 'x'));
  client.Send(frame);
  blocked.get_future().get();
  timeval short_time{0, 200000};
  setsockopt(client.fd(), SOL_SOCKET, SO_SNDTIMEO, &short_time, sizeof short_time);
  std::size_t sent = 1;
  while (sent < 2000 && client.Send(frame)) ++sent;
  EXPECT_LT(sent, 500u);  // 50 MB; the server has stopped reading
  go.set_value();
  shutdown(client.fd(), SHUT_WR);
  ASSERT_EQ(all.get_future().wait_for(kTestTimeout), std::future_status::ready);
  EXPECT_EQ(received, sent);
}

TEST(Flood, OfPingsIsAnswered) {
  RunningServer server({}, Echo, EchoWebSocket);
  WebSocketClient client(server.port());
  std::string pings;
  for (int i = 0; i < 2000; ++i) pings += FrameBytes(Opcode::kPing, "x");
  client.Send(pings + FrameBytes(Opcode::kText, "after"));
  Frame frame = client.TakeFrame();
  while (frame.ok && frame.opcode == Opcode::kPong) frame = client.TakeFrame();
  EXPECT_EQ(frame.payload, "after");
}

TEST(Flood, IntoAClientThatSleepsClosesItAndDelaysNoOther) {
  Options options;
  options.max_queue = 1 << 20;
  std::shared_ptr<WebSocket> sleeper;
  std::promise<void> closed;
  const auto on_websocket = [&](const std::shared_ptr<WebSocket>& socket) {
    if (socket->request().path != "/sleeps") return EchoWebSocket(socket);
    sleeper = socket;
    WebSocketHandlers handlers;
    handlers.on_closed = [&] { closed.set_value(); };
    return handlers;
  };
  RunningServer server(options, Echo, on_websocket);
  const WebSocketClient sleeps(server.port(), "/sleeps", {}, 4096);
  WebSocketClient lively(server.port());
  ASSERT_TRUE(sleeps.open() && lively.open());
  std::atomic<std::size_t> most = 0;
  auto ended = closed.get_future();
  const Time deadline = server.loop().Now() + kTestTimeout;
  while (ended.wait_for(Duration(0)) != std::future_status::ready) {
    ASSERT_LT(server.loop().Now(), deadline);
    server.loop().Post([&] {
      sleeper->Send(Shared(std::string(50000, 'x')), true);
      most = std::max<std::size_t>(most, sleeper->queued_bytes());
    });
    lively.SendFrame(Opcode::kText, "now");
    ASSERT_EQ(lively.TakeMessage().payload, "now");
  }
  EXPECT_LE(most, options.max_queue);
  EXPECT_GT(most, options.max_queue / 2);
  server.loop().Post([&] { sleeper = nullptr; });
}

TEST(Flood, OfASlowClientIsClosedWithItsReason) {
  Options options;
  options.max_queue = 100000;
  std::promise<void> filled;
  // 20 MB: more than the kernel takes, however fast the network thread writes meanwhile.
  const auto on_websocket = [&](const std::shared_ptr<WebSocket>& socket) {
    const auto message = Shared(std::string(40000, 'x'));
    for (int i = 0; i < 500; ++i) socket->Send(message, true);
    filled.set_value();
    return WebSocketHandlers();
  };
  RunningServer server(options, Echo, on_websocket);
  WebSocketClient client(server.port(), "/", {}, 4096);
  filled.get_future().get();
  Frame frame = client.TakeFrame();
  while (frame.ok && frame.opcode == Opcode::kBinary) frame = client.TakeFrame();
  EXPECT_EQ(frame.close_code(), 1013u);
}

TEST(Flood, TheServerEndsThoughNoClientAnswers) {
  RunningServer server(
      {},
      [](const Request&, const Respond& respond) {
        static Respond kept;  // never answered
        kept = respond;
      },
      EchoWebSocket);
  Client silent(server.port());
  Client half(server.port());
  half.Send("GET / HT");
  Client waiting(server.port());
  waiting.Send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  WebSocketClient polite(server.port());
  WebSocketClient rude(server.port());  // does not answer the close frame
  ASSERT_TRUE(polite.open() && rude.open());
  auto closes = std::async(std::launch::async, [&] {
    const Frame frame = polite.TakeMessage();
    polite.SendFrame(Opcode::kClose, frame.payload);
    return frame.close_code();
  });
  // Half a second, and more on a busy computer; without a limit it would wait for the rude one.
  EXPECT_LT(server.Stop(), std::chrono::seconds(20));
  EXPECT_EQ(closes.get(), 1001u);
  EXPECT_TRUE(silent.Ends());
  EXPECT_TRUE(half.Ends());
  EXPECT_TRUE(polite.Ends());
  EXPECT_EQ(rude.TakeMessage().close_code(), 1001u);
  EXPECT_TRUE(rude.Ends());
}

}  // namespace musher::http::flood_test
