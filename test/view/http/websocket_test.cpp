#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/view/http/websocket_client.hpp"

namespace musher::http::websocket_test {

using testing::HasSubstr;
using testing::Not;

TEST(WebSocket, AnswersWithTheAcceptKeyAndTheSubprotocol) {
  Options options;
  options.subprotocols = {"musher.view.v1", "foxglove.websocket.v1"};
  RunningServer server(options, Echo, EchoWebSocket);
  WebSocketClient client(server.port(), "/live",
                         "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n"
                         "Sec-WebSocket-Extensions: permessage-deflate\r\n");
  ASSERT_TRUE(client.open());
  EXPECT_THAT(client.reply().head, HasSubstr("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo="));
  EXPECT_THAT(client.reply().head, HasSubstr("Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n"));
  EXPECT_THAT(client.reply().head, Not(HasSubstr("permessage-deflate")));
}

TEST(WebSocket, CarriesTextAndBinaryMessages) {
  RunningServer server({}, Echo, EchoWebSocket);
  WebSocketClient client(server.port());
  ASSERT_TRUE(client.open());
  const std::string large(300000, 'x');
  client.SendFrame(Opcode::kText, "é");
  client.SendFrame(Opcode::kBinary, large);
  client.SendFrame(Opcode::kBinary, "");
  client.Send(FrameBytes(Opcode::kText, "a", false) + FrameBytes(Opcode::kPing, "now") +
              FrameBytes(Opcode::kContinuation, "b"));
  std::vector<Frame> frames;
  for (int i = 0; i < 5; ++i) frames.push_back(client.TakeFrame());
  const auto pong = std::find_if(frames.begin(), frames.end(), [](const Frame& frame) {
    return frame.opcode == Opcode::kPong;  // at any time
  });
  ASSERT_NE(pong, frames.end());
  EXPECT_EQ(pong->payload, "now");
  frames.erase(pong);
  EXPECT_EQ(frames[0].payload, "é");
  EXPECT_EQ(frames[1].opcode, Opcode::kBinary);
  EXPECT_TRUE(frames[1].payload == large);
  EXPECT_EQ(frames[2].payload, "");
  EXPECT_EQ(frames[3].opcode, Opcode::kText);
  EXPECT_EQ(frames[3].payload, "ab");
}

TEST(WebSocket, HasTheRequestThatOpenedIt) {
  std::promise<Request> opened;
  const auto on_websocket = [&](const std::shared_ptr<WebSocket>& socket) {
    opened.set_value(socket->request());
    return WebSocketHandlers();
  };
  RunningServer server({}, Echo, on_websocket);
  const WebSocketClient client(server.port(), "/live?a=b", "Cookie: musher_session=s\r\n");
  const Request request = opened.get_future().get();
  EXPECT_EQ(request.path, "/live");
  EXPECT_EQ(request.query.at("a"), "b");
  EXPECT_EQ(request.cookies.at("musher_session"), "s");
  EXPECT_TRUE(request.local);
}

// By it the age of what follows is known.
TEST(WebSocket, ReportsTheAnswerOfAPingBeforeWhatFollowsIt) {
  const auto on_websocket = [](const std::shared_ptr<WebSocket>& socket) {
    WebSocketHandlers handlers = EchoWebSocket(socket);
    handlers.on_pong = [socket](const std::string& payload) {
      socket->Send(Shared("answered " + payload), false);
    };
    socket->Ping("1");
    return handlers;
  };
  RunningServer server({}, Echo, on_websocket);
  WebSocketClient client(server.port());
  const Frame ping = client.TakeFrame();
  EXPECT_EQ(ping.opcode, Opcode::kPing);
  EXPECT_EQ(ping.payload, "1");
  client.SendFrame(Opcode::kPong, "2");  // of no ping
  client.SendFrame(Opcode::kText, "before");
  client.SendFrame(Opcode::kPong, "1");
  client.SendFrame(Opcode::kPong, "1");  // it is answered already
  client.SendFrame(Opcode::kText, "after");
  for (const char* text : {"before", "answered 1", "after"}) {
    EXPECT_EQ(client.TakeFrame().payload, text);
  }
}

TEST(WebSocket, IsClosedByTheOwnerAfterWhatItSent) {
  const auto on_websocket = [](const std::shared_ptr<WebSocket>& socket) {
    for (int i = 0; i < 100; ++i) socket->Send(Shared(std::to_string(i)), false);
    socket->Close(1008, "no session");
    socket->Send(Shared("late"), false);
    return WebSocketHandlers();
  };
  RunningServer server({}, Echo, on_websocket);
  WebSocketClient client(server.port());
  for (int i = 0; i < 100; ++i) ASSERT_EQ(client.TakeFrame().payload, std::to_string(i));
  const Frame frame = client.TakeFrame();
  EXPECT_EQ(frame.close_code(), 1008u);
  EXPECT_EQ(frame.payload.substr(2), "no session");
  client.SendFrame(Opcode::kClose, frame.payload);
  EXPECT_TRUE(client.Ends());
}

TEST(WebSocket, ReportsItsEndOnce) {
  std::atomic<int> closed = 0;
  std::promise<void> ended;
  const auto on_websocket = [&](const std::shared_ptr<WebSocket>&) {
    WebSocketHandlers handlers;
    handlers.on_closed = [&] {
      if (++closed == 1) ended.set_value();
    };
    return handlers;
  };
  RunningServer server({}, Echo, on_websocket);
  {
    WebSocketClient client(server.port());
    client.SendFrame(Opcode::kClose, "\x03\xe8");
    EXPECT_EQ(client.TakeFrame().close_code(), 1000u);
  }
  EXPECT_EQ(ended.get_future().wait_for(kTestTimeout), std::future_status::ready);
  server.Stop();
  EXPECT_EQ(closed, 1);
}

TEST(WebSocket, ReportsTheEndOfAClientThatVanishes) {
  std::promise<void> ended;
  const auto on_websocket = [&](const std::shared_ptr<WebSocket>&) {
    WebSocketHandlers handlers;
    handlers.on_closed = [&] { ended.set_value(); };
    return handlers;
  };
  RunningServer server({}, Echo, on_websocket);
  { const WebSocketClient client(server.port()); }
  EXPECT_EQ(ended.get_future().wait_for(kTestTimeout), std::future_status::ready);
}

TEST(WebSocket, ReportsThatItsQueueIsEmpty) {
  std::promise<std::size_t> drained;
  const auto on_websocket = [&](const std::shared_ptr<WebSocket>& socket) {
    socket->Send(Shared(std::string(3000000, 'x')), true);
    WebSocketHandlers handlers;
    handlers.on_drained = [&, socket] { drained.set_value(socket->queued_bytes()); };
    return handlers;
  };
  RunningServer server({}, Echo, on_websocket);
  WebSocketClient client(server.port());
  EXPECT_EQ(client.TakeFrame().payload.size(), 3000000u);
  auto queued = drained.get_future();
  ASSERT_EQ(queued.wait_for(kTestTimeout), std::future_status::ready);
  EXPECT_EQ(queued.get(), 0u);
}

TEST(WebSocket, EndsIfTheClientAnswersNoPing) {
  Options options;
  options.idle_timeout = Milliseconds(1000);
  RunningServer server(options, Echo, EchoWebSocket);
  WebSocketClient client(server.port());
  EXPECT_EQ(client.TakeFrame().opcode, Opcode::kPing);
  EXPECT_TRUE(client.Ends());
}

TEST(WebSocket, RefusesMalformedFrames) {
  RunningServer server({}, Echo, EchoWebSocket);
  const std::string ping_of_200(200, 'p');
  struct Case {
    std::string bytes;
    unsigned code;
  };
  for (const Case& wrong : {Case{std::string("\x81\x01x"), 1002},  // without a mask
                            Case{"\xc1\x80" + std::string(4, '\0'), 1002},
                            Case{FrameBytes(static_cast<Opcode>(3), ""), 1002},
                            Case{FrameBytes(Opcode::kContinuation, "x"), 1002},
                            Case{FrameBytes(Opcode::kPing, ping_of_200), 1002},
                            Case{FrameBytes(Opcode::kPing, "", false), 1002},
                            Case{FrameBytes(Opcode::kText, "\xff"), 1007}}) {
    WebSocketClient client(server.port());
    ASSERT_TRUE(client.open());
    client.Send(wrong.bytes);
    EXPECT_EQ(client.TakeFrame().close_code(), wrong.code) << testing::PrintToString(wrong.bytes);
    EXPECT_TRUE(client.Ends());
  }
}

TEST(WebSocket, RefusesAFrameThatClaimsAGigabyte) {
  RunningServer server({}, Echo, EchoWebSocket);
  for (const std::uint64_t size : {std::uint64_t{1} << 30, std::uint64_t{1} << 62}) {
    WebSocketClient client(server.port());
    client.Send(FrameHead(Opcode::kBinary, size));
    EXPECT_EQ(client.TakeFrame().close_code(), 1009u);
    EXPECT_TRUE(client.Ends());
  }
}

TEST(WebSocket, RefusesAMessageThatGrowsBeyondTheLimit) {
  Options options;
  options.max_message = 1000;
  RunningServer server(options, Echo, EchoWebSocket);
  WebSocketClient client(server.port());
  client.Send(FrameBytes(Opcode::kBinary, std::string(600, 'a'), false));
  client.Send(FrameBytes(Opcode::kContinuation, std::string(600, 'a')));
  EXPECT_EQ(client.TakeFrame().close_code(), 1009u);
}

TEST(WebSocket, IsRefusedToOtherSites) {
  RunningServer server({}, Echo, EchoWebSocket);
  const auto status = [&](std::string_view headers) {
    return WebSocketClient(server.port(), "/", headers).reply().status;
  };
  EXPECT_EQ(status("Origin: https://evil.example\r\n"), 403u);
  EXPECT_EQ(status("Origin: null\r\n"), 403u);
  EXPECT_EQ(status("Sec-Fetch-Site: cross-site\r\n"), 403u);
  EXPECT_EQ(status("Origin: http://localhost:3000\r\n"), 101u);
  EXPECT_EQ(status("Sec-WebSocket-Protocol: unknown\r\n"), 400u);
}

}  // namespace musher::http::websocket_test
