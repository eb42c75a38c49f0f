// What a client sends as bytes, and what the server answers.

#include "musher/view/http/server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/view/http/client.hpp"

namespace musher::http::server_test {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class HttpServer : public testing::Test {
 protected:
  // The response to the bytes of a request on a connection of its own.
  Client::Reply ReplyTo(const std::string& bytes) const {
    Client client(server_.port());
    client.Send(bytes);
    return client.TakeReply();
  }

  RunningServer server_{{}, Echo, NoWebSocket};
};

TEST_F(HttpServer, AnswersSeveralRequestsOfAConnection) {
  Client client(server_.port());
  EXPECT_EQ(client.Get("/a").body, "GET /a body=");
  EXPECT_EQ(client.Get("/b?x=1").body, "GET /b body=");
  client.Send("POST /c HTTP/1.1\r\nHost: localhost\r\nContent-Length: 3\r\n\r\nabc");
  EXPECT_EQ(client.TakeReply().body, "POST /c body=abc");
  client.Send(
      "POST /d HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
      "2\r\nab\r\n1\r\nc\r\n0\r\n\r\n");
  EXPECT_EQ(client.TakeReply().body, "POST /d body=abc");
}

TEST_F(HttpServer, AnswersInTheOrderOfTheRequests) {
  std::string requests;
  for (int i = 0; i < 200; ++i) {
    requests += "GET /" + std::to_string(i) + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  }
  Client client(server_.port());
  client.Send(requests);
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(client.TakeReply().body, "GET /" + std::to_string(i) + " body=");
  }
}

TEST_F(HttpServer, TakesARequestByteByByte) {
  Client client(server_.port());
  for (const char c :
       std::string("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n\r\nab")) {
    client.Send(std::string(1, c));
  }
  EXPECT_EQ(client.TakeReply().body, "POST / body=ab");
}

TEST_F(HttpServer, ClosesTheConnectionOnRequest) {
  for (const std::string request :
       {"GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
        "GET / HTTP/1.0\r\nHost: localhost\r\n\r\n"}) {
    Client client(server_.port());
    client.Send(request);
    EXPECT_THAT(client.TakeReply().head, HasSubstr("Connection: close\r\n"));
    EXPECT_TRUE(client.Ends());
  }
}

