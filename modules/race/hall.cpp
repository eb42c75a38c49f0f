#include "musher/modules/race/hall.hpp"

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::race {

config_toml::Rows HallRows(Hall& hall) {
  namespace row = config_toml::row;
  return {
      row::Number("lane_m", hall.lane_m, 0.4, 3),
      row::Number("line_m", hall.line_m, 0.01, 0.3),
      row::Number("start_m", hall.start_m, 0.2, 10),
      row::Number("cross_m", hall.cross_m, 0.5, 10),
      row::Number("s1_m", hall.s1_m, 0, 10),
      row::Number("bay_a_aside_m", hall.bay_a_aside_m, 0.5, 10),
      row::Number("bay_a_in_m", hall.bay_a_in_m, 0.1, 10),
      row::Number("bay_a_ahead_m", hall.bay_a_ahead_m, 0.3, 10),
      row::Number("lane_aside_m", hall.lane_aside_m, 0.5, 10),
      row::Number("lane_length_m", hall.lane_length_m, 2, 100),
      row::Number("bay_b_aside_m", hall.bay_b_aside_m, 0.5, 10),
      row::Number("bay_b_in_m", hall.bay_b_in_m, 0.1, 10),
  };
}

HallReading ReadHallText(std::string_view text, const std::string& path, const Hall& base) {
  return config_toml::ReadTextWith<HallReading>(
      text, path, [&](const config_toml::Table& root, config_toml::Findings& findings) {
        Hall hall = base;
        config_toml::TableReader reader(root, {1, 1}, "", findings);
        config_toml::ReadRows(reader, HallRows(hall));
        return hall;
      });
}

HallReading ReadHallFile(const std::string& path, const Hall& base) {
  return config_toml::ReadFileWith(path, [&](std::string_view text, const std::string& file) {
    return ReadHallText(text, file, base);
  });
}

}  // namespace musher::race
