#include "musher/test/view/metrics/openmetrics_grammar.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <regex>
#include <set>

namespace musher::testing {
namespace {

const std::set<std::string, std::less<>> kTypes = {
    "counter", "gauge", "histogram", "gaugehistogram", "stateset", "info", "summary", "unknown"};

// Decodes code point by code point; std::nullopt after the first error.
bool IsUtf8WithoutNul(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const unsigned first = static_cast<unsigned char>(text[i]);
    const std::size_t length = first < 0x80    ? 1
                               : first >= 0xF0 ? 4
                               : first >= 0xE0 ? 3
                               : first >= 0xC0 ? 2
                                               : 0;
    if (length == 0 || first > 0xF7 || i + length > text.size()) return false;
    unsigned point = length == 1 ? first : first & (0x7FU >> length);
    for (std::size_t k = 1; k < length; ++k) {
      const unsigned next = static_cast<unsigned char>(text[i + k]);
      if (next >> 6U != 2) return false;
      point = point << 6U | (next & 0x3FU);
    }
    constexpr unsigned kLeast[] = {0, 1, 0x80, 0x800, 0x10000};
    const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
    if (point < kLeast[length] || surrogate || point > 0x10FFFF) return false;
    i += length;
  }
  return true;
}

bool IsMetricName(std::string_view name) {
  static const std::regex form("[a-zA-Z_:][a-zA-Z0-9_:]*");
  return std::regex_match(name.begin(), name.end(), form);
}

bool IsLabelName(std::string_view name) {
  static const std::regex form("[a-zA-Z_][a-zA-Z0-9_]*");
  return std::regex_match(name.begin(), name.end(), form) && !name.starts_with("__");
}

std::optional<double> Number(const std::string& text) {
  static const std::regex real("[+-]?([0-9]+(\\.[0-9]*)?|\\.[0-9]+)([eE][+-]?[0-9]+)?");
  static const std::regex inf("[+-]?inf(inity)?", std::regex::icase);
  static const std::regex nan("nan", std::regex::icase);
  const bool valid =
      std::regex_match(text, real) || std::regex_match(text, inf) || std::regex_match(text, nan);
  return valid ? std::optional(std::strtod(text.c_str(), nullptr)) : std::nullopt;
}

// Reads an escaped string up to an unescaped '"', or to the end where `in_quotes` is false.
// std::nullopt: it is not one.
std::optional<std::string> Unescaped(std::string_view& text, bool in_quotes) {
  std::string plain;
  while (!text.empty()) {
    char c = text.front();
    if (c == '"') return in_quotes ? std::optional(plain) : std::nullopt;
    text.remove_prefix(1);
    if (c == '\\') {
      if (text.empty()) return std::nullopt;
      c = text.front();
      text.remove_prefix(1);
      if (c != 'n' && c != '"' && c != '\\') return std::nullopt;
      if (c == 'n') c = '\n';
    }
    plain += c;
  }
  return in_quotes ? std::nullopt : std::optional(plain);
}

class Parser {
 public:
  ParsedMetrics Parse(std::string_view text) {
    if (!IsUtf8WithoutNul(text)) Fail("is not UTF-8, or contains NUL");
    bool ended = false;
    while (!text.empty()) {
      ++line_;
      const auto end = text.find('\n');
      if (end == std::string_view::npos) Fail("does not end with a line feed");
      const std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(line.size() + 1, text.size()));
      if (ended) Fail("follows # EOF");
      if (line == "# EOF") {
        ended = true;
      } else if (line.starts_with('#')) {
        Descriptor(line);
      } else {
        Sample(line);
      }
    }
    if (!ended) Fail("# EOF is missing");
    EndFamily();
    return std::move(result_);
  }

 private:
  void Fail(const std::string& what) {
    result_.errors.push_back("line " + std::to_string(line_) + ": " + what);
  }

