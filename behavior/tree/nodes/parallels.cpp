// Parallel, ParallelAll, Switch2 to Switch6.

#include <algorithm>
#include <optional>

#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {
namespace {

// A count of children; -1 is all of them, -2 all but one.
std::size_t Threshold(int count, std::size_t children) {
  if (count >= 0) return static_cast<std::size_t>(count);
  return static_cast<std::size_t>(std::max<int>(static_cast<int>(children) + count + 1, 0));
}

class Parallel : public Control {
 public:
  explicit Parallel(Setup& setup)
      : success_count_(setup.Input<int>("success_count", -1, "successes that are a success")),
        failure_count_(setup.Input<int>("failure_count", 1, "failures that are a failure")) {}

 private:
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    const std::size_t count = nodes.size();
    const int success_count = success_count_.Get();
    const std::size_t needed = Threshold(success_count, count);
    const std::size_t allowed = Threshold(failure_count_.Get(), count);
    if (needed > count) throw PortError("success_count is more than the number of its children");
    if (allowed > count) throw PortError("failure_count is more than the number of its children");
    done_.resize(count);
    std::size_t skipped = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!done_[i]) Count(nodes[i]->Execute(tick), i, skipped);
      const bool enough =
          successes_ >= needed || (success_count < 0 && successes_ + skipped >= needed);
      if (enough && skipped < count) return End(Status::kSuccess, tick);
      if (count - failures_ < needed || failures_ == allowed) return End(Status::kFailure, tick);
    }
    return skipped == count ? Status::kSkipped : Status::kRunning;
  }
  void OnHalt(Tick& tick) override { End(Status::kIdle, tick); }

  void Count(Status status, std::size_t i, std::size_t& skipped) {
    if (status == Status::kSkipped) ++skipped;
    if (!IsCompleted(status)) return;
    done_[i] = true;
    ++(status == Status::kSuccess ? successes_ : failures_);
  }
  Status End(Status status, Tick& tick) {
    std::ranges::fill(done_, false);
    successes_ = failures_ = 0;
    ResetChildren(tick);
    return status;
  }

  InPort<int> success_count_;
  InPort<int> failure_count_;
  std::vector<char> done_;
  std::size_t successes_ = 0;
  std::size_t failures_ = 0;
};

class ParallelAll : public Control {
 public:
  explicit ParallelAll(Setup& setup)
      : max_failures_(setup.Input<int>("max_failures", 1, "failures that are a failure")) {}

 private:
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    const std::size_t most = Threshold(max_failures_.Get(), nodes.size());
    if (most > nodes.size())
      throw PortError("max_failures is more than the number of its children");
    done_.resize(nodes.size());
    std::size_t skipped = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (done_[i]) continue;
      const Status status = nodes[i]->Execute(tick);
      if (status == Status::kSkipped) ++skipped;
      if (!IsCompleted(status)) continue;
      done_[i] = true;
      ++completed_;
      if (status == Status::kFailure) ++failures_;
    }
    if (skipped == nodes.size()) return Status::kSkipped;
    if (skipped + completed_ < nodes.size()) return Status::kRunning;
    const Status status = failures_ >= most ? Status::kFailure : Status::kSuccess;
    OnHalt(tick);
    return status;
  }
  void OnHalt(Tick& tick) override {
    std::ranges::fill(done_, false);
    completed_ = failures_ = 0;
    ResetChildren(tick);
  }

  InPort<int> max_failures_;
  std::vector<char> done_;
  std::size_t completed_ = 0;
  std::size_t failures_ = 0;
};

class Switch : public Control {
 public:
  Switch(Setup& setup, std::size_t cases)
      : Control(cases + 1, cases + 1),
        enums_(setup.enums()),
        variable_(setup.OptionalInput<std::string>("variable", "what is compared")) {
    for (std::size_t i = 1; i <= cases; ++i) {
      const std::string number = std::to_string(i);
      cases_.push_back(setup.OptionalInput<std::string>("case_" + number,
                                                        "the value that selects child " + number));
    }
  }

 private:
  Status OnTick(Tick& tick) override {
    const std::vector<Node*>& nodes = children();
    const std::size_t match = Match();
    if (running_ && *running_ != match) nodes[*running_]->Reset(tick);
    running_.reset();
    const Status status = nodes[match]->Execute(tick);
    if (status == Status::kRunning) running_ = match;
    if (IsCompleted(status)) ResetChildren(tick);
    return status;
  }
  void OnHalt(Tick& tick) override {
    running_.reset();
    ResetChildren(tick);
  }

  // The case with the text, the enum or the number of the variable; else the last child.
  std::size_t Match() const {
    const std::string* variable = variable_.Find();
    if (variable == nullptr) return cases_.size();
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      const std::string* value = cases_[i].Find();
      if (value != nullptr && IsSame(*variable, *value)) return i;
    }
    return cases_.size();
  }
  bool IsSame(const std::string& a, const std::string& b) const {
    if (a == b) return true;
    const auto x = NumberOf(a);
    if (!x) return false;
    const auto y = NumberOf(b);
    return y && *x == *y;
  }
  std::optional<double> NumberOf(const std::string& text) const {
    const auto known = enums_.find(text);
    if (known != enums_.end()) return known->second;
    double number = 0;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (code != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
  }

  const Enums& enums_;
  InPort<std::string> variable_;
  std::vector<InPort<std::string>> cases_;
  std::optional<std::size_t> running_;
};

}  // namespace

void AddParallels(Factory& factory) {
  static_cast<void>(factory.Add<Parallel>("Parallel"));
  static_cast<void>(factory.Add<ParallelAll>("ParallelAll"));
  for (std::size_t cases = 2; cases <= 6; ++cases) {
    static_cast<void>(factory.Register(
        "Switch" + std::to_string(cases),
        {NodeKind::kControl, false, [cases](Setup& setup) -> std::unique_ptr<Node> {
           return std::make_unique<Switch>(setup, cases);
         }}));
  }
}

}  // namespace musher::tree
