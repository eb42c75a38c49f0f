#include "musher/application/tree_actuator.hpp"

#include <exception>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "musher/application/application_impl.hpp"
#include "musher/application/load_tree.hpp"
#include "musher/application/refusal.hpp"
#include "musher/application/tree_report.hpp"
#include "musher/base/check.hpp"
#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher {

class TreeActuator::Impl final : public ApplicationImpl {
 public:
  Impl(TreeActuator& owner, Options options)
      : ApplicationImpl(owner, options.rate_hz),
        owner_(owner),
        options_(std::move(options)),
        log_(owner) {}

  Result<tree::Document> ReadFile() const {
    if (options_.file.empty()) {
      return Error{kCodeParametersInvalid, "Options::file of " + owner_.name() +
                                               " is empty, and LoadTree() is not overridden"};
    }
    return ReadTreeDocument(options_.file, warn_);
  }

  Result<> Load(tree::Document document, const Entries& entries, const std::string& main) {
    if (in_tree_) {
      return Refused<ApplicationRefusal::kInsideOwnTree>();
    }
    Loaded loaded{std::move(document), entries, main, nullptr};
    if (Result<> built = Build(loaded, *factory_); !built) return built;
    ForgetFault();
    const Halted halted = HaltNodes();
    if (!halted.fault.empty()) return RestFailed(halted.fault);
    const bool rests = halted.rests.value_or(false);
    static_cast<void>(TakeLongBreak());  // one of before this command
    commanded_ = true;
    Use(std::move(loaded));
    halted_ = rests;
    resting_ |= rests;
    Record();
    Report(true);
    return Ok();
  }

  using ApplicationImpl::CheckNotLate;

  Result<> Restart() { return Stop(false); }
  // For START, which begins what rests.
  Result<> BeginByCommand() {
    if (under_way()) return Refused<ApplicationRefusal::kUnderWay>(owner_.name());
    return Restart();
  }
  void Halt() { static_cast<void>(Stop(true)); }

  Impl& OnLoop() { return CheckThread(), *this; }  // for calls that are on the loop only
  bool has_tree() const { return loaded_.tree != nullptr; }
  tree::Tree& tree() {
    MUSHER_CHECK(has_tree(), owner_.name(), "has no tree");
    return *loaded_.tree;
  }
  const tree::Factory& factory() const {
    MUSHER_CHECK(factory_ != nullptr, "SetUp of", owner_.name(), "has not run");
    return *factory_;
  }
  tree::Status result() const { return result_; }
  const std::string& last_fault() const { return last_fault_; }

  TreeView View() {
    return {.tree = loaded_.tree.get(),
            .document = &loaded_.document,
            .revision = revision_,
            .ticking = ticking(),
            .ticks = tick_count_,
            .result = result_,
            .last_fault = &last_fault_,
            .time = &time_};
  }

 private:
  struct Loaded {
    tree::Document document;
    Entries entries;
    std::string main;
    std::unique_ptr<tree::Tree> tree;  // null: none
  };

  Result<> SetUp() override {
    auto factory = std::make_unique<tree::Factory>();
    if (Result<> registered = owner_.RegisterNodes(*factory); !registered) return registered;
    Result<tree::Document> document = owner_.LoadTree();
    if (!document) return document.error();
    Loaded loaded{std::move(document).value(), {}, options_.tree, nullptr};
    if (!loaded.document.trees.empty()) {
      if (Result<> built = BuildFirst(loaded, *factory); !built) return built;
    }
    Result<std::unique_ptr<TreeRecording>> recording = OpenRecording();
    if (!recording) return recording.error();
    owner_.RunOnLoop([&] {
      HaltNodes();
      commanded_ = false;
      Use(std::move(loaded));
      ForgetFault();
      halted_ = false;
      factory_ = std::move(factory);
      recording_ = std::move(recording).value();
      Record();
    });
    return Open([this](transport::Endpoints& topics) {
      publisher_ = nullptr;
      publisher_ =
          topics.Advertise<msg::TreeState>(owner_.name() + "/tree_state", transport::kLatchedQos,
                                           {.on_match_changed = [this] { Report(true); }});
      topics.Serve<msg::GetTree>(
          owner_.name() + "/get_tree",
          [this](const auto& request, auto reply) { reply(ReportTree(View(), request)); });
      ServeCommands(
          topics, [this](const std::string& command) { return Send(command); },
          [](const std::string&) { return false; });
      Report(true);
      owner_.OpenTopics(topics);
    });
  }
  Result<> SelfCheck() override { return owner_.SelfCheck(); }

