#include "musher/behavior/skill/compose.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/suggest.hpp"
#include "musher/behavior/skill/run.hpp"

namespace musher::skill {
namespace {

struct Inside {
  Entry entry;
  std::string label;  // before its parameters
  Values parameters;
};

// All skills of a run, with those inside of them.
void AddAll(const Run& run, std::vector<std::string>& names) {
  names.push_back(run.name());
  for (const Run* inside : run.inside()) AddAll(*inside, names);
}

class Composite : public Skill {
 public:
  Composite(Order order, const std::vector<Inside>& parts, std::string error)
      : order_(order), parts_(parts), error_(std::move(error)) {
    for (const Inside& part : parts_) {
      runs_.push_back(
          std::make_unique<Run>(part.entry.name, part.entry.make(), part.entry.settings));
    }
  }

  void Declare(Table& table) override {
    RefuseUnfit(table);
    table.Does(Summary());
    running_ = table.State("RUNNING");
    stopping_ = table.State("STOPPING");
    table.To(running_, kSucceeded,
             order_ == Order::kFirstToFinish ? "one completed" : "all completed");
    table.To(running_, kFailed, order_ == Order::kFirstToFinish ? "all failed" : "one failed");
    table.To(running_, stopping_, "the others are cancelled");
    if (order_ == Order::kFirstToFinish) table.To(stopping_, kSucceeded, "the others have ended");
    table.To(stopping_, kFailed, "the others have ended");
    table.MonotoneProgress();
    for (const auto& run : runs_) {
      for (const std::string& part : run->table().parts()) table.Uses(part);
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      for (const auto& [part, when] : runs_[i]->table().parts_when()) {
        table.UsesWhen(part, [this, i, when = when](const Values& given) {
          return when(ParametersOf(i, given));
        });
      }
    }
    table.Limit({.run = kNoLimit, .cancel = kNoLimit, .retries = 0});
    for (std::size_t i = 0; i < parts_.size(); ++i) Offer(i, table);
  }

  Next Step(Tick& tick) override {
    if (tick.state == stopping_) return Stop(tick);
    if (tick.entered && tick.now == Duration{} && !BeginFirst(tick)) return Next::Fail(failure_);
    StepRunning(tick);
    ReportParts(tick);
    if (order_ == Order::kFirstToFinish) return EvaluateFirst();
    return EvaluateAll(tick);
  }

  Next Cancel(Tick& tick) override {
    for (const auto& run : runs_) run->Cancel("the whole is cancelled");
    if (tick.state == stopping_) return Stop(tick);
    return Next::To(stopping_);
  }

  void OnEnd(const Ended& ended) override {
    for (const auto& run : runs_) run->CancelNow(ended.message);
  }
  void OnPause() override {
    for (const auto& run : runs_) run->Pause();
  }

  void Persist(fsm::Archive& archive) override {
    archive.Field("succeeds", succeeds_);
    archive.Field("outcome", failure_);
  }
  std::vector<Run*> inside() override {
    std::vector<Run*> runs;
    for (const auto& run : runs_) runs.push_back(run.get());
    return runs;
  }
  void Draw(fsm::Chart& chart) const override {
    fsm::Chart parts{.name = chart.name, .states = {}, .transitions = {}, .start = StateId{0}};
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      parts.states.push_back({runs_[i]->name(), fsm::Role::kNormal, {runs_[i]->chart()}});
      if (order_ != Order::kInOrder || i == 0) continue;
      parts.transitions.push_back(
          {static_cast<StateId>(i - 1), static_cast<StateId>(i), "completed"});
    }
    if (order_ != Order::kInOrder) parts.start = fsm::kNoState;
    chart.states[fsm::Index(running_)].inside.push_back(std::move(parts));
  }

 private:
  // "Runs take_off, then navigate_to"
  std::string Summary() const {
    std::string text = "Runs ";
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (i > 0) text += order_ == Order::kInOrder ? ", then " : " and ";
      text += runs_[i]->name();
    }
    if (order_ == Order::kParallel) return text + " at the same time";
    return order_ == Order::kFirstToFinish ? text + " until the first completes" : text;
  }

  void RefuseUnfit(Table& table) const {
    if (!error_.empty()) table.Refuse(error_);
    if (error_.empty() && runs_.empty()) table.Refuse("has no skills");
    for (const auto& run : runs_) {
      if (!run->built()) table.Refuse(run->built().error().message);
    }
    if (order_ == Order::kInOrder) return;
    std::vector<std::string> names;
    for (const auto& run : runs_) {
      // A skill that occurs twice in one part runs twice in turn, or the part refuses it.
      std::vector<std::string> inside;
      AddAll(*run, inside);
      std::ranges::sort(inside);
      inside.erase(std::unique(inside.begin(), inside.end()), inside.end());
      names.insert(names.end(), inside.begin(), inside.end());
    }
    std::ranges::sort(names);
    const auto twice = std::ranges::adjacent_find(names);
    if (twice != names.end()) return table.Refuse(*twice + " would run twice at once");
    RefuseSharedParts(table);
  }

