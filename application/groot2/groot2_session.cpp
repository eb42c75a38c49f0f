#include "musher/application/groot2/groot2_session.hpp"

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

namespace musher::groot2 {
namespace {

using Json = nlohmann::json;

constexpr int kHold = 0;  // modes
constexpr int kReplace = 1;
constexpr const char* kTwoParts = "must be 2 parts message";
constexpr const char* kNoNode = "Node ID not found";

Error Refused(const std::string& why) {
  return {kCodeParametersInvalid, why};
}

// A field of a request. Throws Json::exception, which Change() catches.
template <class T>
T Field(const Json& json, const char* key) {
  return json.at(key).get<T>();
}

constexpr int kBefore = 0;  // positions
constexpr int kAfter = 1;

bool IsAfter(const Json& json) {
  return Field<int>(json, "position") == kAfter;
}

Result<tree::NodeId> NodeOf(const Json& json, const tree::Tree& tree) {
  if (Field<int>(json, "position") != kBefore && !IsAfter(json)) {
    return Refused("a position is 0 or 1");
  }
  const auto uid = Field<std::int64_t>(json, "uid");
  if (uid < 1 || uid > static_cast<std::int64_t>(tree.size())) return Refused(kNoNode);
  return static_cast<tree::NodeId>(uid - 1);
}

Result<tree::Status> StatusFrom(const Json& json) {
  const auto name = Field<std::string>(json, "desired_status");
  for (const auto status :
       {tree::Status::kSuccess, tree::Status::kFailure, tree::Status::kSkipped}) {
    if (tree::Name(status) == name) return status;
  }
  return Refused("a desired_status is SUCCESS, FAILURE or SKIPPED");
}

Result<tree::Hook> HookFrom(const Json& json, const tree::Tree& tree) {
  const Result<tree::NodeId> node = NodeOf(json, tree);
  if (!node) return node.error();
  const Result<tree::Status> status = StatusFrom(json);
  if (!status) return status.error();
  const int mode = Field<int>(json, "mode");
  if (mode != kHold && mode != kReplace) return Refused("a mode is 0 or 1");
  return tree::Hook{.node = node.value(),
                    .enabled = Field<bool>(json, "enabled"),
                    .holds = mode == kHold,
                    .once = Field<bool>(json, "once"),
                    .instead = status.value(),
                    .after = IsAfter(json)};
}

// All of them or none.
Result<std::vector<tree::Hook>> HooksFrom(const Json& json, const tree::Tree& tree) {
  std::vector<tree::Hook> all;
  for (const Json& each : json.is_array() ? json : Json::array({json})) {
    const Result<tree::Hook> hook = HookFrom(each, tree);
    if (!hook) return hook.error();
    all.push_back(hook.value());
  }
  return all;
}

Result<> Release(const Json& json, tree::NodeId node, tree::Hooks& hooks) {
  const Result<tree::Status> status = StatusFrom(json);
  if (!status) return status.error();
  const bool once = Field<bool>(json, "remove_when_done");
  if (!hooks.Has(node, IsAfter(json))) return Refused(kNoNode);
  if (hooks.Release(node, status.value(), once, IsAfter(json))) return Ok();
  return Refused("the node is not held");
}

// By a request R or U.
Result<> ChangeHook(char type, const Json& json, const tree::Tree& tree, tree::Hooks& hooks) {
  const Result<tree::NodeId> node = NodeOf(json, tree);
  if (!node) return node.error();
  if (type == 'U') return Release(json, node.value(), hooks);
  return hooks.Remove(node.value(), IsAfter(json)) ? Ok() : Result<>(Refused(kNoNode));
}

void AppendBytes(std::string& text, std::uint64_t number, int bytes) {
  for (int i = 0; i < bytes; ++i) text += static_cast<char>((number >> (8 * i)) & 0xff);
}

}  // namespace

class Session::Transitions : public tree::ChangeListener {
 public:
  void OnChange(const tree::Change& change) override {
    if (stopped_) return;
    const auto since = std::chrono::steady_clock::now() - start_;
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(since).count();
    made_.push_back({static_cast<std::uint64_t>(us), change.node, change.to});
    if (made_.size() > kMostTransitions) made_.pop_front();
  }
  void Stop() { stopped_ = true; }
  std::string Take() {
    std::string bytes;
    bytes.reserve(9 * made_.size());
    for (const Made& each : std::exchange(made_, {})) {
      AppendBytes(bytes, each.us, 6);
      AppendBytes(bytes, each.node + 1, 2);
      bytes += static_cast<char>(each.status);
    }
    return bytes;
  }