  void Descriptor(std::string_view line) {
    static const std::regex form("# (TYPE|HELP|UNIT) ([^ ]+) ?([^\\n]*)");
    std::cmatch match;
    if (!std::regex_match(line.begin(), line.end(), match, form)) return Fail("not a descriptor");
    const std::string keyword = match[1];
    const std::string name = match[2];
    const std::string rest = match[3];
    if (!IsMetricName(name)) Fail("'" + name + "' is not a metric name");
    if (result_.families.empty() || result_.families.back().name != name) BeginFamily(name);
    ParsedFamily& family = result_.families.back();
    if (!family.samples.empty()) Fail("a descriptor of " + name + " follows its samples");
    if (keyword == "TYPE") {
      if (!family.type.empty()) Fail("a second TYPE of " + name);
      if (!kTypes.contains(rest)) Fail("'" + rest + "' is not a type");
      family.type = rest;
    } else if (keyword == "UNIT") {
      if (std::exchange(family.has_unit, true)) Fail("a second UNIT of " + name);
      if (!rest.empty() && !name.ends_with("_" + rest)) Fail(name + " does not end in its unit");
      family.unit = rest;
    } else {
      if (std::exchange(family.has_help, true)) Fail("a second HELP of " + name);
      std::string_view help = rest;
      const auto plain = Unescaped(help, false);
      if (!plain) Fail("the HELP of " + name + " is not an escaped string");
      family.help = plain.value_or("");
    }
  }

  void BeginFamily(const std::string& name) {
    EndFamily();
    if (!families_.insert(name).second) Fail("the family " + name + " comes twice");
    result_.families.push_back({name, "", "", "", false, false, {}});
  }

  void Sample(std::string_view line) {
    const auto name_end = std::min(line.find_first_of("{ "), line.size());
    ParsedSample sample{std::string(line.substr(0, name_end)), {}, 0};
    line.remove_prefix(name_end);
    if (!IsMetricName(sample.name)) return Fail("'" + sample.name + "' is not a metric name");
    if (line.starts_with('{') && !ReadLabels(line, sample)) return Fail("malformed labels");
    if (!line.starts_with(' ')) return Fail("a space is missing before the value");
    const auto value = Number(std::string(line.substr(1)));
    if (!value) return Fail("'" + std::string(line.substr(1)) + "' is not a number");
    sample.value = *value;
    if (result_.families.empty()) return Fail("a sample without a family");
    if (!all_.insert(Key(sample, "")).second) Fail("the sample comes twice");
    CheckAgainst(result_.families.back(), sample);
    result_.families.back().samples.push_back(std::move(sample));
  }

  bool ReadLabels(std::string_view& line, ParsedSample& sample) {
    static const std::regex form("([^=]*)=\"");
    do {
      line.remove_prefix(1);  // '{' or ','
      std::cmatch match;
      const bool begins = std::regex_search(line.begin(), line.end(), match, form,
                                            std::regex_constants::match_continuous);
      if (!begins) return false;
      const std::string name = match[1];
      line.remove_prefix(static_cast<std::size_t>(match.length(0)));
      const auto value = Unescaped(line, true);
      if (!value) return false;
      line.remove_prefix(1);
      if (!IsLabelName(name)) Fail("'" + name + "' is not a label name");
      for (const auto& [known, of_known] : sample.labels) {
        if (known == name) Fail("the label " + name + " comes twice");
      }
      sample.labels.emplace_back(name, *value);
    } while (line.starts_with(','));
    if (!line.starts_with('}')) return false;
    line.remove_prefix(1);
    return true;
  }

  static std::string Label(const ParsedSample& sample, const std::string& name) {
    for (const auto& [known, value] : sample.labels) {
      if (known == name) return value;
    }
    return "(none)";
  }

  // Its name and sorted labels, without the label `but`.
  static std::string Key(const ParsedSample& sample, const std::string& but) {
    std::map<std::string, std::string> sorted(sample.labels.begin(), sample.labels.end());
    sorted.erase(but);
    std::string key = sample.name;
    for (const auto& [name, value] : sorted) {
      key += '\0' + name + '\0' + value;
    }
    return key;
  }

