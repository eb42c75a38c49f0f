#include "musher/behavior/fsm/replay.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/behavior/fsm/recording_text.hpp"
#include "musher/behavior/fsm/saved_part.hpp"

namespace musher::fsm {
namespace {

using Line = Recording::Line;
using Kind = Line::Kind;

// Compares the changes of a machine with those recorded.
class Comparison : public Listener {
 public:
  explicit Comparison(bool has_inside) : has_inside_(has_inside) {}
  void OnChange(const Machine& machine, const Change& change) override {
    std::string text;
    AppendChange(text, machine, change);
    changes_.push_back(text.substr(1));
  }

  void OnChangeInside(const Machine& /*machine*/, const Machine& inside,
                      const Change& change) override {
    if (!has_inside_) return;
    std::string text;
    AppendChangeInside(text, inside, change);
    changes_.push_back(std::move(text));
  }

  // The changes since the last line that was not a change.
  std::vector<std::string> Take() { return std::exchange(changes_, {}); }

 private:
  const bool has_inside_;
  std::vector<std::string> changes_;
};

class Replayer {
 public:
  Replayer(const Recording& recording, Machine& machine, const ApplyInput& apply)
      : recording_(recording), machine_(machine), apply_(apply), comparison_(recording.has_inside) {
    machine_.Listen(&comparison_);
  }
  ~Replayer() { machine_.Forget(&comparison_); }
  Replayer(const Replayer&) = delete;
  Replayer& operator=(const Replayer&) = delete;

  Result<Replayed> Run() {
    std::vector<const Line*> expected;
    const Line* last = nullptr;
    for (const Line& line : recording_.lines) {
      if (line.kind == Kind::kChanged) {
        expected.push_back(&line);
        continue;
      }
      if (last != nullptr) Compare(*last, expected);
      expected.clear();
      last = &line;
      if (const Result<> result = ReplayLine(line); !result) {
        return Error{result.error().code, At(line) + "error: " + result.error().message};
      }
    }
    if (last != nullptr) Compare(*last, expected, !recording_.cut_short);
    return replayed_;
  }

 private:
  Result<> ReplayLine(const Line& line) {
    // A refusal by the machine or by one of its states is part of the run.
    switch (line.kind) {
      case Kind::kStart:
        return Start(line);
      case Kind::kTick:
        replayed_.ticks += machine_.running() ? 1 : 0;  // a machine that does not run is not ticked
        machine_.RunOnce(kOrigin + line.time);
        break;
      case Kind::kPause:
        machine_.Pause();
        break;
      case Kind::kCommand:
        return Send(line);
      case Kind::kForce: {
        const Result<> forced = machine_.Force(line.name);
        return machine_.FindState(line.name) ? Ok() : forced;
      }
      case Kind::kReset:
        (void)machine_.Reset().ok();
        break;
      case Kind::kStop:
        (void)machine_.Stop().ok();
        break;
      case Kind::kInput:
        return apply_(line.name, line.text);
      case Kind::kChanged:
        break;  // compared, not replayed
    }
    return Ok();
  }

  Result<> Send(const Line& line) {
    const auto event = machine_.FindEvent(line.name);
    if (!event) return machine_.Send(line.name);  // refuses it, with a suggestion
    const std::shared_ptr<EventData> data = machine_.NewData(*event);
    if (data == nullptr && !line.data.empty()) {
      return Error{kCodeParametersInvalid, "event " + line.name + " carries no data"};
    }
    if (data != nullptr) {
      const auto persist = [&](Archive& archive) { data->Persist(archive); };
      std::vector<SavedField> fields = SaveFields(persist);
      for (const auto& [name, text] : line.data) {
        const auto field = std::ranges::find(fields, name, &SavedField::name);
        const auto value = field == fields.end() ? std::nullopt : ValueOf(text, field->value);
        if (!value) {
          return Error{kCodeParametersInvalid,
                       "event " + line.name + " carries no " + name + " of " + text};
        }
        field->value = *value;
      }
      std::vector<SnapshotFault> none;  // the fields are its own
      RestoreFields(fields, "", persist, none);
    }
    (void)machine_.SendData(*event, data).ok();
    return Ok();
  }

  Result<> Start(const Line& line) {
    const auto state = machine_.FindState(line.name);
    if (!state) return machine_.Force(line.name);  // refuses it, with a suggestion
    const bool ran = machine_.running();
    const Result<> started = machine_.StartAt(*state, kOrigin + line.time);
    return ran || !machine_.fault() ? started : Ok();
  }

  // `all`: no other changes are allowed than the expected ones.
  void Compare(const Line& after, const std::vector<const Line*>& expected, bool all = true) {
    const std::vector<std::string> came = comparison_.Take();
    replayed_.changes += came.size();
    if (replayed_.difference) return;
    const std::size_t count = all ? std::max(came.size(), expected.size()) : expected.size();
    for (std::size_t i = 0; i < count; ++i) {
      const std::string recorded = i < expected.size() ? expected[i]->text : "nothing";
      const std::string again = i < came.size() ? came[i] : "nothing";
      if (recorded == again) continue;
      const Line& line = i < expected.size() ? *expected[i] : after;
      replayed_.difference = At(line) + "recorded: " + recorded + "; now: " + again;
      return;
    }
  }

  std::string At(const Line& line) const {
    return recording_.file + ":" + std::to_string(line.number) + ": ";
  }

  static constexpr Time kOrigin{Duration{kFarthestNs / 4}};

  const Recording& recording_;
  Machine& machine_;
  const ApplyInput& apply_;
  Comparison comparison_;
  Replayed replayed_;
};

}  // namespace

Result<Replayed> Replay(const Recording& recording, Machine& machine, const ApplyInput& apply) {
  MUSHER_CHECK(apply && !machine.running());
  if (machine.name() != recording.machine) {
    return Error{kCodeParametersInvalid, recording.file +
                                             ":1: error: it was recorded from machine " +
                                             recording.machine + ", not from " + machine.name()};
  }
  return Replayer(recording, machine, apply).Run();
}

}  // namespace musher::fsm