 private:
  struct Made {
    std::uint64_t us = 0;
    tree::NodeId node = 0;
    tree::Status status = tree::Status::kIdle;
  };

  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::deque<Made> made_;
  bool stopped_ = false;
};

Session::Session(std::function<TreeView()> view, const tree::Factory& factory, Options options)
    : view_(std::move(view)),
      factory_(factory),
      options_(std::move(options)),
      hooks_(MakeHooks()) {}

std::shared_ptr<tree::Hooks> Session::MakeHooks() {
  return std::make_shared<tree::Hooks>([this](tree::NodeId node) {
    if (!options_.publish) return;
    std::string header = {kProtocol, 'N'};
    AppendBytes(header, random_(), 4);
    options_.publish({header, std::to_string(node + 1)});
  });
}

void Session::Follow(const TreeView& view) {
  if (view.revision == revision_) return;
  revision_ = view.revision;
  for (char& byte : id_) byte = static_cast<char>(random_());  // so that Groot2 reads it again
  hooks_ = MakeHooks();
  hook_owners_.clear();
  if (view.tree != nullptr && transitions_ != nullptr) view.tree->Listen(transitions_);
}

void Session::Forget(const std::string& client) {
  if (recorder_ == client) transitions_ = nullptr;
  Follow(view_());
  bool acted = false;
  std::erase_if(hook_owners_, [&](const auto& owned) {
    const auto& [at, owner] = owned;
    if (owner != client) return false;
    // Also one that has acted before, or would act next: nothing is to move because of its end.
    const bool matters = options_.on_lost ? hooks_->IsEnabled(at.first, at.second)
                                          : hooks_->Acts(at.first, at.second);
    if (matters && !options_.on_lost) return false;
    acted |= matters;
    hooks_->Remove(at.first, at.second);
    return true;
  });
  if (acted && options_.on_lost) options_.on_lost();
}

Parts Session::Reply(const std::string& client, const Parts& request) {
  const TreeView view = view_();
  Follow(view);
  Parts reply = groot2::Reply(request, view, factory_, id_);
  if (reply.size() != 1) return reply;
  try {
    const Result<Parts> content = Change(client, request, view);
    if (!content) return {"error", content.error().message};
    reply.insert(reply.end(), content.value().begin(), content.value().end());
    return reply;
  } catch (const Json::exception& wrong) {
    return {"error", wrong.what()};
  }
}

// The further parts of the reply.
Result<Parts> Session::Change(const std::string& client, const Parts& request,
                              const TreeView& view) {
  const char type = request[0][1];
  if (type == 'D') return Parts{Dump()};
  if (type == 'A') hooks_->Clear();
  if (type == 'X') hooks_->DisableAll();
  if (type == 'A' || type == 'X') return Parts();
  if (view.tree == nullptr) return Refused("no tree is loaded");
  if (type == 't') return Parts{transitions_ == nullptr ? "" : transitions_->Take()};
  if (request.size() != 2) return Refused(kTwoParts);
  if (type == 'r') return Record(client, request[1], view);
  if (!options_.hooks) {
    return Refused(
        "hooks hold and replace nodes of a robot: its configuration does not allow them "
        "(ServeOptions::hooks, or groot2_hooks of its program)");
  }
  const Json json = Json::parse(request[1]);
  if (type == 'I') {
    const auto hooks = HooksFrom(json, *view.tree);
    if (!hooks) return hooks.error();
    for (const tree::Hook& hook : hooks.value()) {
      hooks_->Set(hook);
      hook_owners_[{hook.node, hook.after}] = client;
    }
  } else if (const Result<> done = ChangeHook(type, json, *view.tree, *hooks_); !done) {
    return done.error();
  }
  view.tree->Attach(hooks_);
  return Parts();
}

Result<Parts> Session::Record(const std::string& client, const std::string& command,
                              const TreeView& view) {
  if (command == "stop") {
    if (transitions_ != nullptr) transitions_->Stop();
    return Parts();
  }
  if (command != "start") return Refused("expected start or stop");
  transitions_ = std::make_shared<Transitions>();
  recorder_ = client;
  view.tree->Listen(transitions_);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(now).count();
  return Parts{std::to_string(us)};
}

std::string Session::Dump() const {
  Json hooks = Json::array();
  hooks_->ForEach([&](const tree::Hook& hook) {
    hooks.push_back({{"enabled", hook.enabled},
                     {"uid", hook.node + 1},
                     {"mode", hook.holds ? kHold : kReplace},
                     {"once", hook.once},
                     {"desired_status", tree::Name(hook.instead)},
                     {"position", hook.after ? kAfter : kBefore}});
  });
  return hooks.dump();
}

}  // namespace musher::groot2
