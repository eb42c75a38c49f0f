// Python: mailboxes, nodes, publishers and subscriptions.

#include "musher/python/native/node.hpp"

#include <algorithm>
#include <cmath>

#include "musher/application/refusal.hpp"
#include "musher/base/break_watch.hpp"
#include "musher/python/native/codec.hpp"

namespace musher::python {
namespace {

using transport::Qos;

Qos QosOf(bool reliable, bool latched, int depth) {
  Qos qos;
  qos.reliability = reliable ? Qos::Reliability::kReliable : Qos::Reliability::kBestEffort;
  qos.durability = latched ? Qos::Durability::kTransientLocal : Qos::Durability::kVolatile;
  qos.depth = depth;
  return qos;
}

MailboxPtr MakeMailbox() {
  try {
    return std::make_shared<Mailbox>();
  } catch (const std::system_error& e) {
    Raise("Failure", {kCodeFailed, e.what()});
  }
}

// The next item; None at the end of the time. Raises StopIteration when the mailbox is closed.
// Signals are handled meanwhile.
std::optional<Item> Pop(Mailbox& mailbox, std::optional<double> timeout_s) {
  if (!mailbox.InThisProcess()) RaiseInFork(mailbox.process);
  const auto end = std::chrono::steady_clock::now() + Seconds(timeout_s.value_or(0));
  while (true) {
    Item item;
    int wait_ms = -1;
    if (timeout_s) {
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      wait_ms = static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 1'000'000));
    }
    const Mailbox::Wait result = WithoutGil([&] { return mailbox.Pop(item, wait_ms); });
    if (result == Mailbox::Wait::kItem) return item;
    if (result == Mailbox::Wait::kClosed) throw py::stop_iteration();
    if (result == Mailbox::Wait::kSignal && PyErr_CheckSignals() != 0)
      throw py::error_already_set();
    if (timeout_s && std::chrono::steady_clock::now() >= end) return std::nullopt;
  }
}

// Why nothing is begun by this request: it has waited for the node's Python thread, or may be as
// old as a break in which this process could not run. None: it is fresh.
std::optional<std::string> MayBeLate(const Item& request, const std::string& actuator) {
  const Duration waited = request.Waited();
  if (waited <= BreakWatch::kShortest && !request.after_break) return std::nullopt;
  const Duration oldest = std::max(waited, request.after_break.value_or(Duration{}));
  return Refused<ApplicationRefusal::kMayBeLate>(actuator, ToMilliseconds(oldest) / 1000).message;
}

class Writer : public OnLoop<transport::RawWriter> {
 public:
  Writer(const PyNodePtr& node, const std::string& topic, const std::string& type, const Qos& qos)
      : OnLoop(node, [&](transport::Node& on) {
          return on.MakeRawWriter("rt/" + node->Resolve(topic), type, qos, {});
        }) {}

  void Publish(const Codec& codec, const py::object& message) {
    msg::Bytes bytes = EncodeMessage(codec, message);
    Result<> result;
    Run([&](transport::RawWriter& writer) { result = writer.Write(std::move(bytes)); });
    Check(result);
  }
  int MatchedReaders() {
    int count = 0;
    Run([&](transport::RawWriter& writer) { count = writer.MatchedReaders(); });
    return count;
  }
};

class Reader : public OnLoop<transport::RawReader> {
 public:
  Reader(const PyNodePtr& node, const std::string& topic, const std::string& type, const Qos& qos,
         const MailboxPtr& mailbox, std::int64_t key)
      : OnLoop(node, [&](transport::Node& on) {
          transport::ReaderCallbacks callbacks;
          const auto limit = static_cast<std::size_t>(std::max(qos.depth, 0));
          callbacks.on_sample = [mailbox, key, limit, breaks = node->breaks.get()](
                                    std::span<const std::byte> bytes,
                                    const transport::SampleInfo& info) {
            Item item = ReceivedItem(key, breaks);
            item.token = info.participant.value();
            item.bytes.assign(bytes.begin(), bytes.end());
            mailbox->Push(std::move(item), limit);
          };
          return on.MakeRawReader("rt/" + node->Resolve(topic), type, qos, std::move(callbacks));
        }) {}

  int MatchedWriters() {
    int count = 0;
    Run([&](transport::RawReader& reader) { count = reader.MatchedWriters(); });
    return count;
  }
};

}  // namespace