  Result<> Activate() override {
    Result<> begun = Continue();
    if (!begun) Pause();  // an incomplete start is not left running
    return begun;
  }
  void Leave(const State& /*state*/) override { Pause(); }
  std::string StopAtOnce() override {
    Pause();
    return halt_fault_;
  }

  Result<> Send(const std::string& command) {
    if (command != kStartCommand) {
      return Refused<ApplicationRefusal::kUnknownCommand>(command, kStartCommand);
    }
    if (!ticking()) {
      return Refused<ApplicationRefusal::kBeginsInActive>(owner_.name(), Whereabouts());
    }
    Result<> sent;
    if (const auto thrown = Thrown("OnStartCommand", [&] { sent = owner_.OnStartCommand(); })) {
      return Error{kCodeFailed, *thrown};
    }
    return sent;
  }

  // On the loop where other trees, which are ticked there, may have the same outer board: the build
  // adds keys to it. An exception fails SetUp either way.
  Result<> BuildFirst(Loaded& loaded, const tree::Factory& factory) {
    if (options_.outer_board == nullptr) return Build(loaded, factory);
    Result<> built;
    std::exception_ptr thrown;
    owner_.RunOnLoop([&] {
      try {
        built = Build(loaded, factory);
      } catch (...) {
        thrown = std::current_exception();
      }
    });
    if (thrown) std::rethrow_exception(thrown);
    return built;
  }

  Result<> Build(Loaded& loaded, const tree::Factory& factory) {
    OuterBoardGuard outer(options_.outer_board.get());
    tree::BuildOptions options{.tree = loaded.main, .history = options_.history};
    if (options_.outer_board != nullptr) {
      options.board = std::make_shared<tree::Board>(options_.outer_board);
    }
    auto tree = BuildTree(loaded.document, factory, options, warn_);
    if (!tree) return tree.error();
    tree::Board& board = tree.value()->board();
    if (Result<> filled = owner_.FillBlackboard(board); !filled) return filled;
    if (Result<> set = SetEntries(board, loaded.entries); !set) return set;
    outer.Keep();
    loaded.tree = std::move(tree).value();
    return Ok();
  }

  // Null: it is not wanted. The one of the SetUp before ends first: both may have the same file.
  Result<std::unique_ptr<TreeRecording>> OpenRecording() {
    TreeRecordingOptions options = options_.record;
    if (options.file.empty()) return std::unique_ptr<TreeRecording>();
    std::unique_ptr<TreeRecording> before;
    owner_.RunOnLoop([&] {
      if (recording_ != nullptr) recording_->End();
      before = std::move(recording_);
    });
    before.reset();
    options.file = std::filesystem::path(owner_.machine_config().state_dir) / options.file;
    return TreeRecording::Open(owner_.name(), options,
                               [this](const std::string& line) { owner_.Log(line); });
  }

  // Between two ticks of the clock: one more as soon as possible.
  void ListenToWakeUps() {
    if (!has_tree()) return;
    loaded_.tree->OnWakeUp([this] {
      ticks_.Post([this] {
        if (ticking() && !resting_) Tick();
      });
    });
  }

  void Record() {
    if (recording_ != nullptr) recording_->Begin(View(), *factory_);
  }

