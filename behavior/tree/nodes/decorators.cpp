// The decorators, apart from those that look at blackboards (loops.cpp).

#include <optional>

#include "musher/behavior/tree/factory.hpp"

namespace musher::tree {
namespace {

class Inverter : public Decorator {
  Status OnTick(Tick& tick) override {
    const Status status = TickChild(tick);
    if (status == Status::kSuccess) return Status::kFailure;
    return status == Status::kFailure ? Status::kSuccess : status;
  }
};

template <Status kResult>
class Force : public Decorator {
  Status OnTick(Tick& tick) override {
    const Status status = TickChild(tick);
    return IsCompleted(status) ? kResult : status;
  }
};

class KeepRunningUntilFailure : public Decorator {
  Status OnTick(Tick& tick) override {
    return TickChild(tick) == Status::kFailure ? Status::kFailure : Status::kRunning;
  }
};

// Repeat and RetryUntilSuccessful: ticks its child again while it returns `kAgain`. Gives the tree
// a turn between two attempts, unless the last one was running before. The number of attempts is
// read once in each tick: the child may change it.
template <Status kAgain>
class Again : public Decorator {
 public:
  Again(Setup& setup, std::string_view port) : times_(setup.Input<int>(port, "-1: no limit")) {}

 private:
  Status OnTick(Tick& tick) override {
    const int times = times_.Get();
    const auto may_go_on = [&] { return times == -1 || done_ < times; };
    while (may_go_on()) {
      const bool fresh = !child().running();
      const Status status = TickChild(tick);
      if (status == Status::kRunning) return status;
      if (status == Status::kSkipped) {
        child().Reset(tick);
        return status;
      }
      if (status != kAgain) {
        done_ = 0;
        return status;
      }
      ++done_;
      if (fresh && may_go_on()) {
        tick.woken = true;
        return Status::kRunning;
      }
    }
    done_ = 0;
    child().Reset(tick);  // it runs where the number has become smaller
    return kAgain;
  }
  void OnHalt(Tick& tick) override {
    done_ = 0;
    child().Reset(tick);
  }

  InPort<int> times_;
  int done_ = 0;
};

class Repeat : public Again<Status::kSuccess> {
 public:
  explicit Repeat(Setup& setup) : Again(setup, "num_cycles") {}
};
class RetryUntilSuccessful : public Again<Status::kFailure> {
 public:
  explicit RetryUntilSuccessful(Setup& setup) : Again(setup, "num_attempts") {}
};

class Delay : public Decorator {
 public:
  explicit Delay(Setup& setup) : delay_ms_(setup.Input<unsigned>("delay_msec", "ms")) {}

 private:
  Status OnTick(Tick& tick) override {
    if (!until_) until_ = tick.now + Milliseconds(delay_ms_.Get());
    if (tick.now < *until_) return Status::kRunning;
    const Status status = TickChild(tick);
    if (status != Status::kRunning) until_.reset();
    return status;
  }
  void OnHalt(Tick& tick) override {
    until_.reset();
    child().Reset(tick);
  }

  InPort<unsigned> delay_ms_;  // is read at the start, like the limit of a Timeout
  std::optional<Time> until_;
};

// A child that ends in the tick at which the time is over has ended in time only if that was its
// first one; else it is halted without a further tick.
class Timeout : public Decorator {
 public:
  explicit Timeout(Setup& setup) : limit_ms_(setup.Input<unsigned>("msec", "ms; 0: no limit")) {}

 private:
  Status OnTick(Tick& tick) override {
    if (!since_) {
      limit_ = Milliseconds(limit_ms_.Get());
      since_ = tick.now;
    }
    if (limit_ > Duration::zero() && tick.now - *since_ >= limit_) {
      since_.reset();
      child().Reset(tick);
      return Status::kFailure;
    }
    const Status status = TickChild(tick);
    if (status != Status::kRunning) since_.reset();
    return status;
  }
  void OnHalt(Tick& tick) override {
    since_.reset();
    child().Reset(tick);
  }

  InPort<unsigned> limit_ms_;
  Duration limit_{};  // since its start
  std::optional<Time> since_;
};

class RunOnce : public Decorator {
 public:
  explicit RunOnce(Setup& setup)
      : then_skip_(setup.Input<bool>("then_skip", true, "false: the same result again")) {}

 private:
  Status OnTick(Tick& tick) override {
    if (result_) return then_skip_.Get() ? Status::kSkipped : *result_;
    const Status status = TickChild(tick);
    if (IsCompleted(status)) result_ = status;
    return status;
  }

  InPort<bool> then_skip_;
  std::optional<Status> result_;
};

class Precondition : public Decorator {
 public:
  explicit Precondition(Setup& setup)
      : script_(setup.ScriptOf("if", true)),
        else_(setup.Input<Status>("else", Status::kFailure, "the result where it does not hold")) {}

 private:
  Status OnTick(Tick& tick) override {
    if (!child().running() && !script_->True()) return else_.Get();
    return TickChild(tick);
  }

  std::optional<Script> script_;
  InPort<Status> else_;
};

template <class N>
void AddTimed(Factory& factory, std::string_view name) {
  static_cast<void>(factory.Register(
      name, {NodeKind::kDecorator, true, [](Setup& setup) -> std::unique_ptr<Node> {
               if constexpr (std::is_constructible_v<N, Setup&>) {
                 return std::make_unique<N>(setup);
               } else {
                 return std::make_unique<N>();
               }
             }}));
}

}  // namespace

void AddDecorators(Factory& factory) {
  static_cast<void>(factory.Add<Inverter>("Inverter"));
  static_cast<void>(factory.Add<Force<Status::kSuccess>>("ForceSuccess"));
  static_cast<void>(factory.Add<Force<Status::kFailure>>("ForceFailure"));
  static_cast<void>(factory.Add<RunOnce>("RunOnce"));
  static_cast<void>(factory.Add<Precondition>("Precondition"));
  static_cast<void>(factory.Add<Timeout>("Timeout"));
  AddTimed<KeepRunningUntilFailure>(factory, "KeepRunningUntilFailure");
  AddTimed<Repeat>(factory, "Repeat");
  AddTimed<RetryUntilSuccessful>(factory, "RetryUntilSuccessful");
  AddTimed<Delay>(factory, "Delay");
}

}  // namespace musher::tree
