#include "musher/transport/dds/node_thread.hpp"

#include <future>
#include <thread>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::transport {
namespace {

class DdsNodeThread : public NodeThread {
 public:
  DdsNodeThread() = default;
  ~DdsNodeThread() override {
    loop_.Stop();
    if (thread_.joinable()) thread_.join();
  }

  Result<> Open(const DdsOptions& options) {
    auto node = MakeDdsNode(loop_, options);
    if (!node) return node.error();
    options_ = options;
    options_.domain_id = DomainId(options).value();  // the environment may change
    node_ = std::move(node).value();
    thread_ = std::thread([this] { loop_.Run(); });
    return Ok();
  }

  void RunOnLoop(const std::function<void()>& work) override {
    MUSHER_CHECK(std::this_thread::get_id() != thread_.get_id(),
                 "called on the loop itself, which would wait for ever");
    std::promise<void> done;
    loop_.Post([&] {
      work();
      done.set_value();
    });
    done.get_future().wait();
  }

  void WaitFor(Duration time) override { std::this_thread::sleep_for(time); }

  Result<std::unique_ptr<Node>> MakeNode(const std::string& name_space,
                                         const std::string& name) override {
    DdsOptions options = options_;
    options.name_space = name_space;
    options.node_name = name;
    std::promise<Result<std::unique_ptr<Node>>> node;
    RunOnLoop([&] { node.set_value(MakeDdsNode(loop_, options)); });
    return node.get_future().get();
  }

  Node& node() override { return *node_; }
  const std::optional<Credentials>& credentials() const override { return options_.credentials; }

 private:
  DdsOptions options_;
  LinuxEventLoop loop_;
  std::unique_ptr<Node> node_;
  std::thread thread_;
};

}  // namespace

Result<std::shared_ptr<NodeThread>> NodeThread::Start(const DdsOptions& options) {
  auto started = std::make_shared<DdsNodeThread>();
  if (Result<> opened = started->Open(options); !opened) return opened.error();
  return std::shared_ptr<NodeThread>(std::move(started));
}

}  // namespace musher::transport