  void Use(Loaded loaded) {
    if (recording_ != nullptr) recording_->End();
    loaded_ = std::move(loaded);
    ListenToWakeUps();
    ++revision_;
    result_ = tree::Status::kIdle;
    resting_ = loaded_.tree == nullptr || !MayBegin();
    time_ = {};
    reported_changes_ = 0;
  }

  bool under_way() const { return has_tree() && !resting_; }
  bool MayBegin() const { return commanded_ || options_.begin == Begin::kAtActive; }

  Result<> Continue() {
    if (Result<> checked = CheckNoStop(); !checked) return checked;
    if (ticking()) return Ok();
    RestAfterBreak();
    if (options_.resume == Resume::kNewBlackboard && has_tree()) {
      Loaded fresh{loaded_.document, loaded_.entries, loaded_.main, nullptr};
      if (Result<> built = Build(fresh, *factory_); !built) return built;
      // A command undoes these, a pause does not. The fault stays in the status.
      const bool rests = halted_ || (resting_ && !last_fault_.empty());
      Use(std::move(fresh));
      resting_ |= rests;
      Record();
    }
    if (const auto thrown = Thrown("OnResume", [&] { owner_.OnResume(); })) {
      return Error{kCodeFailed, *thrown};
    }
    StartTicks();
    if (has_tree() && !MayBegin()) {
      owner_.Log("waits for " + std::string(kStartCommand) +
                 ": a process that was started does not move");
    }
    Report(true);
    return Ok();
  }

  // What ran long ago does not go on by itself: the tree begins as after a restart of its process.
  void RestAfterBreak() {
    const auto could_not_run = TakeLongBreak();
    if (!could_not_run) return;
    const bool under_way = this->under_way();
    HaltTree();
    commanded_ = false;
    resting_ = resting_ || !MayBegin();
    time_.Pause();
    CallOnPause([&] { owner_.OnBreak(); });
    if (under_way) {
      owner_.Log(LogLevel::kWarning, std::string("the tree ") +
                                         (resting_ ? "rests" : "begins at its root") + ": " +
                                         *could_not_run);
    }
    Report(true);
  }

  void Pause() {
    StopTicks();
    HaltTree();
    time_.Pause();
    CallOnPause([&] { owner_.OnPause(); });
    Report(true);
  }

  // Within a tick, the nodes above the present one would go on with halted children: later then.
  // Fails where it is to begin again, and a node throws in its halt: then it rests.
  Result<> Stop(bool rests) {
    if (in_tree_) {
      rests_later_ = rests;
      return Ok();
    }
    if (!rests) {
      static_cast<void>(TakeLongBreak());  // one of before this command
      ForgetFault();
    }
    const Halted halted = HaltNodes();
    if (!rests && !halted.fault.empty()) return RestFailed(halted.fault);
    FinishHalt(rests || halted.rests.value_or(false));
    return Ok();
  }

  // What the node has not stopped may still move: nothing begins on top of it, until a command.
  Error RestFailed(const std::string& fault) {
    result_ = tree::Status::kFailure;
    resting_ = true;
    Report(true);
    return {kCodeFailed, fault};
  }

  // A halted tree: rests, or begins with the next tick.
  void FinishHalt(bool rests) {
    commanded_ = commanded_ || !rests;
    halted_ = rests;
    result_ = tree::Status::kIdle;
    resting_ = rests || !has_tree();
    if (!rests) ForgetFault();
    Report(true);
  }

  void HaltTree() {
    const Halted halted = HaltNodes();
    if (halted.rests) FinishHalt(*halted.rests || !halted.fault.empty());
    if (!halted.fault.empty()) static_cast<void>(RestFailed(halted.fault));
  }

  struct Halted {
    std::string fault;          // "": none
    std::optional<bool> rests;  // what a node has requested meanwhile: Halt(), or Restart()
  };

  // A result of the tree stays.
  Halted HaltNodes() {
    if (!has_tree()) return {};
    in_tree_ = true;
    const Result<> halted = loaded_.tree->Halt(time_.last());
    in_tree_ = false;
    if (!halted) {
      halt_fault_ = halted.error().message;
      Fault(halt_fault_);
    }
    if (result_ == tree::Status::kRunning) result_ = tree::Status::kIdle;
    return {halted ? "" : halted.error().message, std::exchange(rests_later_, std::nullopt)};
  }

