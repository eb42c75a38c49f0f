// A command whose call a process of this host takes, and does not answer.

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <thread>

#include "musher/base/host.hpp"
#include "musher/test/cli/program.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/host_calls.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::host_call_test {

using ::testing::HasSubstr;

// It was reported as an exit of the controller, and the journal on disk was shown instead.
TEST(AControllerOfThisHost, ThatMayWriteNoLongReplyHasNotExited) {
  const std::string name_space = "host_call_test_" + std::to_string(getpid());
  transport::LinuxEventLoop loop;
  const auto server = transport::HostServer::Make(
      loop, NameLock::NameOf(transport::DomainId({}).value(), name_space, "musher/calls"));
  ASSERT_TRUE(server) << server.error().message;
  server.value()->Offer("get_history", [](auto, const transport::HostServer::Reply& reply) {
    reply(msg::Bytes(100'000));
  });
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &none);
  std::thread controller([&loop] { loop.Run(); });
  const Ran history = RunProgram({"--namespace", name_space, "history"});
  loop.Stop();
  controller.join();
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  EXPECT_EQ(history.exit, 4);
  EXPECT_THAT(history.err, HasSubstr("the controller: process " + std::to_string(getpid()) +
                                     " cannot write its reply of 100000 bytes to a file in "
                                     "memory: File too large; raise its limit"));
}

}  // namespace musher::cli::host_call_test
