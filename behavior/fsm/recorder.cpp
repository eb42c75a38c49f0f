#include "musher/behavior/fsm/recorder.hpp"

#include <array>
#include <utility>

#include "musher/base/check.hpp"
#include "musher/behavior/fsm/recording_text.hpp"
#include "musher/behavior/fsm/saved_part.hpp"

namespace musher::fsm {

void AppendChange(std::string& line, const Machine& machine, const Change& change) {
  AppendNumber(line, change.tick);
  AppendTime(line, change.at);
  AppendWord(line, machine.Name(change.from));
  AppendWord(line, machine.Name(change.to));
  AppendWord(line, Name(change.cause));
  if (change.command != kNoEvent) AppendWord(line, machine.Name(change.command));
}

void AppendChangeInside(std::string& line, const Machine& inside, const Change& change) {
  AppendWord(line, "inside");
  AppendWord(line, inside.Place());
  AppendWord(line, inside.name());
  AppendChange(line, inside, change);
}

Recorder::Recorder(Machine& machine, Sink sink) : machine_(machine), sink_(std::move(sink)) {
  MUSHER_CHECK(sink_ && !machine.running());
  line_ = kRecordingFormat;
  AppendWord(line_, machine.name());
  Write();
  machine_.Listen(this);
  machine_.ListenToInputs(this);
}

Recorder::~Recorder() {
  machine_.Forget(this);
  machine_.ForgetInputs(this);
}

void Recorder::Input(std::string_view name, std::string_view text) {
  line_ = "input";
  AppendWord(line_, name);
  AppendWord(line_, text);
  Write();
}

void Recorder::OnInput(const Machine& machine, const fsm::Input& input) {
  using Kind = fsm::Input::Kind;
  constexpr std::array<std::string_view, 7> kWords{"start", "tick",  "pause", "command",
                                                   "force", "reset", "stop"};
  // A restore is not notified. It shows here: a machine that does not run gets no input but a
  // start.
  if (input.kind != Kind::kStart && !running_) {
    line_ = kRestored;
    Write();
  }
  running_ = true;
  line_ = kWords[static_cast<std::size_t>(input.kind)];
  if (input.kind == Kind::kStart || input.kind == Kind::kTick) {
    if (!first_start_) first_start_ = input.time;
    AppendTime(line_, input.time - *first_start_);
  }
  if (input.kind == Kind::kCommand) AppendWord(line_, machine.Name(input.command));
  if (input.data != nullptr) {
    for (const SavedField& field :
         SaveFields([&](Archive& archive) { input.data->Persist(archive); })) {
      AppendWord(line_, field.name);
      AppendWord(line_, TextOf(field.value));
    }
  }
  if (input.state != kNoState) AppendWord(line_, machine.Name(input.state));
  Write();
}

void Recorder::OnChange(const Machine& machine, const Change& change) {
  running_ = change.to != kNoState;
  line_ = "changed";
  AppendChange(line_, machine, change);
  Write();
}

void Recorder::OnChangeInside(const Machine& /*machine*/, const Machine& inside,
                              const Change& change) {
  line_.clear();
  AppendChangeInside(line_, inside, change);
  Write();
}

void Recorder::Write() {
  line_ += '\n';
  sink_(line_);
}

}  // namespace musher::fsm
