// The other process of a test: serves and publishes until it is killed.
//
//   contract_peer <domain> <lease_ms> <name>     service <name>/set_state answers with the target,
//                                                topic <name>/status is latched, <name>/image is
//                                                sent back on <name>/image_back

#include <cstdio>
#include <cstdlib>
#include <string>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"

using namespace musher;             // NOLINT(google-build-using-namespace): a main program
using namespace musher::transport;  // NOLINT(google-build-using-namespace)

int main(int argc, char** argv) {
  if (argc != 4) return EXIT_FAILURE;
  const std::string name = argv[3];
  LinuxEventLoop loop;
  DdsOptions options;
  options.domain_id = std::atoi(argv[1]);
  options.lease = Milliseconds(std::atoi(argv[2]));
  const auto node = MakeDdsNode(loop, options);
  if (!node) {
    std::fprintf(stderr, "%s\n", node.error().message.c_str());
    return EXIT_FAILURE;
  }
  const auto server = MakeServer<msg::SetState>(
      *node.value(), name + "/set_state", [](const msg::SetState::Request& request, auto reply) {
        msg::SetState::Response response;
        response.outcome = request.target;
        reply(response);
      });
  const auto status = MakePublisher<msg::String>(*node.value(), name + "/status", kLatchedQos);
  const auto back = MakePublisher<msg::String>(*node.value(), name + "/image_back");
  const auto image = MakeSubscription<msg::String>(
      *node.value(), name + "/image", [&](const msg::String& message, const SampleInfo&) {
        if (!back.value()->Publish(message)) std::abort();
      });
  if (!server || !status || !image || !status.value()->Publish({"up"})) return EXIT_FAILURE;
  loop.Run();
  return EXIT_SUCCESS;
}
