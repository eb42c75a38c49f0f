// The leaves: AlwaysSuccess, AlwaysFailure, Script, ScriptCondition, SetBlackboard,
// UnsetBlackboard, Sleep, WasEntryUpdated, and the test node.

#include <optional>

#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {
namespace {

template <Status kResult>
class Always : public Action {
  Status Do(const Tick&) override { return kResult; }
};

class ScriptNode : public Action {
 public:
  explicit ScriptNode(Setup& setup) : script_(setup.ScriptOf("code", false)) {}

 private:
  Status Do(const Tick&) override {
    script_->Run();
    return Status::kSuccess;
  }
  std::optional<Script> script_;
};

class ScriptCondition : public Condition {
 public:
  explicit ScriptCondition(Setup& setup) : script_(setup.ScriptOf("code", true)) {}

 private:
  Status Evaluate(const Tick&) override {
    return script_->True() ? Status::kSuccess : Status::kFailure;
  }
  std::optional<Script> script_;
};

class SetBlackboard : public Action {
 public:
  explicit SetBlackboard(Setup& setup) {
    const auto value =
        setup.Connect({"value", Direction::kIn, nullptr, true, "a text, or the entry to copy"});
    from_ = value.entry;
    if (value.text != nullptr) text_ = value.text->value;
    to_ = setup.Key("output_key", "the entry to set");
  }

 private:
  Status Do(const Tick&) override {
    if (from_ != nullptr && from_->value.empty()) internal::FailRead("value", from_);
    const Result<> set = from_ == nullptr ? to_->AssignText(text_) : to_->Assign(from_->value);
    if (!set) internal::FailWrite("output_key", *to_, set.error());
    return Status::kSuccess;
  }

  const Entry* from_ = nullptr;
  Entry* to_ = nullptr;
  std::string text_;
};

class UnsetBlackboard : public Action {
 public:
  explicit UnsetBlackboard(Setup& setup) : key_(setup.Key("key", "the entry to clear")) {}

 private:
  Status Do(const Tick&) override {
    key_->value.Clear();
    key_->declared = false;
    return Status::kSuccess;
  }
  Entry* key_;
};

class Sleep : public StatefulAction {
 public:
  explicit Sleep(Setup& setup) : time_ms_(setup.Input<unsigned>("msec", "ms")) {}

 private:
  Status OnStart(const Tick& tick) override {
    until_ = tick.now + Milliseconds(time_ms_.Get());
    return OnRunning(tick);
  }
  Status OnRunning(const Tick& tick) override {
    return tick.now >= until_ ? Status::kSuccess : Status::kRunning;
  }

  InPort<unsigned> time_ms_;
  Time until_{};
};

class WasEntryUpdated : public Action {
 public:
  explicit WasEntryUpdated(Setup& setup) : entry_(setup.Key("entry", "the entry to look at")) {}

 private:
  Status Do(const Tick&) override {
    const bool updated = entry_->sequence != seen_;
    seen_ = entry_->sequence;
    return updated ? Status::kSuccess : Status::kFailure;
  }
  Entry* entry_;
  std::uint64_t seen_ = 0;
};

class TestNode : public StatefulAction {
 public:
  TestNode(Setup& setup, const TestNodeConfig& config) : config_(config) {
    success_ = Parse(setup, config.success_script);
    failure_ = Parse(setup, config.failure_script);
    post_ = Parse(setup, config.post_script);
  }

 private:
  static std::optional<Script> Parse(Setup& setup, const std::string& text) {
    if (text.empty()) return std::nullopt;
    std::vector<Script::Finding> findings;
    Script script = Script::Parse(text, setup.board(), setup.enums(), false, findings);
    bool failed = false;
    for (const Script::Finding& finding : findings) {
      failed |= finding.error;
      setup.Report("", Severity::kError, "script of its test node: " + finding.what);
    }
    if (failed) return std::nullopt;
    return script;
  }
  Status OnStart(const Tick& tick) override {
    since_ = tick.now;
    return OnRunning(tick);
  }
  Status OnRunning(const Tick& tick) override {
    if (tick.now - since_ < config_.delay) return Status::kRunning;
    const Status result = config_.result_of ? config_.result_of(tick) : config_.result;
    if (result == Status::kRunning) return result;
    if (result == Status::kSuccess && success_) success_->Run();
    if (result == Status::kFailure && failure_) failure_->Run();
    if (post_) post_->Run();
    return result;
  }

  const TestNodeConfig config_;
  std::optional<Script> success_;
  std::optional<Script> failure_;
  std::optional<Script> post_;
  Time since_{};
};

}  // namespace

std::unique_ptr<Node> MakeTestNode(Setup& setup, const TestNodeConfig& config) {
  return std::make_unique<TestNode>(setup, config);
}

void AddLeaves(Factory& factory) {
  static_cast<void>(factory.Add<Always<Status::kSuccess>>("AlwaysSuccess"));
  static_cast<void>(factory.Add<Always<Status::kFailure>>("AlwaysFailure"));
  static_cast<void>(factory.Add<ScriptNode>("Script"));
  static_cast<void>(factory.Add<ScriptCondition>("ScriptCondition"));
  static_cast<void>(factory.Add<SetBlackboard>("SetBlackboard"));
  static_cast<void>(factory.Add<UnsetBlackboard>("UnsetBlackboard"));
  static_cast<void>(factory.Add<Sleep>("Sleep"));
  static_cast<void>(factory.Add<WasEntryUpdated>("WasEntryUpdated"));
  static_cast<void>(factory.Add<WasEntryUpdated>("EntryUpdated"));
}

}  // namespace musher::tree