PyNodePtr MakeNode(const std::string& name, const std::string& name_space,
                   std::optional<int> domain, const std::string& keys, const std::string& identity,
                   const std::string& interface) {
  transport::DdsOptions options;
  options.domain_id = domain;
  options.discovery = transport::DiscoveryTiming::kAtOnce;
  options.node_name = name;
  options.name_space = name_space;
  options.hidden = name.empty();
  if (!interface.empty()) {
    const auto profile = transport::Profile({});
    if (profile && profile.value() != TransportProfile::kLan) {
      Raise("Failure", {kCodeParametersInvalid, "interface " + interface +
                                                    " has no effect: the profile is local; set "
                                                    "MUSHER_TRANSPORT=lan"});
    }
    options.interfaces = {interface};
    options.own_networks_only = true;
  }
  if (!keys.empty()) options.credentials = transport::Credentials{keys, identity};
  auto thread = WithoutGil([&] { return transport::NodeThread::Start(options); });
  if (!thread) Raise("Failure", thread.error());
  const auto node = std::make_shared<PyNode>(std::move(thread).value(), name_space);
  // The tools of ROS 2 list it, and call these services of each node.
  if (!name.empty() && keys.empty()) {
    WithoutGil([&] {
      node->thread->RunOnLoop([&] {
        node->services = std::make_unique<transport::NodeServices>(
            node->thread->node(), node->Resolve(name), std::vector<transport::NodeParameter>());
      });
    });
  }
  return node;
}

msg::Bytes WithEnvelope(const msg::RequestId& id, std::span<const std::byte> message) {
  // The id has 16 bytes, so that what follows stays aligned.
  constexpr std::size_t kHeader = 4;
  msg::Bytes bytes = msg::Encode(id);
  bytes.insert(bytes.end(), message.begin() + kHeader, message.end());
  return bytes;
}

Duration Seconds(double seconds) {
  if (std::isnan(seconds) || seconds < 0) throw py::value_error("a time in seconds is 0 or more");
  constexpr double kMost = 1e9;
  return std::chrono::duration_cast<Duration>(
      std::chrono::duration<double>(std::min(seconds, kMost)));
}

void AddNode(py::module_& native) {
  py::class_<Item>(native, "Item")
      .def_readonly("key", &Item::key)
      .def_readonly("kind", &Item::kind)
      .def_readonly("code", &Item::code)
      .def_readonly("text", &Item::text)
      .def_readonly("token", &Item::token)
      .def("waited_s", [](const Item& item) { return ToSeconds(item.Waited()); })
      .def("may_be_late", &MayBeLate)
      // The message; None if the bytes are not one. `envelope`: an id comes first.
      .def("decode", [](const Item& item, const Codec& codec, bool envelope) -> py::object {
        py::object message = DecodeMessage(codec, item.bytes, envelope);
        return message ? message : py::none();
      });
  py::class_<Mailbox, MailboxPtr>(native, "Mailbox")
      .def(py::init(&MakeMailbox))
      .def("pop", &Pop)
      .def("close", &Mailbox::Close)
      // An item without content, for the thread that takes them: work of this key waits for it.
      .def("wake",
           [](Mailbox& mailbox, std::int64_t key, bool first) {
             Item item;
             item.key = key;
             return first ? mailbox.PushFirst(std::move(item)) : mailbox.Push(std::move(item));
           })
      .def("dropped", &Mailbox::dropped);
  py::class_<PyNode, PyNodePtr>(native, "Node")
      .def(py::init(&MakeNode))
      .def("resolve", &PyNode::Resolve)
      .def("name_space", [](const PyNode& node) { return node.name_space; });
  py::class_<Writer>(native, "Writer")
      .def(py::init([](const PyNodePtr& node, const std::string& topic, const std::string& type,
                       bool reliable, bool latched, int depth) {
        return std::make_unique<Writer>(node, topic, type, QosOf(reliable, latched, depth));
      }))
      .def("publish", &Writer::Publish)
      .def("matched", &Writer::MatchedReaders)
      .def("close", &Writer::Close);
  py::class_<Reader>(native, "Reader")
      .def(py::init([](const PyNodePtr& node, const std::string& topic, const std::string& type,
                       bool reliable, bool latched, int depth, const MailboxPtr& mailbox,
                       std::int64_t key) {
        return std::make_unique<Reader>(node, topic, type, QosOf(reliable, latched, depth), mailbox,
                                        key);
      }))
      .def("matched", &Reader::MatchedWriters)
      .def("close", &Reader::Close);
}

}  // namespace musher::python