  void Tick() override {
    RestAfterBreak();
    const Time now = Now();
    if (now < time_.last()) JumpBack(now);
    time_.Continue(now);
    tree::Status status = tree::Status::kIdle;
    if (const auto thrown = Thrown("BeforeTick", [&] { owner_.BeforeTick(now); })) {
      status = Fail(*thrown);
    } else if (ticking() && !resting_) {
      status = TickTree(now);
    }
    if (!ticking()) return;
    if (const auto thrown = Thrown("AfterTick", [&] { owner_.AfterTick(now, status); })) {
      Fail(*thrown);
    } else if (!IsFailing(status)) {
      logged_fault_.clear();
    }
    Report(false);
  }

  bool IsFailing(tree::Status status) const {
    return status == tree::Status::kFailure && !last_fault_.empty();
  }

  tree::Status TickTree(Time now) {
    halt_fault_.clear();
    in_tree_ = true;
    const Result<tree::Status> ticked = loaded_.tree->TickOnce(now);
    in_tree_ = false;
    ++tick_count_;
    if (!ticked) return AfterTree(Fail(ticked.error().message));
    result_ = ticked.value();
    if (result_ != tree::Status::kRunning) Ended();
    return AfterTree(result_);
  }

  // What a node has requested meanwhile.
  tree::Status AfterTree(tree::Status status) {
    const auto rests = std::exchange(rests_later_, std::nullopt);
    if (rests) static_cast<void>(Stop(*rests));  // a fault is reported
    return status;
  }

  void Ended() {
    if (options_.restart_after_end) return;
    resting_ = true;
    owner_.Log("tree " + loaded_.tree->name() + " ended with " + std::string(tree::Name(result_)));
    Report(true);
  }

  // An end with FAILURE: of a tick or a hook around it.
  tree::Status Fail(const std::string& what) {
    Fault(what);
    const Halted halted = HaltNodes();
    if (!has_tree()) return tree::Status::kFailure;
    result_ = tree::Status::kFailure;
    if (!options_.restart_after_end) resting_ = true;
    Report(!options_.restart_after_end);
    if (halted.rests && (*halted.rests || halted.fault.empty())) FinishHalt(*halted.rests);
    return tree::Status::kFailure;
  }

  // Logged once as long as it is the same; the status of the actuator shows it until the tree
  // begins again, another one is loaded, or the next self-check.
  void Fault(const std::string& what) {
    if (last_fault_ != what) owner_.ReportFault({kCodeFailed, kTreeFault + what});
    last_fault_ = what;
    if (std::exchange(logged_fault_, what) == what) return;
    log_(time_.last().time_since_epoch(), LogLevel::kError, "fault: " + what);
  }

  void ForgetFault() {
    if (!last_fault_.empty()) owner_.ReportFault({kCodeOk, kTreeFault + last_fault_});
    last_fault_.clear();
    halt_fault_.clear();
  }

  void JumpBack(Time now) {
    HaltTree();
    owner_.Log(LogLevel::kWarning, std::string("the clock has jumped back: the tree ") +
                                       (resting_ ? "rests" : "begins at its root"));
    if (has_tree()) loaded_.tree->SetTime(now);
  }

  void LogDropped() {
    const std::uint64_t dropped = has_tree() ? loaded_.tree->dropped_listeners() : 0;
    if (std::exchange(dropped_, dropped) >= dropped) return;
    owner_.Log(LogLevel::kWarning, "a listener of tree " + loaded_.tree->name() +
                                       " has thrown: it gets no more changes, the tree goes on");
  }

