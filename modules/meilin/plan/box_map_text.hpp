#pragma once
// A map of boxes as text, and the plans that were found for it.
//
//   JSON, on mf_r2_data: {"grid": [[0, 0, 0], … six rows], "team": "blue", "method": 1,
//                         "timestamp": 1718400000000}; method 1 one-way, 0 omni
//   TOML, of a person:   team = "blue", method = "one-way" or "omni", grid as above
//
// Numbers of the grid: 0 empty, 1 KFS1, 2 KFS2, 3 fake; row 0 first. Pure but for ReadBoxMapFile();
// functions never throw.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/modules/meilin/plan/route_search.hpp"

namespace musher::meilin {

struct BoxMapReading {
  std::optional<BoxMap> map;        // present exactly when there are no faults
  std::vector<std::string> faults;  // each with its place: "grid[2][1]: …"
};

// Other keys than those above are ignored: a web page may send more.
BoxMapReading ReadBoxMapJson(std::string_view text);

struct BoxMapFileReading {
  std::optional<BoxMap> map;            // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
};

BoxMapFileReading ReadBoxMapText(std::string_view text, const std::string& path);
// By its ending: ".json", otherwise TOML.
BoxMapFileReading ReadBoxMapFile(const std::string& path);

// {"buckets": [{"kfs2_count": 0, "total": 42, "paths": [{"index": 1, "cost": 12.5, "kfs2_count": 0,
// "kfs1_affected": 2, "steps": 7, "detail": [[0, 0, 0, 0.0, 0.0, 0, 0, 0], …]}]}]}, in one line.
std::string RoutesJson(const Routes& routes);

}  // namespace musher::meilin
