#include "musher/view/metrics/exposition.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

namespace musher::view {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

// The number of bytes of the UTF-8 character that `text` begins with; 0: it begins with none, or
// with NUL.
std::size_t CharacterAt(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const auto continues = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const unsigned first = byte(0);
  if (first < 0x80) return first == 0 ? 0 : 1;
  if (first >= 0xC2 && first <= 0xDF) return continues(1) ? 2 : 0;
  if (first >= 0xE0 && first <= 0xEF) {
    const bool overlong = first == 0xE0 && byte(1) < 0xA0;
    const bool surrogate = first == 0xED && byte(1) > 0x9F;
    return continues(1) && continues(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (first >= 0xF0 && first <= 0xF4) {
    const bool overlong = first == 0xF0 && byte(1) < 0x90;
    const bool beyond = first == 0xF4 && byte(1) > 0x8F;
    return continues(1) && continues(2) && continues(3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

// The shortest text that reads back as `value`.
std::string TextOf(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

// A bound as OpenMetrics wants it: never an integer.
std::string BoundText(double bound) {
  std::string text = TextOf(bound);
  if (std::isfinite(bound) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string_view Trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

// The part of `text` before `separator`; `text` becomes what follows it.
std::string_view Next(std::string_view& text, char separator) {
  const auto end = std::min(text.find(separator), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return Trimmed(part);
}

// The weight of one entry of an Accept header, after its media type; 1 where none can be read.
double WeightOf(std::string_view parameters) {
  while (!parameters.empty()) {
    const std::string_view parameter = Next(parameters, ';');
    if (!parameter.starts_with("q=")) continue;
    double weight = 1;
    std::from_chars(parameter.data() + 2, parameter.data() + parameter.size(), weight);
    return weight;
  }
  return 1;
}

}  // namespace

std::string_view ContentTypeOf(MetricsFormat format) {
  return format == MetricsFormat::kOpenMetrics
             ? "application/openmetrics-text; version=1.0.0; charset=utf-8"
             : "text/plain; version=0.0.4; charset=utf-8";
}

MetricsFormat FormatFor(std::string_view accept) {
  double open_metrics = -1;
  double plain = -1;
  double any = -1;
  while (!accept.empty()) {
    std::string_view entry = Next(accept, ',');
    const std::string_view type = Next(entry, ';');
    const double weight = WeightOf(entry);
    if (type == "application/openmetrics-text") open_metrics = std::max(open_metrics, weight);
    const bool reads_plain = type == "text/plain" || type == "text/*" || type == "text/html";
    if (reads_plain) plain = std::max(plain, weight);
    if (type == "*/*") any = std::max(any, weight);
  }
  if (open_metrics < 0) open_metrics = any;
  return plain > open_metrics ? MetricsFormat::kPrometheus : MetricsFormat::kOpenMetrics;
}

void DurationHistogram::Observe(double seconds) {
  const auto bucket = std::ranges::lower_bound(kBounds, seconds) - kBounds.begin();
  ++counts_[static_cast<std::size_t>(bucket)];
  ++count_;
  sum_ += seconds;
}

void Exposition::Add(double value, std::initializer_list<Label> labels) {
  Line(suffix_, labels, {});
  Put(value);
}

void Exposition::Add(std::uint64_t value, std::initializer_list<Label> labels) {
  Line(suffix_, labels, {});
  Put(value);
}

void Exposition::AddStates(std::span<const std::string_view> states, std::string_view present,
                           std::initializer_list<Label> labels) {
  for (const std::string_view state : states) {
    Line("", labels, {name_, state});
    Put(std::uint64_t{state == present});
  }
}

void Exposition::AddHistogram(const DurationHistogram& histogram,
                              std::initializer_list<Label> labels) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < histogram.counts().size(); ++i) {
    const double bound = i < DurationHistogram::kBounds.size()
                             ? DurationHistogram::kBounds[i]
                             : std::numeric_limits<double>::infinity();
    count += histogram.counts()[i];
    Line("_bucket", labels, {"le", BoundText(bound)});
    Put(count);
  }
  Line("_sum", labels, {});
  Put(histogram.sum());
  Line("_count", labels, {});
  Put(count);
}

std::string Exposition::Finish() && {
  if (format_ == MetricsFormat::kOpenMetrics) text_ += "# EOF\n";
  return std::move(text_);
}

void Exposition::Begin(const Family& family, std::string_view type,
                       std::string_view prometheus_type, std::string_view suffix) {
  const bool open_metrics = format_ == MetricsFormat::kOpenMetrics;
  name_ = family.name;
  suffix_ = suffix;
  const std::string described = open_metrics ? name_ : name_ + suffix_;
  text_ += "# HELP " + described + " ";
  PutEscaped(family.help, open_metrics);
  text_ += "\n# TYPE " + described + " ";
  text_ += open_metrics ? type : prometheus_type;
  text_ += '\n';
  if (!open_metrics || family.unit.empty()) return;
  text_ += "# UNIT " + described + " ";
  text_ += family.unit;
  text_ += '\n';
}

void Exposition::Line(std::string_view suffix, std::initializer_list<Label> labels,
                      const Label& last) {
  text_ += name_;
  text_ += suffix;
  const bool has_last = !last.name.empty();
  if (labels.size() > 0 || has_last) {
    char before = '{';
    for (const Label& label : labels) {
      text_ += std::exchange(before, ',');
      PutLabel(label);
    }
    if (has_last) {
      text_ += before;
      PutLabel(last);
    }
    text_ += '}';
  }
  text_ += ' ';
}

void Exposition::Put(double value) {
  text_ += TextOf(value);
  text_ += '\n';
}

void Exposition::Put(std::uint64_t value) {
  text_ += std::to_string(value);
  text_ += '\n';
}

void Exposition::PutLabel(const Label& label) {
  text_ += label.name;
  text_ += "=\"";
  PutEscaped(label.value, true);
  text_ += '"';
}

void Exposition::PutEscaped(std::string_view text, bool quotes) {
  while (!text.empty()) {
    const std::size_t size = CharacterAt(text);
    const char first = text.front();
    if (size == 0) {
      text_ += kReplacement;
    } else if (first == '\n') {
      text_ += "\\n";
    } else if (first == '\\' || (first == '"' && quotes)) {
      text_ += '\\';
      text_ += first;
    } else {
      text_ += text.substr(0, size);
    }
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
}

}  // namespace musher::view