  // Without `at_once`: where a node has changed, a program is subscribed, and the last is long ago.
  void Report(bool at_once) {
    LogDropped();
    if (recording_ != nullptr) recording_->Note(View());
    if (!ticks_.open() || publisher_ == nullptr) return;
    const std::uint64_t changes = has_tree() ? loaded_.tree->changes() : 0;
    if (!at_once && changes == reported_changes_) return;
    const Time now = ticks_.LoopNow();
    if (!at_once && (now - reported_at_ < kShortestReport || publisher_->MatchedReaders() == 0)) {
      return;
    }
    reported_at_ = now;
    reported_changes_ = changes;
    ReportState(View(), state_);
    static_cast<void>(publisher_->Publish(state_));  // the next change has another one
  }

  static inline const std::string kTreeFault = "the tree has failed: ";
  static constexpr Duration kShortestReport = std::chrono::milliseconds(50);  // between two states

  TreeActuator& owner_;
  const Options options_;
  const Warn warn_ = [this](const std::string& line) { owner_.Log(LogLevel::kWarning, line); };
  std::unique_ptr<tree::Factory> factory_;  // outlives the tree
  Loaded loaded_;
  TreeTime time_;
  std::unique_ptr<TreeRecording> recording_;                   // null: none
  transport::Publisher<msg::TreeState>* publisher_ = nullptr;  // while the ticks are open
  msg::TreeState state_;
  Time reported_at_{};
  std::uint64_t reported_changes_ = 0;
  std::uint64_t dropped_ = 0;  // listeners of the tree
  std::uint32_t revision_ = 0;
  std::uint64_t tick_count_ = 0;
  tree::Status result_ = tree::Status::kIdle;
  std::string last_fault_;
  std::string logged_fault_;
  std::string halt_fault_;  // of a node in a halt, since the last tick: it may still move something
  std::optional<bool> rests_later_;  // after the present tick or halt: a Halt(), or a Restart()
  bool resting_ = false;
  bool halted_ = false;     // by Halt(), since then neither loaded nor commanded to begin
  bool commanded_ = false;  // to begin, since SetUp
  bool in_tree_ = false;    // the code of a node runs
  LimitedLog log_;
};

TreeActuator::TreeActuator(const std::string& actuator_name, Options options)
    : MachineActuator(actuator_name), impl_(std::make_unique<Impl>(*this, std::move(options))) {
  RegisterStateCallback([this](const State& state) { return impl_->Run(state); });
}

TreeActuator::~TreeActuator() {
  CheckStopped(name(), started());
}

Result<tree::Document> TreeActuator::LoadTree() {
  return impl_->ReadFile();
}
bool TreeActuator::has_tree() const {
  return impl_->OnLoop().has_tree();
}
tree::Tree& TreeActuator::tree() {
  return impl_->OnLoop().tree();
}
const tree::Factory& TreeActuator::factory() const {
  return impl_->OnLoop().factory();
}
Result<> TreeActuator::Load(tree::Document document, const Entries& entries,
                            const std::string& main) {
  return impl_->OnLoop().Load(std::move(document), entries, main);
}
TreeView TreeActuator::view() {
  return impl_->OnLoop().View();
}
void TreeActuator::Restart() {
  static_cast<void>(impl_->OnLoop().Restart());  // a fault is reported
}
Result<> TreeActuator::OnStartCommand() {
  return impl_->OnLoop().BeginByCommand();
}
void TreeActuator::Halt() {
  impl_->OnLoop().Halt();
}
bool TreeActuator::ticking() const {
  return impl_->OnLoop().ticking();
}
tree::Status TreeActuator::result() const {
  return impl_->OnLoop().result();
}
const std::string& TreeActuator::last_fault() const {
  return impl_->OnLoop().last_fault();
}
Result<> TreeActuator::CheckNotLate() const {
  return impl_->OnLoop().CheckNotLate();
}
Time TreeActuator::Now() const {
  return impl_->OnLoop().Now();
}
msg::Stamp TreeActuator::Stamp() const {
  return impl_->OnLoop().Stamp();
}
void TreeActuator::OnEmergencyStop() {
  impl_->OnEmergencyStop();
}

}  // namespace musher
