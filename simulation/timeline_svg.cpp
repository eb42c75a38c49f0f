// The picture of a scenario: time from left to right, a band for the machine and for each actuator,
// coloured by the state's rank; numbered marks for injected events, violations in red.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "musher/simulation/timeline.hpp"

namespace musher::simulation {
namespace {

constexpr double kLeft = 170;
constexpr double kWidth = 1000;
constexpr double kRow = 26;
constexpr double kTop = 60;

std::string Number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f", value);
  return text.data();
}

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '&')
      escaped += "&amp;";
    else if (c == '<')
      escaped += "&lt;";
    else if (c == '>')
      escaped += "&gt;";
    else if (c == '"')
      escaped += "&quot;";
    else
      escaped += c;
  }
  return escaped;
}

// A warmer colour for a more active state.
std::string_view ColourOf(const MachineConfig& config, const std::string& state) {
  if (state.empty()) return "none";
  if (state == kError) return "#d98880";
  const auto rank = config.RankOf(state);
  if (!rank) return "#d5d8dc";  // a step of a start
  static constexpr std::array<std::string_view, 7> kColours = {
      "#85929e", "#d98880", "#bb8fce", "#85c1e9", "#a9cce3", "#f7dc6f", "#82e0aa"};
  const auto index = std::clamp<Rank>(*rank, 0, static_cast<Rank>(kColours.size()) - 1);
  return kColours[static_cast<std::size_t>(index)];
}

std::string Label(double x, double y, const std::string& attributes, const std::string& text) {
  return "<text x=\"" + Number(x) + "\" y=\"" + Number(y) + "\" " + attributes + ">" +
         Escaped(text) + "</text>\n";
}

// Time on the axis: events are milliseconds apart at first and seconds later, so a position is 15 %
// by time and 85 % by order.
class Axis {
 public:
  Axis(const std::vector<Timeline::Line>& lines, Duration end) : end_(end) {
    for (const Timeline::Line& line : lines) {
      if (times_.empty() || times_.back() != line.at) times_.push_back(line.at);
    }
  }
  double X(Duration at) const {
    const double by_time =
        end_.count() == 0 ? 0 : static_cast<double>(at.count()) / static_cast<double>(end_.count());
    const auto next = std::upper_bound(times_.begin(), times_.end(), at);
    const double by_order = static_cast<double>(next - times_.begin()) /
                            static_cast<double>(std::max<std::size_t>(1, times_.size()));
    return kLeft + kWidth * (0.15 * by_time + 0.85 * by_order);
  }

 private:
  Duration end_;
  std::vector<Duration> times_;
};

std::string DrawBand(const MachineConfig& config, const Timeline::Band& band, const Axis& axis,
                     double y) {
  std::string svg = Label(kLeft - 8, y + kRow * 0.65, "text-anchor=\"end\"", band.name);
  for (const Timeline::Span& span : band.spans) {
    if (span.state.empty()) continue;
    const double x = axis.X(span.from);
    const double width = std::max(1.0, axis.X(span.to) - x);
    const std::string what = span.target.empty() ? span.state : span.state + " → " + span.target;
    svg += "<rect x=\"" + Number(x) + "\" y=\"" + Number(y + 3) + "\" width=\"" + Number(width) +
           "\" height=\"" + Number(kRow - 6) + "\" fill=\"" +
           std::string(ColourOf(config, span.state)) + "\"" +
           (span.target.empty() ? ""
                                : " fill-opacity=\"0.45\" stroke=\"#7b7d7d\" "
                                  "stroke-dasharray=\"3 2\"") +
           "><title>" + Escaped(what) + "</title></rect>\n";
    if (width > 7.5 * static_cast<double>(what.size())) {
      svg += Label(x + 4, y + kRow * 0.65, "font-size=\"11\"", what);
    }
  }
  return svg;
}

}  // namespace

std::string Timeline::SvgOf(const MachineConfig& config, const std::vector<Line>& lines,
                            const std::vector<Band>& bands, Duration end,
                            const std::string& title) {
  const Axis axis(lines, end);
  std::vector<const Line*> numbered;  // listed beneath the bands
  for (const Line& line : lines) {
    const bool shown = line.source == Source::kInjection || line.source == Source::kOperator ||
                       line.source == Source::kChecker;
    if (shown) numbered.push_back(&line);
  }
  const double bands_end = kTop + kRow * static_cast<double>(bands.size());
  const double height = bands_end + 40 + 18 * static_cast<double>(numbered.size());
  const double width = kLeft + kWidth + 30;
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + Number(width) +
                    " " + Number(height) + "\" font-family=\"sans-serif\" font-size=\"13\">\n";
  svg += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  svg += Label(kLeft, 22, "font-size=\"16\"", title);
  for (std::size_t i = 0; i < bands.size(); ++i) {
    svg += DrawBand(config, bands[i], axis, kTop + kRow * static_cast<double>(i));
  }
  for (std::size_t i = 0; i < numbered.size(); ++i) {
    const Line& line = *numbered[i];
    const double x = axis.X(line.at);
    const std::string colour = line.source == Source::kChecker    ? "#c0392b"
                               : line.source == Source::kOperator ? "#2471a3"
                                                                  : "#ca6f1e";
    svg += "<line x1=\"" + Number(x) + "\" y1=\"" + Number(kTop - 4) + "\" x2=\"" + Number(x) +
           "\" y2=\"" + Number(bands_end) + "\" stroke=\"" + colour + "\"/>\n";
    svg += Label(x, kTop - 8 - 11 * static_cast<double>(i % 2),
                 "text-anchor=\"middle\" font-size=\"10\" fill=\"" + colour + "\"",
                 std::to_string(i + 1));
    std::array<char, 32> at{};
    std::snprintf(at.data(), at.size(), "%.3f s", ToSeconds(line.at));
    const double y = bands_end + 30 + 18 * static_cast<double>(i);
    svg += Label(kLeft - 8, y, "text-anchor=\"end\" fill=\"" + colour + "\"",
                 std::to_string(i + 1) + ".  " + at.data());
    svg += Label(kLeft, y, "fill=\"" + colour + "\"", line.text);
  }
  return svg + "</svg>\n";
}

}  // namespace musher::simulation
