// Python: clients and servers of actions.

#include <map>

#include "musher/python/native/codec.hpp"
#include "musher/python/native/node.hpp"
#include "musher/transport/raw_action_client.hpp"
#include "musher/transport/raw_action_server.hpp"

namespace musher::python {
namespace {

using transport::RawActionClient;
using transport::RawActionServer;
using transport::RawGoal;
using transport::RawGoalPtr;

transport::ActionTypes TypesOf(
    const std::string& type) {  // "example_interfaces::action::dds_::Fibonacci_"
  return {type + "SendGoal_", type + "GetResult_", type + "FeedbackMessage_"};
}

// The kinds of items; musher/_actions.py has the same.
enum ClientKind : int { kAccepted, kState, kFeedback, kEnd, kCancelReply };
enum ServerKind : int { kStart, kCancel };

class ActionClient : public OnLoop<RawActionClient> {
 public:
  ActionClient(const PyNodePtr& node, const std::string& name, const std::string& type)
      : OnLoop(node, [&](transport::Node& on) {
          return RawActionClient::Make(on, node->Resolve(name), TypesOf(type), {});
        }) {}

  bool Ready() {
    bool ready = false;
    Run([&](RawActionClient& client) { ready = client.Ready(); });
    return ready;
  }
  // Returns the goal's id, 16 bytes.
  py::bytes Send(const Codec& codec, const py::object& goal, double timeout_s,
                 const MailboxPtr& mailbox, std::int64_t key) {
    const msg::Bytes body = EncodeMessage(codec, goal);
    const Duration timeout = Seconds(timeout_s);
    transport::GoalId goal_id{};
    Run([&](RawActionClient& client) {
      const msg::RequestId id = client.NextId();
      goal_id = RawActionClient::GoalIdOf(id);
      // A goal id has 16 bytes, too: the goal behind it stays aligned.
      msg::Bytes request = msg::Encode(id);
      const auto id_bytes = std::as_bytes(std::span(goal_id));
      request.insert(request.end(), id_bytes.begin(), id_bytes.end());
      request.insert(request.end(), body.begin() + 4, body.end());
      client.SendGoal(id, std::move(request), timeout, EventsTo(mailbox, key));
    });
    return {reinterpret_cast<const char*>(goal_id.data()), goal_id.size()};
  }
  void Cancel(const std::string& id, double timeout_s, const MailboxPtr& mailbox,
              std::int64_t key) {
    msg::GoalInfo info;
    if (id.size() != info.goal_id.uuid.size()) throw py::value_error("a goal's id has 16 bytes");
    std::copy(id.begin(), id.end(), info.goal_id.uuid.begin());
    const Duration timeout = Seconds(timeout_s);
    Run([&](RawActionClient& client) {
      client.Cancel(info, timeout, [mailbox, key](const Result<msg::CancelGoal::Response>& reply) {
        Item item;
        item.key = key;
        item.kind = kCancelReply;
        item.code = reply ? reply.value().return_code : reply.error().code;
        if (!reply) item.text = reply.error().message;
        mailbox->Push(std::move(item));
      });
    });
  }

 private:
  static RawActionClient::Events EventsTo(const MailboxPtr& mailbox, std::int64_t key) {
    const auto push = [mailbox, key](ClientKind kind, std::int32_t code,
                                     std::span<const std::byte> bytes, const std::string& text) {
      Item item;
      item.key = key;
      item.kind = kind;
      item.code = code;
      item.text = text;
      item.bytes.assign(bytes.begin(), bytes.end());
      mailbox->Push(std::move(item));
    };
    RawActionClient::Events events;
    events.on_accepted = [push] { push(kAccepted, 0, {}, ""); };
    events.on_state = [push](transport::GoalState state) {
      push(kState, static_cast<std::int32_t>(state), {}, "");
    };
    events.on_feedback = [push](std::span<const std::byte> bytes) {
      push(kFeedback, 0, bytes, "");
    };
    events.on_end = [push](transport::GoalEnd end, std::span<const std::byte> bytes,
                           const std::string& reason) {
      push(kEnd, static_cast<std::int32_t>(end), bytes, reason);
    };
    return events;
  }
};

struct ServedGoal : RawGoal {
  std::uint64_t token = 0;
  msg::Bytes request;
};

// The goals that have not ended, by their token; used on the loop.
struct Goals {
  transport::Node* node = nullptr;
  std::uint64_t next = 1;
  std::map<std::uint64_t, RawGoalPtr> open;
};

class ActionServer : public OnLoop<RawActionServer> {
 public:
  // `no_result`, `not_started`: a GetResult.Response each, see RawActionServer::Defaults. Each goal
  // is accepted: the loop does not wait for Python.
  ActionServer(const PyNodePtr& node, const std::string& name, const std::string& type,
               const Codec& codec, const py::object& no_result, const py::object& not_started,
               const MailboxPtr& mailbox, std::int64_t key)
      : ActionServer(std::make_shared<Goals>(),
                     {WithEnvelope({}, EncodeMessage(codec, no_result)),
                      WithEnvelope({}, EncodeMessage(codec, not_started))},
                     node, name, type, mailbox, key) {}
  ~ActionServer() { CloseGoals(); }

