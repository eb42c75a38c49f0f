// A command whose call a process of this host takes, and does not answer.

#include <gmock/gmock.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <sstream>
#include <thread>

#include "musher/base/host.hpp"
#include "musher/messages/musher_msgs/capabilities.hpp"
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

// Two threads that share one CPU: each waits for it half of the time.
class TwoThreadsOnOneCpu {
 public:
  ~TwoThreadsOnOneCpu() {
    end_ = true;
    for (std::thread& one : threads_) one.join();
  }

 private:
  void Spin() const {
    cpu_set_t cpus;
    sched_getaffinity(0, sizeof(cpus), &cpus);
    int first = 0;
    while (!CPU_ISSET(first, &cpus)) ++first;
    CPU_ZERO(&cpus);
    CPU_SET(first, &cpus);
    EXPECT_EQ(sched_setaffinity(0, sizeof(cpus), &cpus), 0);
    while (!end_) {
    }
  }

  std::atomic<bool> end_ = false;
  std::thread threads_[2] = {std::thread([this] { Spin(); }), std::thread([this] { Spin(); })};
};

// The text that a program writes; `has_it` becomes true once it contains `words`.
class Watched : public std::stringbuf {
 public:
  explicit Watched(std::string words) : words_(std::move(words)) {}
  std::atomic<bool> has_it = false;

 protected:
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    const std::streamsize written = std::stringbuf::xsputn(text, size);
    if (str().find(words_) != std::string::npos) has_it = true;
    return written;
  }

 private:
  const std::string words_;
};

// This process is the controller, too. It answers once the command has said that it waits.
TEST(AControllerOfThisHost, ThatIsShortOfCpuTimeIsReportedAndWaitedFor) {
  const std::string name_space = "host_call_test_" + std::to_string(getpid());
  const int domain = transport::DomainId({}).value();
  const auto leads =
      NameLock::Acquire(NameLock::NameOf(domain, name_space, "musher/controller")).value();
  transport::LinuxEventLoop loop;
  const auto server =
      transport::HostServer::Make(loop, NameLock::NameOf(domain, name_space, "musher/calls"));
  ASSERT_TRUE(server) << server.error().message;
  Watched said("the controller (pid " + std::to_string(getpid()) +
               ") is short of CPU time; waiting");
  std::optional<transport::HostServer::Reply> reply;
  server.value()->Offer("get_capabilities",
                        [&](auto, const transport::HostServer::Reply& given) { reply = given; });
  const auto answer = loop.Every(Milliseconds(10), [&] {
    if (!reply || !said.has_it) return;
    (*reply)(transport::internal::EncodeEnvelope({}, msg::GetCapabilities::Response{}));
    reply.reset();
  });
  std::thread controller([&loop] { loop.Run(); });
  std::ostringstream out;
  std::ostream err(&said);
  int exit = -1;
  {
    const TwoThreadsOnOneCpu busy;
    const char* const argv[] = {"musher", "--namespace", name_space.c_str(), "capabilities"};
    exit = musher::cli::Run(4, argv, out, err, false);
  }
  loop.Stop();
  controller.join();
  EXPECT_EQ(exit, 0) << said.str();
  EXPECT_TRUE(said.has_it) << said.str();
}

}  // namespace musher::cli::host_call_test
