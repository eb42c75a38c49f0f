#include "musher/test/contract/world.hpp"

#include <unistd.h>

#include <algorithm>

#include "musher/test/support/domain.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::transport {

namespace {

class SimWorld : public World {
 public:
  std::unique_ptr<Node> MakeNode() override { return network_.MakeNode("host"); }
  EventLoop& loop() override { return observer_->loop(); }

 private:
  sim::Network network_{1};
  std::unique_ptr<Node> observer_ = network_.MakeNode("host");
};

class DdsWorld : public World {
 public:
  std::unique_ptr<Node> MakeNode() override {
    DdsOptions options;
    options.domain_id = TestDomain();
    return Must(MakeDdsNode(loop_, options));
  }
  EventLoop& loop() override { return loop_; }

 private:
  LinuxEventLoop loop_;
};

}  // namespace

std::unique_ptr<World> MakeSimWorld() {
  return std::make_unique<SimWorld>();
}
std::unique_ptr<World> MakeDdsWorld() {
  return std::make_unique<DdsWorld>();
}

std::string Contract::Unique(const std::string& name) {
  std::string test = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::replace(test.begin(), test.end(), '/', '_');
  return test + "_" + std::to_string(getpid()) + "/" + name;
}

std::string WorldName(const ::testing::TestParamInfo<MakeWorld>& info) {
  return info.param == &MakeSimWorld ? "Sim" : "Dds";
}

}  // namespace musher::transport
