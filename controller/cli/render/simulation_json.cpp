#include <nlohmann/json.hpp>

#include "musher/controller/cli/render/simulation.hpp"

namespace musher::cli {
namespace {

using nlohmann::ordered_json;

ordered_json StoryOf(const simulation::StoryId& id) {
  ordered_json json = {{"seed", id.seed}};
  if (id.only) json["only"] = *id.only;
  return json;
}

ordered_json CoverageOf(const simulation::Coverage& coverage) {
  ordered_json json;
  for (std::size_t kind = 0; kind < simulation::kIncidentKinds; ++kind) {
    const auto incident = static_cast<simulation::IncidentKind>(kind);
    ordered_json& row = json[std::string(KindName(incident))];
    for (std::size_t moment = 0; moment < simulation::kMoments; ++moment) {
      const auto when = static_cast<simulation::Moment>(moment);
      row[std::string(MomentName(when))] = coverage.Of(incident, when);
    }
  }
  return json;
}

}  // namespace

std::string SimulationJson(const SimulationReport& report, const std::string& bad_story) {
  const simulation::Summary& s = report.summary;
  ordered_json json = {{"file", report.file},
                       {"stories", s.stories},
                       {"good", s.good()},
                       {"simulated_s", Seconds(s.simulated)},
                       {"took_s", Seconds(report.took)},
                       {"judgements", s.judgements},
                       {"bound_s", Seconds(report.options.bound)}};
  for (std::size_t i = 0; i < s.switches.size(); ++i) {
    json["switches"][std::string(OutcomeName(static_cast<SwitchOutcome>(i)))] = s.switches[i];
  }
  if (!s.rests.empty()) {
    json["rest_s"] = {{"median", Seconds(s.rests[s.rests.size() / 2])},
                      {"longest", Seconds(s.rests.back())}};
  }
  json["coverage"] = CoverageOf(s.coverage);
  for (std::size_t i = 0; i < simulation::kPromises; ++i) {
    json["promises"].push_back(
        {{"promise", PromiseText(static_cast<simulation::Promise>(i))}, {"broken_by", s.bad[i]}});
  }
  if (report.worst) {
    json["shortest_bad_story"] = StoryOf(*report.worst);
    json["shortest_bad_story"]["text"] = bad_story;
  }
  return json.dump(2) + "\n";
}

std::string StoryJson(const simulation::StoryId& id, const simulation::Ending& ending,
                      const std::string& text) {
  ordered_json json = StoryOf(id);
  json["good"] = !ending.violation.has_value();
  if (ending.violation) {
    json["broken"] = PromiseText(ending.violation->promise);
    json["what"] = ending.violation->what;
  }
  json["text"] = text;
  return json.dump(2) + "\n";
}

}  // namespace musher::cli