  void CheckAgainst(const ParsedFamily& family, const ParsedSample& sample) {
    const std::string& type = family.type;
    const auto named = [&](std::string_view suffix) {
      return sample.name == family.name + std::string(suffix);
    };
    if (type == "counter") {
      if (!named("_total")) Fail(sample.name + " is not the _total of counter " + family.name);
      if (!(sample.value >= 0)) Fail("a counter is negative or NaN");
    } else if (type == "info") {
      if (!named("_info")) Fail(sample.name + " is not the _info of " + family.name);
      if (sample.value != 1) Fail("the value of an info is not 1");
    } else if (type == "stateset") {
      if (!named("")) Fail(sample.name + " is not of " + family.name);
      if (Label(sample, family.name) == "(none)") Fail("a state without its label");
      if (sample.value != 0 && sample.value != 1) Fail("a state is neither 0 nor 1");
    } else if (type == "histogram") {
      if (!named("_bucket") && !named("_sum") && !named("_count")) {
        Fail(sample.name + " is not of histogram " + family.name);
      }
    } else if (type == "gauge" || type == "unknown") {
      if (!named("")) Fail(sample.name + " is not of " + family.name);
    } else {
      Fail("a sample of the type '" + type + "', which is not checked");
    }
  }

  void EndFamily() {
    if (result_.families.empty()) return;
    const ParsedFamily& family = result_.families.back();
    if (family.type.empty()) Fail(family.name + " has no TYPE");
    if (!family.has_help) Fail(family.name + " has no HELP");
    if ((family.type == "info" || family.type == "stateset") && !family.unit.empty()) {
      Fail(family.name + " has a unit");
    }
    if (family.name.ends_with("_total") || family.name.ends_with("_info")) {
      Fail("the name of the family " + family.name + " ends like that of a sample");
    }
    if (family.type == "stateset") CheckStates(family);
    if (family.type == "histogram") CheckHistogram(family);
  }

  void CheckStates(const ParsedFamily& family) {
    std::set<std::string> over;
    std::string present;
    for (const ParsedSample& sample : family.samples) {
      const std::string key = Key(sample, family.name);
      if (key == present) continue;
      over.insert(std::exchange(present, key));
      if (over.contains(key)) Fail("the states of one metric of " + family.name + " are apart");
    }
  }

  // Groups of _bucket…, _sum, _count, each with the same labels.
  void CheckHistogram(const ParsedFamily& family) {
    double last_bound = -std::numeric_limits<double>::infinity();
    double last_count = 0;
    bool has_all = false;  // the bucket +Inf
    std::string group;
    for (const ParsedSample& sample : family.samples) {
      const std::string labels = Key({"", sample.labels, 0}, "le");
      if (sample.name.ends_with("_bucket")) {
        const std::string le = Label(sample, "le");
        const auto bound = Number(le);
        if (!bound || (le != "+Inf" && le.find_first_of(".e") == std::string::npos)) {
          Fail("'" + le + "' is not a bound");
        }
        if (has_all || labels != group) last_bound = -std::numeric_limits<double>::infinity();
        if (has_all || labels != group) last_count = 0;
        group = labels;
        if (bound.value_or(0) <= last_bound) Fail("the bounds do not grow");
        if (sample.value < last_count) Fail("the buckets are not cumulative");
        last_bound = bound.value_or(0);
        last_count = sample.value;
        has_all = std::isinf(last_bound);
        continue;
      }
      if (labels != group || !has_all) Fail("a histogram without the bucket +Inf");
      if (sample.name.ends_with("_count") && sample.value != last_count) {
        Fail("the count is not that of the bucket +Inf");
      }
      if (sample.name.ends_with("_sum") && !(sample.value >= 0)) Fail("the sum is negative");
    }
  }

  ParsedMetrics result_;
  std::size_t line_ = 0;
  std::set<std::string> families_;
  std::set<std::string> all_;
};

}  // namespace

const ParsedFamily* ParsedMetrics::Find(std::string_view family) const {
  const auto found = std::ranges::find(families, family, &ParsedFamily::name);
  return found == families.end() ? nullptr : &*found;
}

std::optional<double> ParsedMetrics::Value(std::string_view sample,
                                           const ParsedLabels& labels) const {
  for (const ParsedFamily& family : families) {
    for (const ParsedSample& one : family.samples) {
      if (one.name == sample && one.labels == labels) return one.value;
    }
  }
  return std::nullopt;
}

ParsedMetrics ParseOpenMetrics(std::string_view text) {
  return Parser().Parse(text);
}

}  // namespace musher::testing
