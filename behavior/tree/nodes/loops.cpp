// The decorators that look at blackboards: LoopInt and its like, SkipUnlessUpdated,
// WaitValueUpdate.

#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {
namespace {

// Takes value after value from the queue and ticks its child for each. The queue is a fixed text,
// a text or a vector of the blackboard, which stays as it is, or a SharedQueue, which is emptied.
template <class T>
class Loop : public Decorator {
 public:
  explicit Loop(Setup& setup)
      : if_empty_(setup.Input<Status>("if_empty", Status::kSuccess, "the result at the end")),
        value_(setup.Output<T>("value", "of the present round")) {
    const auto queue = setup.Connect(
        {"queue", Direction::kIn, nullptr, true, "values with ';' between them, or an entry"});
    entry_ = queue.entry;
    if (queue.text == nullptr) return;
    auto values = Convert<std::vector<T>>::FromText(queue.text->value);
    if (values) {
      fixed_ = std::move(values).value();
    } else {
      setup.Report("queue", Severity::kError, "port 'queue': " + values.error().message);
    }
  }

 private:
  Status OnTick(Tick& tick) override {
    if (!goes_on_) {
      if (!running()) at_ = 0;
      if (!Next()) return if_empty_.Get();
    }
    const Status status = TickChild(tick);
    goes_on_ = status == Status::kRunning;
    return status == Status::kFailure ? status : Status::kRunning;
  }
  void OnHalt(Tick& tick) override {
    goes_on_ = false;
    Decorator::OnHalt(tick);
  }

  // Sets the next value. False: there is none.
  bool Next() {
    if (entry_ == nullptr) return NextOf(fixed_);
    if (auto* shared = entry_->value.template As<SharedQueue<T>>()) {
      if (*shared == nullptr || (*shared)->empty()) return false;
      value_.Set((*shared)->front());
      (*shared)->pop_front();
      return true;
    }
    if (const auto* values = entry_->value.template As<std::vector<T>>()) return NextOf(*values);
    if (at_ == 0) {
      Value made;
      const Result<> read = made.SetAs(*TypeOf<std::vector<T>>(), entry_->value);
      if (!read) internal::FailRead("queue", entry_);
      fixed_ = *made.template As<std::vector<T>>();
    }
    return NextOf(fixed_);
  }
  bool NextOf(const std::vector<T>& values) {
    if (at_ >= values.size()) return false;
    value_.Set(values[at_++]);
    return true;
  }

  InPort<Status> if_empty_;
  OutPort<T> value_;
  Entry* entry_ = nullptr;
  std::vector<T> fixed_;
  std::size_t at_ = 0;
  bool goes_on_ = false;  // the child was RUNNING, or held by a hook
};

// Ticks its child once for each time that the entry was set.
class WhenUpdated : public Decorator {
 public:
  WhenUpdated(Setup& setup, Status otherwise)
      : entry_(setup.Key("entry", "the entry to look at")), otherwise_(otherwise) {}

 private:
  Status OnTick(Tick& tick) override {
    if (!goes_on_) {
      const bool updated = entry_->sequence != seen_;
      seen_ = entry_->sequence;
      if (!updated) return otherwise_;
    }
    const Status status = TickChild(tick);
    goes_on_ = status == Status::kRunning;
    return status;
  }
  void OnHalt(Tick& tick) override {
    goes_on_ = false;
    Decorator::OnHalt(tick);
  }

  Entry* entry_;
  const Status otherwise_;
  std::uint64_t seen_ = 0;
  bool goes_on_ = false;  // as in Loop
};

template <class T>
void AddLoop(Factory& factory, std::string_view name) {
  static_cast<void>(factory.Register(
      name, {NodeKind::kDecorator, true, [](Setup& setup) -> std::unique_ptr<Node> {
               return std::make_unique<Loop<T>>(setup);
             }}));
}

}  // namespace

void AddLoops(Factory& factory) {
  AddLoop<int>(factory, "LoopInt");
  AddLoop<bool>(factory, "LoopBool");
  AddLoop<double>(factory, "LoopDouble");
  AddLoop<std::string>(factory, "LoopString");
  static_cast<void>(factory.Add<WhenUpdated>("SkipUnlessUpdated", Status::kSkipped));
  static_cast<void>(factory.Register(
      "WaitValueUpdate", {NodeKind::kDecorator, true, [](Setup& setup) -> std::unique_ptr<Node> {
                            return std::make_unique<WhenUpdated>(setup, Status::kRunning);
                          }}));
}

}  // namespace musher::tree