  // Refuses skills that use the same part and run at the same time.
  void RefuseSharedParts(Table& table) const {
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      for (std::size_t k = i + 1; k < runs_.size(); ++k) {
        const std::string* part = SharedPart(runs_[i]->table().parts(), runs_[k]->table().parts());
        if (part == nullptr) continue;
        table.Refuse(runs_[i]->name() + " and " + runs_[k]->name() + " would use the " + *part +
                     " at the same time");
      }
    }
  }

  // The parameters of a part that are not given.
  void Offer(std::size_t i, Table& table) const {
    Table checked = runs_[i]->table();
    const Result<> fits = checked.Apply({.parameters = parts_[i].parameters});
    if (!fits) table.Refuse(parts_[i].label + ": " + fits.error().message);
    for (const Table::Parameter& parameter : runs_[i]->table().parameters()) {
      if (parts_[i].parameters.Find(parameter.name) != nullptr) continue;
      const std::string name = parts_[i].label + "." + parameter.name;
      if (parameter.otherwise) {
        table.Takes(name, *parameter.otherwise, parameter.meaning);
      } else {
        table.Needs(name, parameter.kind, parameter.meaning);
      }
    }
  }

  // The parameters of a part, from those given to the whole.
  Values ParametersOf(std::size_t i, const Values& given) const {
    Values parameters = parts_[i].parameters;
    const std::string prefix = parts_[i].label + ".";
    for (const Values::Named& named : given) {
      if (!named.name.starts_with(prefix)) continue;
      parameters.Set(named.name.substr(prefix.size()), named.value);
    }
    return parameters;
  }

  bool Begin(std::size_t i, const Tick& tick) {
    const Result<> begun = runs_[i]->Begin(ParametersOf(i, tick.parameters));
    if (!begun) failure_ = begun.error().message;
    for (const auto& other : runs_) {
      if (!begun || other == runs_[i] || !other->running()) continue;
      const std::vector<std::string> own = runs_[i]->parts(), others = other->parts();
      const std::string* part = SharedPart(own, others);
      if (part == nullptr) continue;
      failure_ = runs_[i]->name() + " needs the " + *part + ", which " + other->name() +
                 " is using at the same time";
      return false;
    }
    return begun.ok();
  }

  bool BeginFirst(const Tick& tick) {
    const std::size_t count = order_ == Order::kInOrder ? 1 : runs_.size();
    for (std::size_t i = 0; i < count; ++i) {
      if (!Begin(i, tick)) return false;
    }
    return true;
  }

  void StepRunning(const Tick& tick) {
    for (const auto& run : runs_) run->Step(tick.step);
  }

  void ReportParts(Tick& tick) const {
    double total = 0;
    double most = 0;
    std::string message;
    for (const auto& run : runs_) {
      const Feedback& feedback = run->feedback();
      total += feedback.progress;
      most = std::max<double>(most, feedback.progress);
      if (!run->running()) continue;
      message += (message.empty() ? "" : "; ") + run->name() + ": " + feedback.message;
      for (const Values::Named& detail : feedback.details) {
        tick.Detail(run->name() + "." + detail.name, detail.value);
      }
    }
    const double mean = total / static_cast<double>(runs_.size());
    tick.Report(order_ == Order::kFirstToFinish ? most : mean, std::move(message));
  }

  static bool Completed(const Run& run) { return run.feedback().status == Status::kCompleted; }
  static std::string Outcome(const Run& run) {
    return run.name() + ": " + std::string(Name(run.feedback().status)) + ": " +
           run.feedback().message;
  }

  Next EvaluateAll(const Tick& tick) {
    for (const auto& run : runs_) {
      if (run->ended() && !Completed(*run)) return Conclude(false, Outcome(*run));
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (runs_[i]->running()) return Next::Stay();
      if (runs_[i]->ended()) continue;
      return Begin(i, tick) ? Next::Stay() : Next::Fail(failure_);
    }
    return Next::Succeed();
  }

  Next EvaluateFirst() {
    std::string outcomes;
    bool all = true;
    for (const auto& run : runs_) {
      if (run->ended() && Completed(*run)) return Conclude(true, Outcome(*run));
      all = all && run->ended();
      if (run->ended()) outcomes += (outcomes.empty() ? "" : "; ") + Outcome(*run);
    }
    return all ? Next::Fail(outcomes) : Next::Stay();
  }

  // Ends at once, or when the others are cancelled.
  Next Conclude(bool succeeds, const std::string& outcome) {
    succeeds_ = succeeds;
    failure_ = outcome;
    bool others = false;
    for (const auto& run : runs_) {
      run->Cancel(outcome);
      others = others || run->running();
    }
    if (others) return Next::To(stopping_, outcome);
    return succeeds ? Next::Succeed(outcome) : Next::Fail(outcome);
  }

  Next Stop(const Tick& tick) {
    StepRunning(tick);
    if (std::ranges::any_of(runs_, [](const auto& run) { return run->running(); })) {
      return Next::Stay();
    }
    for (const auto& run : runs_) {
      if (tick.cancelling && run->feedback().status == Status::kFailed &&
          order_ != Order::kFirstToFinish) {
        return Next::Fail(Outcome(*run));
      }
    }
    if (tick.cancelling) return Next::Cancelled();
    return succeeds_ ? Next::Succeed(failure_) : Next::Fail(failure_);
  }

  const Order order_;
  const std::vector<Inside> parts_;
  const std::string error_;
  std::vector<std::unique_ptr<Run>> runs_;
  StateId running_ = kIdle;
  StateId stopping_ = kIdle;
  bool succeeds_ = false;
  std::string failure_;  // or the success that ended it
};

}  // namespace

Factory Compose(Order order, const Registry& registry, const std::vector<Part>& parts) {
  std::vector<Inside> inside;
  std::string error;
  for (const Part& part : parts) {
    const Entry* entry = registry.Find(part.skill);
    if (entry == nullptr) {
      error += (error.empty() ? "" : "; ") + NoSuch("skill", part.skill, registry.Names());
      continue;
    }
    const auto earlier = std::ranges::count_if(
        inside, [&](const Inside& other) { return other.entry.name == part.skill; });
    const std::string label = part.skill + (earlier == 0 ? "" : "_" + std::to_string(earlier + 1));
    inside.push_back({*entry, label, part.parameters});
  }
  return [order, inside, error] { return std::make_unique<Composite>(order, inside, error); };
}

}  // namespace musher::skill