TEST_F(HttpServer, AnswersHeadWithoutTheBody) {
  Client client(server_.port());
  client.Send("HEAD /a HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(client.TakeReply(true).head, HasSubstr("Content-Length: 12\r\n"));
  EXPECT_EQ(client.Get("/b").body, "GET /b body=");
}

TEST_F(HttpServer, AsksForABodyThatTheClientAnnounces) {
  Client client(server_.port());
  client.Send(
      "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\nExpect: 100-continue\r\n\r\n");
  EXPECT_EQ(client.TakeReply().status, 100u);
  client.Send("ab");
  EXPECT_EQ(client.TakeReply().body, "POST / body=ab");
}

TEST_F(HttpServer, ProtectsEveryResponse) {
  for (const std::string request :
       {"GET /api/topics HTTP/1.1\r\nHost: localhost\r\n\r\n", "nonsense\r\n\r\n"}) {
    const std::string head = ReplyTo(request).head;
    EXPECT_THAT(head, HasSubstr("X-Content-Type-Options: nosniff\r\n"));
    EXPECT_THAT(head, HasSubstr("Content-Security-Policy: default-src 'self'; "));
    EXPECT_THAT(head, HasSubstr("Referrer-Policy: no-referrer\r\n"));
    EXPECT_THAT(head, HasSubstr("Cache-Control: no-store\r\n"));
  }
}

TEST_F(HttpServer, RefusesMalformedRequests) {
  const std::string host = "Host: localhost\r\n";
  for (const std::string& request : {
           std::string("\x16\x03\x01\x02\r\n\r\n"),
           std::string("GET\r\n\r\n"),
           std::string("GET / HTTP/9.9\r\n") + host + "\r\n",
           std::string("GET / HTTP/1.1\r\n\r\n"),
           std::string("GET / HTTP/1.1\r\n") + host + host + "\r\n",
           std::string("GET / HTTP/1.1\r\nNo colon\r\n") + host + "\r\n",
           std::string("GET http://localhost/ HTTP/1.1\r\n") + host + "\r\n",
           std::string("GET /../etc/passwd HTTP/1.1\r\n") + host + "\r\n",
           std::string("GET /%2e%2e/etc/passwd HTTP/1.1\r\n") + host + "\r\n",
           std::string("GET /a\\b HTTP/1.1\r\n") + host + "\r\n",
           std::string("GET /a%00b HTTP/1.1\r\n") + host + "\r\n",
           std::string("POST / HTTP/1.1\r\nContent-Length: -1\r\n") + host + "\r\n",
           std::string("POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n") + host +
               "\r\n",
           std::string("POST / HTTP/1.1\r\nContent-Length: 1\r\nTransfer-Encoding: chunked\r\n") +
               host + "\r\n",
           std::string("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n") + host + "\r\nzz\r\n",
       }) {
    Client client(server_.port());
    client.Send(request);
    const auto reply = client.TakeReply();
    EXPECT_EQ(reply.status, 400u) << request;
    EXPECT_THAT(reply.body, StartsWith("{\"error\":{\"code\":110,\"message\":\"")) << request;
    EXPECT_TRUE(client.Ends()) << request;
  }
}

TEST_F(HttpServer, RefusesWhatIsTooLarge) {
  const std::string begin = " HTTP/1.1\r\nHost: localhost\r\n";
  EXPECT_EQ(ReplyTo("GET /" + std::string(5000, 'a') + begin + "\r\n").status, 414u);
  EXPECT_EQ(ReplyTo("GET /" + std::string(5000, 'a')).status, 414u);
  EXPECT_EQ(ReplyTo("GET /" + begin + "X: " + std::string(20000, 'a') + "\r\n\r\n").status, 431u);
  EXPECT_EQ(ReplyTo("POST /" + begin + "Content-Length: 1048577\r\n\r\n").status, 413u);
  EXPECT_EQ(ReplyTo("POST /" + begin + "Content-Length: 99999999999999999999\r\n\r\n").status,
            400u);
  EXPECT_EQ(ReplyTo("POST /" + begin + "Transfer-Encoding: chunked\r\n\r\n200000\r\n").status,
            413u);
}

// The kernel discards a response when its socket is closed with unread bytes.
TEST_F(HttpServer, RefusesALargeBodyToAClientThatSendsItAll) {
  Client client(server_.port());
  client.Send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 4000000\r\n\r\n" +
              std::string(4000000, 'a'));
  EXPECT_EQ(client.TakeReply().status, 413u);
}

