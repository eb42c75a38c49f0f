// Calls between processes of one host.

#include "musher/transport/host_calls.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "musher/base/host.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::transport::host_calls_test {

msg::Bytes BytesOf(std::size_t size, std::byte value = std::byte{7}) {
  return msg::Bytes(size, value);
}

class HostCalls : public ::testing::Test {
 protected:
  // Of this process, so that tests run beside each other.
  const std::string name_ = "test-" + std::to_string(getpid());

  void Serve() {
    auto server = HostServer::Make(loop_, name_);
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(server).value();
    server_->Offer("echo", [](std::span<const std::byte> request, const HostServer::Reply& reply) {
      reply(msg::Bytes(request.begin(), request.end()));
    });
    server_->Offer("later", [this](std::span<const std::byte>, HostServer::Reply reply) {
      later_.push_back(std::move(reply));
    });
  }
  struct Call {
    std::unique_ptr<HostCall> call;
    std::optional<Result<msg::Bytes>> reply;
  };
  std::unique_ptr<Call> Begin(const std::string& service, const msg::Bytes& request = BytesOf(3)) {
    auto call = std::make_unique<Call>();
    call->call = HostCall::Make(loop_, name_, service, request, [self = call.get()](auto reply) {
      self->reply = std::move(reply);
    });
    return call;
  }
  bool Await(const std::function<bool()>& done) {
    return loop_.RunUntil(done, loop_.Now() + std::chrono::seconds(120));
  }
  Result<msg::Bytes> End(Call& call) {
    EXPECT_TRUE(Await([&] { return call.reply.has_value(); }));
    return call.reply.value_or(Error{kCodeTimeout, "none"});
  }

  LinuxEventLoop loop_;
  std::unique_ptr<HostServer> server_;
  std::vector<HostServer::Reply> later_;
};

TEST_F(HostCalls, GetTheReply) {
  Serve();
  EXPECT_EQ(End(*Begin("echo", BytesOf(60'000))).value(), BytesOf(60'000));
}

TEST_F(HostCalls, GetAReplyOfManyMegabytesAndOneOfNothing) {
  Serve();
  const auto call = Begin("later");
  const auto empty = Begin("later");
  ASSERT_TRUE(Await([&] { return later_.size() == 2; }));
  later_[0](BytesOf(20 << 20));
  later_[1]({});
  EXPECT_EQ(End(*call).value().size(), 20u << 20);
  EXPECT_TRUE(End(*empty).value().empty());
}

// It was reported as an end of the server.
TEST_F(HostCalls, WhoseReplyTheFileSizeLimitForbidsSaySo) {
  Serve();
  const auto call = Begin("later");
  const auto cut = Begin("later");
  const auto short_one = Begin("later");
  ASSERT_TRUE(Await([&] { return later_.size() == 3; }));
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto reply_within = [&](rlim_t file_size, std::size_t caller, std::size_t reply) {
    const rlimit limit{file_size, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
    later_[caller](BytesOf(reply));
  };
  reply_within(0, 0, 65'537);
  reply_within(4096, 1, 65'537);
  reply_within(0, 2, 65'536);
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  const std::string pid = std::to_string(getpid());
  const Error forbidden{kCodeFailed,
                        "process " + pid +
                            " cannot write its reply of 65537 bytes to a file in memory: File too "
                            "large; raise its limit of the file size: prlimit --fsize=unlimited "
                            "--pid " +
                            pid + ", for a systemd unit LimitFSIZE=infinity"};
  EXPECT_EQ(End(*call).error(), forbidden);
  EXPECT_EQ(End(*cut).error(), forbidden);
  EXPECT_EQ(End(*short_one).value().size(), 65'536U) << "it needs no file";
}

TEST_F(HostCalls, GetTheirOwnRepliesInWhicheverOrder) {
  Serve();
  const auto first = Begin("later");
  const auto second = Begin("later");
  ASSERT_TRUE(Await([&] { return later_.size() == 2; }));
  later_[1](BytesOf(2));
  EXPECT_EQ(End(*second).value(), BytesOf(2));
  EXPECT_FALSE(first->reply);
  later_[0](BytesOf(1));
  EXPECT_EQ(End(*first).value(), BytesOf(1));
}

TEST_F(HostCalls, WithoutAServerAreNotMade) {
  EXPECT_EQ(Begin("echo")->call, nullptr);
  Serve();
  server_.reset();
  EXPECT_EQ(Begin("echo")->call, nullptr);
}

TEST_F(HostCalls, OfAnUnknownServiceAreNotTaken) {
  Serve();
  EXPECT_EQ(End(*Begin("nothing")).error().code, kCodeUnSupport);
}

TEST_F(HostCalls, FailWhenTheServerEndsFirst) {
  Serve();
  const auto call = Begin("later");
  ASSERT_TRUE(Await([&] { return !later_.empty(); }));
  server_.reset();
  EXPECT_EQ(End(*call).error().code, kCodeNetError);
  later_[0](BytesOf(1));  // too late, for no caller
}

TEST_F(HostCalls, WhoseCallerHasGoneAreForgotten) {
  Serve();
  auto call = Begin("later");
  ASSERT_TRUE(Await([&] { return !later_.empty(); }));
  call.reset();
  EXPECT_TRUE(End(*Begin("echo")));
  later_[0](BytesOf(1));
  EXPECT_TRUE(End(*Begin("echo")));
}

TEST_F(HostCalls, ThatAreTooLongAreNotMade) {
  Serve();
  EXPECT_EQ(Begin("echo", BytesOf(1 << 20))->call, nullptr);
}

TEST_F(HostCalls, BeyondTheMostAtATimeAreNotTaken) {
  Serve();
  std::vector<std::unique_ptr<Call>> calls;
  for (int i = 0; i < 64; ++i) calls.push_back(Begin("later"));
  ASSERT_TRUE(Await([&] { return later_.size() == 64; }));
  EXPECT_EQ(End(*Begin("echo")).error().code, kCodeUnSupport);
  calls.clear();
  ASSERT_TRUE(Await([&] { return End(*Begin("echo")).ok(); }));
}

TEST_F(HostCalls, WithAMalformedRequestFail) {
  Serve();
  server_->Offer<msg::Trigger>("trigger", [](const auto&, auto reply, ParticipantId) {
    reply(msg::Trigger::Response{true, "done"});
  });
  EXPECT_FALSE(DecodeReply<msg::Trigger>(End(*Begin("trigger", BytesOf(2)))));
  const auto call = Begin("trigger", internal::EncodeEnvelope({}, msg::Trigger::Request{}));
  const auto reply = DecodeReply<msg::Trigger>(End(*call));
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply.value().message, "done");
}

// Needs root, to be another user.
TEST_F(HostCalls, ToAServerOfAnotherUserAreNotMade) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root";
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t other = fork();
  if (other == 0) {
    if (setuid(65534) != 0) _exit(3);
    const auto listening = ListenAt(name_, 4);
    if (write(ready[1], "r", 1) != 1) _exit(4);
    pause();
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  if (fork() == 0) {  // not root: it would trust no other user
    if (setuid(65533) != 0) _exit(3);
    _exit(Begin("echo")->call == nullptr ? 0 : 1);
  }
  int status = -1;
  wait(&status);
  EXPECT_EQ(status, 0);
  kill(other, SIGKILL);
  waitpid(other, nullptr, 0);
}

}  // namespace musher::transport::host_calls_test