  bool Execute(std::uint64_t token) {
    return OfGoal(token, [](RawGoal& goal) { return goal.Execute(); });
  }
  bool Feedback(std::uint64_t token, const Codec& codec, const py::object& message) {
    msg::Bytes bytes = EncodeMessage(codec, message);
    return OfGoal(token, [&](RawGoal& goal) { return goal.PublishFeedback(std::move(bytes)); });
  }
  bool End(std::uint64_t token, int state, const Codec& codec, const py::object& response) {
    const msg::Bytes body = EncodeMessage(codec, response);
    bool ended = false;
    Run([&](RawActionServer&) {
      const auto goal = goals_->open.extract(token);
      if (goal.empty()) return;
      ended = goal.mapped()->End(static_cast<transport::GoalState>(state), WithEnvelope({}, body));
    });
    return ended;
  }
  // What the client of a goal says of itself; empty: nothing, or the goal has ended.
  std::string ClientOf(std::uint64_t token) {
    std::string name;
    Run([&](RawActionServer&) {
      const auto goal = goals_->open.find(token);
      if (goal != goals_->open.end()) {
        name = transport::NameOf(*goals_->node, goal->second->caller());
      }
    });
    return name;
  }
  void CloseGoals() {
    Close();
    goals_->open.clear();
  }

 private:
  ActionServer(std::shared_ptr<Goals> goals, RawActionServer::Defaults defaults,
               const PyNodePtr& node, const std::string& name, const std::string& type,
               const MailboxPtr& mailbox, std::int64_t key)
      : OnLoop(node,
               [&](transport::Node& on) {
                 goals->node = &on;
                 return RawActionServer::Make(
                     on, node->Resolve(name), TypesOf(type), std::move(defaults),
                     HandlersOf(goals, mailbox, key, node->breaks.get()), {});
               }),
        goals_(std::move(goals)) {}

  template <class Work>
  bool OfGoal(std::uint64_t token, const Work& work) {
    bool done = false;
    Run([&](RawActionServer&) {
      const auto goal = goals_->open.find(token);
      done = goal != goals_->open.end() && work(*goal->second);
    });
    return done;
  }
  static RawActionServer::Handlers HandlersOf(const std::shared_ptr<Goals>& goals,
                                              const MailboxPtr& mailbox, std::int64_t key,
                                              transport::LoopBreaks* breaks) {
    const auto push = [mailbox, key, breaks](ServerKind kind, const ServedGoal& goal) {
      Item item = ReceivedItem(key, breaks);
      item.kind = kind;
      item.token = goal.token;
      if (kind == kStart) item.bytes = goal.request;
      mailbox->Push(std::move(item));
    };
    RawActionServer::Handlers handlers;
    handlers.accept = [goals](std::span<const std::byte> bytes,
                              transport::ParticipantId) -> std::optional<RawGoalPtr> {
      auto goal = std::make_shared<ServedGoal>();
      goal->token = goals->next++;
      goal->request.assign(bytes.begin(), bytes.end());
      return RawGoalPtr(std::move(goal));
    };
    handlers.start = [goals, push](const RawGoalPtr& goal) {
      const auto& served = static_cast<const ServedGoal&>(*goal);
      goals->open[served.token] = goal;
      push(kStart, served);
    };
    handlers.may_cancel = [](const RawGoalPtr&) { return true; };
    handlers.cancel = [push](const RawGoalPtr& goal) {
      push(kCancel, static_cast<const ServedGoal&>(*goal));
    };
    return handlers;
  }

  const std::shared_ptr<Goals> goals_;
};

}  // namespace

void AddActions(py::module_& native) {
  py::class_<ActionClient>(native, "ActionClient")
      .def(py::init<const PyNodePtr&, const std::string&, const std::string&>())
      .def("ready", &ActionClient::Ready)
      .def("send", &ActionClient::Send)
      .def("cancel", [](ActionClient& client, const py::bytes& id, double timeout_s,
                        const MailboxPtr& mailbox,
                        std::int64_t key) { client.Cancel(id, timeout_s, mailbox, key); })
      .def("close", &ActionClient::Close);
  py::class_<ActionServer>(native, "ActionServer")
      .def(py::init<const PyNodePtr&, const std::string&, const std::string&, const Codec&,
                    const py::object&, const py::object&, const MailboxPtr&, std::int64_t>())
      .def("execute", &ActionServer::Execute)
      .def("feedback", &ActionServer::Feedback)
      .def("end", &ActionServer::End)
      .def("client_of", &ActionServer::ClientOf)
      .def("close", &ActionServer::CloseGoals);
}

}  // namespace musher::python
