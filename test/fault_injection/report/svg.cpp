// The picture: a row for each kind, a logarithmic axis of milliseconds, from the median to the
// highest value a line, with marks for p50, p99 and max.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "musher/test/fault_injection/report/report.hpp"

namespace musher::fault_injection {
namespace {

constexpr double kLeft = 190;
constexpr double kRight = 900;
constexpr double kTop = 84;
constexpr double kRow = 24;
constexpr double kWidth = 1010;
constexpr double kLeastMs = 0.1;
constexpr double kMostMs = 100'000;
constexpr const char* kDetection = "#1f6fb2";
constexpr const char* kRecovery = "#d9730d";

double XOf(double milliseconds) {
  const double clamped = std::clamp(milliseconds, kLeastMs, kMostMs);
  const double share = std::log10(clamped / kLeastMs) / std::log10(kMostMs / kLeastMs);
  return kLeft + share * (kRight - kLeft);
}

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f", value);
  return text;
}

std::string Text(double x, double y, const std::string& text, const std::string& more = "") {
  return "<text x=\"" + Number(x) + "\" y=\"" + Number(y) + "\"" + more + ">" + text + "</text>\n";
}

std::string Line(double x1, double y1, double x2, double y2, const std::string& colour,
                 double width) {
  return "<line x1=\"" + Number(x1) + "\" y1=\"" + Number(y1) + "\" x2=\"" + Number(x2) +
         "\" y2=\"" + Number(y2) + "\" stroke=\"" + colour + "\" stroke-width=\"" + Number(width) +
         "\"/>\n";
}

// p50: a full circle, p99: a bar, max: an open circle.
std::string Marks(const Figures& figures, double y, const std::string& colour) {
  if (figures.count == 0) return "";
  if (figures.max <= 0) {
    return Text(kLeft + 6, y + 4, "undisturbed", " font-size=\"10\" fill=\"" + colour + "\"");
  }
  const auto circle = [&](double at, const std::string& fill) {
    return "<circle cx=\"" + Number(XOf(at)) + "\" cy=\"" + Number(y) + "\" r=\"3.5\" stroke=\"" +
           colour + "\" stroke-width=\"1.5\" fill=\"" + fill + "\"/>\n";
  };
  return Line(XOf(figures.p50), y, XOf(figures.max), y, colour, 1.5) +
         Line(XOf(figures.p99), y - 5, XOf(figures.p99), y + 5, colour, 2) +
         circle(figures.max, "white") + circle(figures.p50, colour);
}

std::string Axis(double bottom) {
  static const std::array<std::pair<double, const char*>, 7> ticks = {{{0.1, "0.1 ms"},
                                                                       {1, "1 ms"},
                                                                       {10, "10 ms"},
                                                                       {100, "100 ms"},
                                                                       {1000, "1 s"},
                                                                       {10'000, "10 s"},
                                                                       {100'000, "100 s"}}};
  std::string svg;
  for (const auto& [milliseconds, name] : ticks) {
    const double x = XOf(milliseconds);
    svg += Line(x, kTop - 8, x, bottom, "#cccccc", 1);
    svg += Text(x, kTop - 14, name, " text-anchor=\"middle\" fill=\"#555555\"");
  }
  return svg;
}

std::string Legend() {
  std::string svg;
  double x = kLeft;
  for (const auto& [name, colour] : {std::pair("detection", kDetection), {"recovery", kRecovery}}) {
    svg += "<circle cx=\"" + Number(x + 5) + "\" cy=\"46\" r=\"4\" fill=\"" + colour + "\"/>\n";
    svg += Text(x + 15, 50, name);
    x += 100;
  }
  svg += Text(x + 10, 50, "● median   ┃ p99   ○ highest", " fill=\"#555555\"");
  return svg;
}

}  // namespace

std::string Svg(const std::vector<KindFigures>& kinds, const std::string& title) {
  std::string rows;
  std::string family;
  double y = kTop;
  for (const KindFigures& kind : kinds) {
    if (kind.family != family) {
      family = kind.family;
      rows += Text(8, y + 16, family, " font-weight=\"bold\"");
      y += kRow;
    }
    const std::string colour = kind.failed > 0 ? "#c00000" : "#222222";
    const std::string count =
        std::to_string(kind.count) +
        (kind.failed > 0 ? ", " + std::to_string(kind.failed) + " failed" : "");
    rows += Text(20, y + 16, kind.kind, " fill=\"" + colour + "\"");
    rows += Text(kRight + 28, y + 16, count, " fill=\"" + colour + "\"");
    rows += Line(kLeft, y + kRow, kRight, y + kRow, "#eeeeee", 1);
    rows += Marks(kind.detection, y + 8, kDetection) + Marks(kind.recovery, y + 16, kRecovery);
    y += kRow;
  }
  const double height = y + 20;
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + Number(kWidth) + " " +
         Number(height) + "\" font-family=\"sans-serif\" font-size=\"12\">\n" +
         "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" +
         Text(8, 22, title, " font-size=\"16\" font-weight=\"bold\"") + Legend() +
         Text(kRight + 28, kTop - 14, "count", " fill=\"#555555\"") + Axis(y) + rows + "</svg>\n";
}

}  // namespace musher::fault_injection
