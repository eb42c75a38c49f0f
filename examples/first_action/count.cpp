// count N: lets the desk compute N numbers, and prints how far it is.

#include <cstdlib>
#include <future>
#include <iostream>
#include <memory>

#include "fibonacci_client.hpp"
#include "musher/transport/dds/node_thread.hpp"

int main(int argc, char** argv) {
  const auto node = transport::NodeThread::Start();
  if (!node) {
    std::cerr << "count: " << node.error().message << "\n";
    return 2;
  }
  std::unique_ptr<transport::Endpoints> topics;
  FibonacciClient client([](const std::string& line) { std::cout << line << std::endl; });
  std::promise<bool> succeeded;
  node.value()->RunOnLoop([&] {
    topics = std::make_unique<transport::Endpoints>(node.value()->node(), "");
    client.Open(*topics);
    client.Send(argc > 1 ? std::atoi(argv[1]) : 5,
                [&](bool success) { succeeded.set_value(success); });
  });
  const bool success = succeeded.get_future().get();
  node.value()->RunOnLoop([&] { topics.reset(); });
  return success ? 0 : 1;
}
