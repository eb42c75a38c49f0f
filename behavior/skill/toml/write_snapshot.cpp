#include "musher/behavior/fsm/toml/toml_writer.hpp"
#include "musher/behavior/skill/toml/snapshot_toml.hpp"

namespace musher::skill {
namespace {

class SkillsWriter : private fsm::TomlWriter {
 public:
  Result<std::string> Write(const ManagerSnapshot& snapshot) && {
    Append("# Skills between two steps. Times are nanoseconds of run time.\n");
    for (const Snapshot& run : snapshot.runs) WriteRun(run, "run");
    return Written("the skills");
  }

 private:
  void WriteRun(const Snapshot& run, const std::string& path) {
    ArrayTable(path);
    Text("skill", run.skill);
    Text("state", run.state);
    Bool("entered", run.entered);
    Bool("paused", run.paused);
    if (run.pause_requested) {
      Bool("pause_requested", true);
      Text("pause_why", run.pause_why);
    }
    Number("ticks", run.ticks);
    Time("time_ns", run.time);
    Time("elapsed_ns", run.elapsed);
    Whole("retries", run.retries);
    Whole("replans", run.replans);
    Bool("cancel_requested", run.cancel_requested);
    Bool("cancel_passed", run.cancel_passed);
    Text("cancel_why", run.cancel_why);
    Time("cancel_at_ns", run.cancel_at);
    Whole("progress", run.progress);
    Text("message", run.message);
    WriteHistory(run);
    WriteErrors(run);
    WriteValues(run.parameters, path + ".parameters");
    WriteValues(run.data, path + ".data");
    if (!run.fields.empty()) Table(path + ".fields");
    for (const fsm::SavedField& field : run.fields) {
      std::visit([&](const auto& value) { Field(field.name, value); }, field.value);
    }
    for (const Snapshot& inside : run.inside) WriteRun(inside, path + ".inside");
  }

  void Whole(const std::string& key, int value) { Line(key, std::to_string(value)); }

  void WriteHistory(const Snapshot& run) {
    if (run.history.empty()) return;
    Append("history = [\n");
    for (const Snapshot::PastChange& change : run.history) {
      Append("  { at_ns = " + std::to_string(change.at.count()) + ", tick = " +
             std::to_string(change.tick) + ", from = " + Quoted(change.from, "history") +
             ", to = " + Quoted(change.to, "history") + ", cause = \"" +
             std::string(Name(change.cause)) + "\"");
      if (!change.why.empty()) Append(", why = " + Quoted(change.why, "history"));
      Append(" },\n");
    }
    Append("]\n");
  }

  void WriteErrors(const Snapshot& run) {
    if (run.errors.empty()) return;
    Append("errors = [\n");
    for (const Failure& error : run.errors) {
      Append("  { at_ns = " + std::to_string(error.at.count()) + ", state = " +
             Quoted(error.state, "errors") + ", what = " + Quoted(error.what, "errors") + " },\n");
    }
    Append("]\n");
  }

  void WriteValues(const Values& values, const std::string& path) {
    if (values.empty()) return;
    Table(path);
    for (const Values::Named& named : values) {
      std::visit([&](const auto& value) { WriteValue(named.name, value); }, named.value);
    }
  }
  template <class T>
  void WriteValue(const std::string& name, const T& value) {
    Field(name, value);
  }
  void WriteValue(const std::string& name, const Numbers& numbers) {
    std::string list;
    for (const double number : numbers) list += (list.empty() ? "" : ", ") + NumberText(number);
    Line(Key(name), "[" + list + "]");
  }
};

}  // namespace

Result<std::string> WriteSnapshot(const ManagerSnapshot& snapshot) {
  return SkillsWriter().Write(snapshot);
}

}  // namespace musher::skill