TEST_F(HttpServer, RefusesOtherMethods) {
  const auto reply = ReplyTo("DELETE / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(reply.status, 405u);
  EXPECT_THAT(reply.head, HasSubstr("Allow: GET, HEAD, POST\r\n"));
}

TEST_F(HttpServer, RefusesOtherSites) {
  EXPECT_EQ(ReplyTo("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 403u);
  const std::string post = "POST / HTTP/1.1\r\nHost: localhost:8765\r\nContent-Length: 0\r\n";
  EXPECT_EQ(ReplyTo(post + "Origin: https://evil.example\r\n\r\n").status, 403u);
  EXPECT_EQ(ReplyTo(post + "Sec-Fetch-Site: cross-site\r\n\r\n").status, 403u);
  EXPECT_EQ(ReplyTo(post + "Origin: http://localhost:8765\r\n\r\n").status, 200u);
  EXPECT_EQ(ReplyTo(post + "\r\n").status, 200u);
}

TEST(Server, EndsAConnectionThatSendsSlowly) {
  Options options;
  options.header_timeout = Milliseconds(1000);
  options.idle_timeout = Milliseconds(1000);
  RunningServer server(options, Echo, NoWebSocket);
  Client silent(server.port());
  Client head(server.port());
  Client body(server.port());
  Client later(server.port());
  head.Send("GET / HTTP/1.1\r\nHost: loc");
  body.Send("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\nabc");
  EXPECT_EQ(later.Get("/").status, 200u);
  later.Send("GET / HT");
  EXPECT_TRUE(silent.Ends());
  EXPECT_TRUE(silent.received().empty());
  EXPECT_EQ(head.TakeReply().status, 408u);
  EXPECT_TRUE(head.Ends());
  EXPECT_EQ(body.TakeReply().status, 408u);
  EXPECT_EQ(later.TakeReply().status, 408u);
}

TEST(Server, EndsAnIdleConnection) {
  Options options;
  options.idle_timeout = Milliseconds(1000);
  RunningServer server(options, Echo, NoWebSocket);
  Client client(server.port());
  EXPECT_EQ(client.Get("/").status, 200u);
  EXPECT_TRUE(client.Ends());
}

TEST(Server, AnswersForAnOwnerThatDropsTheRequest) {
  RunningServer server(
      {}, [](const Request&, const Respond&) {}, NoWebSocket);
  Client client(server.port());
  EXPECT_EQ(client.Get("/").status, 500u);
  EXPECT_EQ(client.Get("/").status, 500u);
}

TEST(Server, SendsTheFirstResponseOnly) {
  Respond kept;
  const auto text = [](const std::string& body) {
    Response response;
    response.body = Shared(body);
    return response;
  };
  const auto on_request = [&](const Request& request, const Respond& respond) {
    if (kept) kept(text("late"));
    kept = respond;
    respond(text("first of " + request.path));
    respond(text("second of " + request.path));
  };
  RunningServer server({}, on_request, NoWebSocket);
  Client client(server.port());
  EXPECT_EQ(client.Get("/a").body, "first of /a");
  EXPECT_EQ(client.Get("/b").body, "first of /b");
}

TEST(Server, AnswersLater) {
  std::vector<transport::LoopHandlePtr> timers;
  transport::EventLoop* loop = nullptr;
  std::promise<void> ready;
  const auto on_request = [&](const Request& request, const Respond& respond) {
    timers.push_back(
        loop->At(loop->Now() + Milliseconds(5), [request, respond] { Echo(request, respond); }));
  };
  RunningServer server({}, on_request, NoWebSocket);
  server.loop().Post([&] {
    loop = &server.loop();
    ready.set_value();
  });
  ready.get_future().get();
  Client client(server.port());
  EXPECT_EQ(client.Get("/a").body, "GET /a body=");
  server.loop().Post([&] { timers.clear(); });
}

TEST(Server, KnowsTheClient) {
  Request seen;
  const auto on_request = [&](const Request& request, const Respond& respond) {
    seen = request;
    Echo(request, respond);
  };
  RunningServer server({}, on_request, NoWebSocket);
  Client client(server.port());
  EXPECT_EQ(client.Get("/a?b=c", "Cookie: d=e\r\nX-Thing: f\r\n").status, 200u);
  EXPECT_EQ(seen.peer, "127.0.0.1");
  EXPECT_TRUE(seen.local);
  EXPECT_EQ(seen.query.at("b"), "c");
  EXPECT_EQ(seen.cookies.at("d"), "e");
  EXPECT_EQ(seen.headers.at("x-thing"), "f");
  EXPECT_EQ(client.Get("/", "X-Forwarded-For: 10.0.0.1\r\n").status, 200u);
  EXPECT_FALSE(seen.local);
  EXPECT_EQ(seen.peer, "10.0.0.1 through a proxy");
}

TEST(Server, ReportsAnAddressItCannotListenOn) {
  transport::LinuxEventLoop loop;
  Options options;
  options.bind = "somewhere";
  EXPECT_THAT(Server::Make(loop, options, Echo, NoWebSocket).error().message,
              HasSubstr("'somewhere' is not an address"));
  options.bind = "127.0.0.1";
  options.port = 0;
  const auto first = Server::Make(loop, options, Echo, NoWebSocket);
  ASSERT_TRUE(first.ok());
  options.port = first.value()->port();
  EXPECT_THAT(Server::Make(loop, options, Echo, NoWebSocket).error().message,
              HasSubstr("cannot listen on 127.0.0.1 port " + std::to_string(options.port) +
                        ": Address already in use"));
}

}  // namespace musher::http::server_test
