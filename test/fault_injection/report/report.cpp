#include "musher/test/fault_injection/report/report.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/fault_injection/kind.hpp"

namespace musher::fault_injection {
namespace {

using benchmark::Quantile;

Figures FiguresOf(const std::vector<double>& values) {
  return {values.size(), Quantile(values, 0.5), Quantile(values, 0.99), Quantile(values, 1)};
}

std::string Rounded(double milliseconds) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.*f", milliseconds < 10 ? 1 : 0, milliseconds);
  return text;
}

std::string Cells(const Figures& figures) {
  if (figures.count == 0) return "– | – | – |";
  return Rounded(figures.p50) + " | " + Rounded(figures.p99) + " | " + Rounded(figures.max) + " |";
}

nlohmann::json ToJson(const Figures& figures) {
  if (figures.count == 0) return nullptr;
  return {{"count", figures.count},
          {"p50_ms", figures.p50},
          {"p99_ms", figures.p99},
          {"max_ms", figures.max}};
}

nlohmann::json ToJson(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

std::vector<KindFigures> ByKind(const std::vector<Outcome>& outcomes) {
  std::vector<KindFigures> kinds;
  for (const Kind& kind : AllKinds()) {
    KindFigures figures{kind.name, kind.family, kind.about, 0, 0, {}, {}};
    std::vector<double> detections;
    std::vector<double> recoveries;
    for (const Outcome& outcome : outcomes) {
      if (outcome.kind != kind.name) continue;
      ++figures.count;
      if (!outcome.failures.empty()) ++figures.failed;
      if (outcome.detection_ms) detections.push_back(*outcome.detection_ms);
      if (outcome.recovery_ms) recoveries.push_back(*outcome.recovery_ms);
    }
    figures.detection = FiguresOf(detections);
    figures.recovery = FiguresOf(recoveries);
    if (figures.count > 0) kinds.push_back(figures);
  }
  return kinds;
}

void WriteFile(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace

std::string ReplayCommand(const Outcome& outcome) {
  return "fault_injection --only " + outcome.kind + " --faults 1 --seed " +
         std::to_string(outcome.seed);
}

Report::Report(std::vector<Outcome> outcomes, std::uint64_t seed, std::vector<std::string> skipped)
    : outcomes_(std::move(outcomes)),
      seed_(seed),
      skipped_(std::move(skipped)),
      kinds_(ByKind(outcomes_)) {}

std::size_t Report::failed() const {
  return static_cast<std::size_t>(
      std::count_if(outcomes_.begin(), outcomes_.end(),
                    [](const Outcome& outcome) { return !outcome.failures.empty(); }));
}

std::string Report::Summary() const {
  return std::to_string(outcomes_.size()) + " faults of " + std::to_string(kinds_.size()) +
         " kinds, seed " + std::to_string(seed_) + ": " + std::to_string(failed()) + " failed";
}

void Report::Write(const std::filesystem::path& folder) const {
  std::filesystem::create_directories(folder);
  WriteFile(folder / "report.md", Markdown());
  WriteFile(folder / "report.json", Json());
  WriteFile(folder / "report.svg", Svg(kinds_, Summary()));
}

std::string Report::Markdown() const {
  std::string text =
      "# Fault-injection report\n\n" + Summary() + ". " +
      std::to_string(std::thread::hardware_concurrency()) +
      " cores, shared with other work. Times in ms from the fault: *detection* until the "
      "machine's status, published at most each 20 ms, reports it; *recovery* until "
      "the machine is settled as expected, counted from the end of a fault that "
      "lasts; 0: it was settled all the time.\n\n"
      "![Detection and recovery by kind](report.svg)\n\n"
      "| kind | what is injected | count | failed | detection p50 | p99 | max "
      "| recovery p50 | p99 | max |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n";
  for (const KindFigures& kind : kinds_) {
    text += "| " + kind.kind + " | " + kind.about + " | " + std::to_string(kind.count) + " | " +
            std::to_string(kind.failed) + " | " + Cells(kind.detection) + " " +
            Cells(kind.recovery) + "\n";
  }
  for (const std::string& skipped : skipped_) text += "\n" + skipped + "\n";
  if (failed() == 0) return text;
  text += "\n## Failed\n";
  for (const Outcome& outcome : outcomes_) {
    if (outcome.failures.empty()) continue;
    text += "\n`" + ReplayCommand(outcome) + "` (" + outcome.sampled + ")\n\n";
    for (const std::string& failure : outcome.failures) text += "- " + failure + "\n";
  }
  return text;
}

std::string Report::Json() const {
  nlohmann::json json;
  json["seed"] = seed_;
  json["count"] = outcomes_.size();
  json["failed"] = failed();
  json["cores"] = std::thread::hardware_concurrency();
  json["skipped"] = skipped_;
  for (const KindFigures& kind : kinds_) {
    json["kinds"].push_back({{"kind", kind.kind},
                             {"family", kind.family},
                             {"about", kind.about},
                             {"count", kind.count},
                             {"failed", kind.failed},
                             {"detection", ToJson(kind.detection)},
                             {"recovery", ToJson(kind.recovery)}});
  }
  for (const Outcome& outcome : outcomes_) {
    json["faults"].push_back({{"kind", outcome.kind},
                              {"seed", outcome.seed},
                              {"sampled", outcome.sampled},
                              {"detection_ms", ToJson(outcome.detection_ms)},
                              {"recovery_ms", ToJson(outcome.recovery_ms)},
                              {"whole_ms", outcome.whole_ms},
                              {"failures", outcome.failures}});
  }
  return json.dump(1) + "\n";
}

}  // namespace musher::fault_injection
