// How the tools of the modules find the module that they are meant for.

#include "musher/actuator/program/command_line_tool.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::program {

// A process of a namespace. Its module subscribes on command.
class LateModule {
 public:
  explicit LateModule(const std::string& name_space) : domain_(transport::TestDomain()) {
    EXPECT_EQ(pipe(orders_.data()), 0);
    process_ = fork();
    if (process_ == 0) Run(name_space);
  }
  ~LateModule() {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    for (const int end : orders_) close(end);
  }
  LateModule(const LateModule&) = delete;
  LateModule& operator=(const LateModule&) = delete;

  void Subscribe() { EXPECT_EQ(write(orders_[1], "s", 1), 1); }

 private:
  [[noreturn]] void Run(const std::string& name_space) {
    transport::DdsOptions dds;
    dds.domain_id = domain_;
    dds.node_name = "motion";
    dds.name_space = name_space;
    const auto module = transport::NodeThread::Start(dds).value();
    char order = 0;
    if (read(orders_[0], &order, 1) != 1) _exit(1);
    std::unique_ptr<transport::Subscription> commands;
    module->RunOnLoop([&] {
      commands = transport::MakeSubscription<msg::String>(
                     module->node(), "dog/command",
                     [](const msg::String&, const transport::SampleInfo&) {})
                     .value();
    });
    for (;;) pause();
  }

  const int domain_;
  std::array<int, 2> orders_{};
  pid_t process_ = 0;
};

bool Finds(LateModule& module) {
  ToolOptions options;
  options.domain = transport::TestDomain();
  options.name_space = "dog";
  const auto link = ToolLink::Open(options).value();
  const auto publisher =
      transport::MakePublisher<msg::String>(link->node(), link->Name("command")).value();
  transport::EventLoop& loop = link->node().loop();
  const auto late = loop.At(loop.Now() + link->discovery() + Milliseconds(300),
                            [&module] { module.Subscribe(); });
  return link->Find([&publisher] { return publisher->MatchedReaders() != 0; });
}

// On a computer thirty times slower for a moment it said that there is no motion manager.
TEST(ToolLink, FindsAModuleThatIsLateWhileProcessesOfItsNamespaceRun) {
  LateModule module("dog");
  EXPECT_TRUE(Finds(module));
}

TEST(ToolLink, FindsNothingForLongWhereOnlyAnotherNamespaceHasProcesses) {
  LateModule module("cat");
  EXPECT_FALSE(Finds(module));
}

}  // namespace musher::program
