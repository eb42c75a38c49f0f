#include "musher/cli/render/top_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "musher/cli/console/console.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/render/description.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/lifecycle/health/health.hpp"

namespace musher::cli {
namespace {

struct Column {
  const char* title;
  std::size_t width;
  bool right;
};

constexpr std::array kTopColumns = {Column{"ACTUATOR", 17, false}, Column{"STATE", 10, false},
                                    Column{"CPU%", 5, true},       Column{"MEM", 6, true},
                                    Column{"THR", 3, true},        Column{"BEAT", 5, true},
                                    Column{"CHKPT", 5, true},      Column{"RST", 3, true}};

// The first `columns` characters; a cut is shown by "~".
std::string CutTo(const std::string& text, std::size_t columns) {
  if (Width(text) <= columns) return text;
  if (columns == 0) return "";
  std::size_t end = 0;
  for (std::size_t seen = 0; end < text.size(); ++end) {
    const bool begins = (static_cast<unsigned char>(text[end]) & 0xc0) != 0x80;
    if (begins && ++seen == columns) break;
  }
  return text.substr(0, end) + "~";
}

std::string Padded(const std::string& text, const Column& column) {
  const std::string cut = CutTo(text, column.width);
  const std::string space(column.width - std::min(column.width, Width(cut)), ' ');
  return column.right ? space + cut : cut + space;
}

std::string MemoryOf(std::uint64_t bytes) {
  const double mb = static_cast<double>(bytes) / 1e6;
  return mb < 100   ? fmt::format("{:.1f}M", mb)
         : mb < 1e4 ? fmt::format("{:.0f}M", mb)
                    : fmt::format("{:.1f}G", mb / 1e3);
}

std::string Seconds(double seconds) {
  return seconds < 100 ? fmt::format("{:.1f}s", seconds) : AgeText(seconds);
}

bool IsBad(const TopRow& row) {
  return row.degraded || (!row.health.empty() && row.health != HealthName(Health::kWell));
}

std::string NoteOfRow(const TopRow& row) {
  std::string note;
  const auto add = [&note](const std::string& part) {
    if (!part.empty()) note += (note.empty() ? "" : "; ") + part;
  };
  if (row.elsewhere) add("on another host");
  if (!row.health.empty() && row.health != HealthName(Health::kWell)) add(row.health);
  if (row.event.empty()) return Printable(note);
  std::string event = row.event;  // "legs: Active done after 3 ms": the row has the name
  const std::string name = row.name.substr(0, row.name.find('*'));
  if (event.starts_with(name + ": ")) event.erase(0, name.size() + 2);
  add(event + (row.event_age_s ? ", " + AgeText(*row.event_age_s) + " ago" : ""));
  return Printable(note);
}

std::string RowText(const TopRow& row, std::size_t width, bool colour) {
  const auto number = [](const auto& value, auto text) { return value ? text(*value) : "-"; };
  const std::string state =
      row.target.empty() || row.target == row.state ? row.state : "\u2192" + row.target;
  const std::array<std::string, kTopColumns.size()> cells = {
      Printable(row.name),
      Printable(state),
      number(row.cpu_percent, [](double cpu) { return fmt::format("{:.1f}", cpu); }),
      number(row.memory_bytes, MemoryOf),
      number(row.threads, [](std::uint64_t threads) { return std::to_string(threads); }),
      number(row.heartbeat_age_s, Seconds),
      row.checkpoint_age_s ? Seconds(*row.checkpoint_age_s)
                           : std::string(row.heartbeat_age_s ? "ok" : "-"),
      std::to_string(row.restarts)};
  std::string text;
  std::size_t used = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Style style = i == 1 ? StyleOfState(row.state) : Style::kPlain;
    if (i == 0 && IsBad(row)) style = Style::kBad;
    if (i == 6 && row.checkpoint_age_s) style = Style::kBad;
    text += Paint(Padded(cells.at(i), kTopColumns.at(i)), style, colour) + " ";
    used += kTopColumns.at(i).width + 1;
  }
  const std::string note = NoteOfRow(row);
  if (note.empty()) return text.substr(0, text.size() - 1);
  return text + Paint(width == 0 ? note : CutTo(note, width - std::min(width, used)),
                      IsBad(row) ? Style::kBad : Style::kDim, colour);
}

std::string HeaderText(std::size_t width, bool colour) {
  std::string header;
  for (const Column& column : kTopColumns) header += Padded(column.title, column) + " ";
  header += "LAST EVENT";
  return Paint(width == 0 ? header : CutTo(header, width), Style::kDim, colour);
}

}  // namespace

void Sort(std::vector<TopRow>& rows, TopOrder order) {
  if (rows.size() < 2) return;
  std::stable_sort(rows.begin() + 1, rows.end(), [order](const TopRow& a, const TopRow& b) {
    switch (order) {
      case TopOrder::kCpu:
        return a.cpu_percent.value_or(-1) > b.cpu_percent.value_or(-1);
      case TopOrder::kMemory:
        return a.memory_bytes.value_or(0) > b.memory_bytes.value_or(0);
      case TopOrder::kName:
        return a.name < b.name;
      case TopOrder::kConfig:
        break;
    }
    return false;
  });
}

std::string TopText(const TopView& view, std::size_t width, std::size_t height, bool colour) {
  const std::string title = Printable(view.title);
  std::string text = Paint(width == 0 ? title : CutTo(title, width), Style::kBold, colour) + '\n' +
                     HeaderText(width, colour) + '\n';
  constexpr std::size_t kHead = 2;
  const bool all = height == 0 || view.rows.size() + kHead <= height;
  const std::size_t shown = all ? view.rows.size() : height - std::min(height, kHead + 1);
  for (std::size_t i = 0; i < shown; ++i) text += RowText(view.rows[i], width, colour) + '\n';
  if (!all)
    text += fmt::format("and {} more: the terminal has no room\n", view.rows.size() - shown);
  return text;
}

std::string TopFrame(const std::string& text) {
  std::string frame = "\x1b[H";
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (begin != 0) frame += "\r\n";
    frame += text.substr(begin, end - begin) + "\x1b[K";
    begin = end + 1;
  }
  return frame + "\x1b[J";
}

std::string TopJson(const TopView& view) {
  OrderedJson rows = OrderedJson::array();
  const auto maybe = [](const auto& value) { return value ? OrderedJson(*value) : OrderedJson(); };
  for (const TopRow& row : view.rows) {
    rows.push_back({{"actuator", row.name == kControllerRow ? "controller" : row.name},
                    {"state", Known(row.state)},
                    {"target", Known(row.target)},
                    {"health", Known(row.health)},
                    {"degraded", row.degraded},
                    {"elsewhere", row.elsewhere},
                    {"pid", Known(row.pid)},
                    {"cpu_percent", maybe(row.cpu_percent)},
                    {"memory_bytes", maybe(row.memory_bytes)},
                    {"threads", maybe(row.threads)},
                    {"heartbeat_age_s", maybe(row.heartbeat_age_s)},
                    {"checkpoint_age_s", maybe(row.checkpoint_age_s)},
                    {"restarts", row.restarts},
                    {"last_event", Known(row.event)}});
  }
  return JsonLine({{"title", view.title}, {"processes", rows}});
}

}  // namespace musher::cli
