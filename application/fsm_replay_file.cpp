#include "musher/application/fsm_replay_file.hpp"

#include <chrono>
#include <iomanip>
#include <ostream>

#include "musher/base/toml/file.hpp"
#include "musher/behavior/fsm/replay.hpp"

namespace musher {
namespace {

// Recordings are larger than configs: an hour of a race has some 30 MiB.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

class ChangePrinter : public fsm::Listener {
 public:
  explicit ChangePrinter(std::ostream& out) : out_(out) {}

  void OnChange(const fsm::Machine& machine, const fsm::Change& change) override {
    const auto name = [&](fsm::StateId id) {
      return id == fsm::kNoState ? std::string_view("-") : machine.Name(id);
    };
    const std::chrono::duration<double> at = change.at;
    out_ << std::fixed << std::setprecision(3) << std::setw(10) << at.count() << " s  "
         << name(change.from) << " -> " << name(change.to) << "  " << fsm::Name(change.cause);
    if (change.command != fsm::kNoEvent) out_ << " by " << machine.Name(change.command);
    out_ << "\n";
  }

 private:
  std::ostream& out_;
};

ReplayExit Refuse(std::ostream& err, const std::string& why) {
  err << why << std::endl;
  return ReplayExit::kNoRecording;
}

}  // namespace

ReplayExit ReplayFile(const std::string& file, const ReplayedApplication& application,
                      std::ostream& out, std::ostream& err) {
  const Result<std::string> text = config_toml::ReadTextFile(file, kMostBytes);
  if (!text) return Refuse(err, file + ": error: " + text.error().message);
  if (text.value().size() > kMostBytes) {
    return Refuse(err, file + ": error: larger than 1 GiB, which is no recording");
  }
  const Result<fsm::Recording> recording = fsm::ReadRecording(text.value(), file);
  if (!recording) return Refuse(err, recording.error().message);
  fsm::Machine machine({.name = recording.value().machine});
  const Result<ReplayedInput> apply = application(machine);
  if (!apply) return Refuse(err, apply.error().message);
  ChangePrinter printer(out);
  machine.Listen(&printer);
  const Result<fsm::Replayed> replayed = fsm::Replay(recording.value(), machine, apply.value());
  machine.Forget(&printer);
  if (!replayed) return Refuse(err, replayed.error().message);
  out << replayed.value().ticks << " ticks, " << replayed.value().changes << " changes: ";
  if (!replayed.value().difference) {
    out << "identical" << std::endl;
    return ReplayExit::kIdentical;
  }
  out << "different\n" << *replayed.value().difference << std::endl;
  return ReplayExit::kDifferent;
}

}  // namespace musher
