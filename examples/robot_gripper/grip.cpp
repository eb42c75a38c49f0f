// grip close | grip open: commands the gripper from the command line.

#include <chrono>
#include <future>
#include <iostream>
#include <memory>
#include <string>

#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

int main(int argc, char** argv) {
  const std::string command = argc == 2 ? argv[1] : "";
  if (command != "close" && command != "open") {
    std::cerr << "usage: grip close|open\n";
    return 2;
  }
  const auto node = musher::transport::NodeThread::Start();
  if (!node) {
    std::cerr << "grip: " << node.error().message << "\n";
    return 1;
  }
  using SetBool = musher::msg::SetBool;
  std::unique_ptr<musher::transport::Client<SetBool>> gripper;
  std::promise<musher::Result<SetBool::Response>> promise;
  node.value()->RunOnLoop([&] {
    gripper = musher::transport::MakeClient<SetBool>(node.value()->node(), "gripper/close").value();
    gripper->Call({command == "close"}, std::chrono::seconds(10),
                  [&](auto answer) { promise.set_value(std::move(answer)); });
  });
  const auto answer = promise.get_future().get();
  node.value()->RunOnLoop([&] { gripper.reset(); });
  const bool done = answer && answer.value().success;
  std::cout << (done     ? command == "close" ? "the gripper is closed" : "the gripper is open"
                : answer ? "refused: " + answer.value().message
                         : "no answer: " + answer.error().message)
            << std::endl;
  return done ? 0 : 1;
}
