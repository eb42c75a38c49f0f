// Python: clients and servers of services.

#include <map>

#include "musher/python/native/codec.hpp"
#include "musher/python/native/node.hpp"
#include "musher/transport/raw_client.hpp"
#include "musher/transport/raw_server.hpp"

namespace musher::python {
namespace {

class ServiceClient : public OnLoop<transport::RawClient> {
 public:
  // An item goes into `matches` when a server was found or lost.
  ServiceClient(const PyNodePtr& node, const std::string& name, const std::string& type,
                const MailboxPtr& matches)
      : OnLoop(node, [&](transport::Node& on) {
          return transport::RawClient::Make(on, node->Resolve(name), type,
                                            [matches] { matches->PushLatest({}); });
        }) {}

  bool Ready() {
    bool ready = false;
    Run([&](transport::RawClient& client) { ready = client.Ready(); });
    return ready;
  }
  // The reply, or the error (code not 0), goes into the mailbox.
  void Call(const Codec& codec, const py::object& request, double timeout_s,
            const MailboxPtr& mailbox, std::int64_t key) {
    const msg::Bytes body = EncodeMessage(codec, request);
    const Duration timeout = Seconds(timeout_s);
    Run([&](transport::RawClient& client) {
      const msg::RequestId id = client.NextId();
      client.Call(id, WithEnvelope(id, body), timeout,
                  [mailbox, key](Result<std::span<const std::byte>> reply) {
                    Item item;
                    item.key = key;
                    if (reply) {
                      item.bytes.assign(reply.value().begin(), reply.value().end());
                    } else {
                      item.code = reply.error().code;
                      item.text = reply.error().message;
                    }
                    mailbox->Push(std::move(item));
                  });
    });
  }
};

// Replies that are still to be given, by their token; used on the loop.
struct Requests {
  struct Open {
    msg::RequestId id;
    transport::RawServer::Reply reply;
  };
  static constexpr std::size_t kMost = 1000;  // the oldest one is forgotten, its client times out
  std::uint64_t next = 1;
  std::map<std::uint64_t, Open> open;
};

class ServiceServer : public OnLoop<transport::RawServer> {
 public:
  ServiceServer(const PyNodePtr& node, const std::string& name, const std::string& type,
                const MailboxPtr& mailbox, std::int64_t key)
      : ServiceServer(std::make_shared<Requests>(), node, name, type, mailbox, key) {}

  void Reply(std::uint64_t token, const Codec& codec, const py::object& response) {
    const msg::Bytes body = EncodeMessage(codec, response);
    Run([&](transport::RawServer&) {
      const auto open = requests_->open.extract(token);
      if (!open.empty()) open.mapped().reply(WithEnvelope(open.mapped().id, body));
    });
  }
  // The client gets no reply.
  void Forget(std::uint64_t token) {
    Run([&](transport::RawServer&) { requests_->open.erase(token); });
  }

 private:
  ServiceServer(std::shared_ptr<Requests> requests, const PyNodePtr& node, const std::string& name,
                const std::string& type, const MailboxPtr& mailbox, std::int64_t key)
      : OnLoop(node,
               [&](transport::Node& on) {
                 auto on_request = [requests, mailbox, key, breaks = node->breaks.get()](
                                       const msg::RequestId& id, std::span<const std::byte> bytes,
                                       transport::RawServer::Reply reply,
                                       transport::ParticipantId) {
                   if (requests->open.size() >= Requests::kMost)
                     requests->open.erase(requests->open.begin());
                   Item item = ReceivedItem(key, breaks);
                   item.token = requests->next++;
                   item.bytes.assign(bytes.begin(), bytes.end());
                   requests->open[item.token] = {id, std::move(reply)};
                   mailbox->Push(std::move(item));
                   return true;
                 };
                 return transport::RawServer::Make(on, node->Resolve(name), type,
                                                   std::move(on_request));
               }),
        requests_(std::move(requests)) {}

  const std::shared_ptr<Requests> requests_;
};

}  // namespace

void AddServices(py::module_& native) {
  py::class_<ServiceClient>(native, "ServiceClient")
      .def(py::init<const PyNodePtr&, const std::string&, const std::string&, const MailboxPtr&>())
      .def("ready", &ServiceClient::Ready)
      .def("call", &ServiceClient::Call)
      .def("close", &ServiceClient::Close);
  py::class_<ServiceServer>(native, "ServiceServer")
      .def(py::init<const PyNodePtr&, const std::string&, const std::string&, const MailboxPtr&,
                    std::int64_t>())
      .def("reply", &ServiceServer::Reply)
      .def("forget", &ServiceServer::Forget)
      .def("close", &ServiceServer::Close);
}

}  // namespace musher::python
